r"""Orbits that close up to a shift.

An orbit of the system M y' = f(y) on a ring repeats itself after a period T up to a shift by s cells,

.. math::  G(y) = S^{-s} \varphi_T(y) = y,

where phi_T takes a state through the period and S moves it to the right by one cell. A travelling wave of speed c on a grid of
spacing h is one with s = 1 and T = h / c; a wave of a chain one with T = 1 / V; a breather one with s = 0. phi_T is
Gauss-Legendre collocation, which is symplectic, and its derivative that of the method itself.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import Settings
from mol_compactons.errors import InputError, IntegrationError, require
from mol_compactons.integrators.base import insist_on_a_band
from mol_compactons.integrators.gauss_legendre import GaussLegendre
from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]

NEUTRAL = 1e-6
"""Directions in which 1 - G' is smaller than this, relative to its largest value, are not corrected: along the orbit, and
along a family of orbits."""

CLOSED = 1e-9
"""An orbit is closed when it misses itself by less than this, relative to its size; Newton's method goes on to round-off."""

MOST_CORRECTIONS = 20

LARGEST_CORRECTION = 0.5
"""An orbit that has to change by more than this, relative to its size, is another one than the guess."""

LARGEST = 4000
"""The most unknowns, for the monodromy matrix is dense."""


@dataclass(frozen=True)
class Period(Settings):
    """The map of an orbit: how long, how far, and by how many steps.

    Parameters
    ----------
    time : float
        The period T > 0, nondimensional.
    shift : int
        By how many cells the orbit has moved to the right after it; negative to the left, 0 for one that stays.
    steps : int
        The steps of Gauss-Legendre collocation in a period.
    order : {4, 6}
        Its order.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    time: float
    shift: int = 1
    steps: int = 10
    order: Literal[4, 6] = 4

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.time > 0, f"Period.time = {self.time:g} must be positive; for a wave it is a cell over its speed.")
        require(1 <= self.steps <= 10**6, f"Period.steps = {self.steps} must lie between 1 and 1000000; 10 is usual.")

    @property
    def integrator(self) -> GaussLegendre:
        """The method."""
        return GaussLegendre(self.time / self.steps, self.order)

    @property
    def halved(self) -> Period:
        """The same with steps half as long."""
        return replace(self, steps=2 * self.steps)


@dataclass(frozen=True, eq=False)
class Orbit:
    """An orbit that is closed up to a shift. All sizes are relative to the largest value of each component.

    Parameters
    ----------
    state : array, shape (components, N)
        A point on it.
    monodromy : array, shape (unknowns, unknowns)
        The derivative G' of the map at it, in the order of ``state.ravel()``.
    residual : float
        The largest |G(y) - y|.
    uncertainty : float
        The largest change that one more correction would make, with the neutral directions left out.
    correction : float
        How far the point is from the guess.
    """

    state: Array
    monodromy: Array
    residual: float
    uncertainty: float
    correction: float


def advance(system: SemiDiscretization, state: Array, period: Period) -> Array:
    """G(y), shape (components, N)."""
    after = period.integrator.start(system, state, period.time).advance(period.time)
    return np.roll(after, -period.shift, axis=1)


def advance_with_derivative(system: SemiDiscretization, state: Array, period: Period) -> tuple[Array, Array]:
    """G(y), and the monodromy matrix G'(y) of shape (unknowns, unknowns)."""
    units = np.eye(system.unknowns).reshape(system.unknowns, *state.shape)
    integration = period.integrator.start(system, state, period.time)
    after, columns = integration.advance_with_tangents(period.time, units)
    shifted = np.roll(columns, -period.shift, axis=2)
    return np.roll(after, -period.shift, axis=1), np.ascontiguousarray(shifted.reshape(system.unknowns, -1).T)


def check_system(system: SemiDiscretization) -> None:
    """Refuse what has no map of its own, no band, or too many unknowns.

    Raises
    ------
    InputError
        In these cases.
    """
    insist_on_a_band(system, "An orbit")
    require(
        not system.explicit_time,
        "An orbit is for a system that is the same at all times, and this one depends on t; choose an equation without t.",
    )
    require(
        system.unknowns <= LARGEST,
        f"The monodromy matrix of {system.unknowns} unknowns is too large; choose a grid of at most "
        f"{LARGEST // system.components} cells.",
    )


def close(system: SemiDiscretization, guess: Array, period: Period) -> Orbit:
    """The orbit near a guess, by Newton's method with the monodromy matrix.

    Along the orbit, and along the family that it belongs to, G moves nothing: of all corrections the smallest is taken.

    Parameters
    ----------
    system : SemiDiscretization
        M y' = f(y).
    guess : array, shape (components, N)
        A state near it.
    period : Period
        The map.

    Raises
    ------
    InputError
        If the system is not one that `check_system` takes, or no orbit is found near the guess.
    """
    check_system(system)
    sizes = np.abs(guess).max(axis=1, keepdims=True)
    require(bool(sizes.any()), "A state of zeros is no guess of an orbit; give a wave.")
    sizes[sizes == 0] = sizes.max()
    state, closed = guess.astype(np.float64), None
    for _ in range(MOST_CORRECTIONS):
        try:
            after, monodromy = advance_with_derivative(system, state, period)
        except IntegrationError as error:
            raise InputError(f"No orbit was found near the guess: {error}") from None
        residual = float((np.abs(after - state) / sizes).max())
        if closed is not None and residual >= closed.residual and closed.residual < CLOSED:
            break
        change = sizes * _smallest_solution(monodromy, after - state, sizes)
        moved, uncertainty = (float((np.abs(part) / sizes).max()) for part in (state - guess, change))
        if closed is None or residual < closed.residual:
            closed = Orbit(state, monodromy, residual, uncertainty, moved)
        if not (moved < LARGEST_CORRECTION and np.isfinite(uncertainty)):
            break
        state = state + change
    if closed is None or not closed.residual < CLOSED:
        missed = "" if closed is None else f" it misses itself by {closed.residual:.1e} of its size;"
        raise InputError(f"No orbit was found near the guess:{missed} choose a finer grid, a longer box or a nearer guess.")
    return closed


def _smallest_solution(monodromy: Array, missed: Array, sizes: Array) -> Array:
    """The smallest solution of (1 - G') d = G(y) - y in the least-squares sense, each component over its size."""
    from scipy.linalg import lstsq

    scale = np.broadcast_to(sizes, missed.shape).ravel()
    matrix = (np.eye(scale.size) - monodromy) * scale / scale[:, None]
    solution = lstsq(matrix, missed.ravel() / scale, cond=NEUTRAL, lapack_driver="gelsy")[0]
    return np.asarray(solution).reshape(missed.shape)
