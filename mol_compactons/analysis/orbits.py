r"""Orbits that close up to a shift, and their Floquet multipliers.

An orbit of the system M y' = f(t, y) on a ring repeats itself after a period T up to a shift by s cells,

.. math::  G(y) = S^{-s} \varphi_T(y) = y,

where phi_T takes a state through the period and S moves it to the right by one cell. A travelling wave of speed c on a grid of
spacing h is one with s = 1 and T = h / c; a wave of a chain one with T = 1 / V; a breather one with s = 0. What becomes of small
changes of it is the monodromy matrix G'(y), whose eigenvalues mu are the multipliers: a change grows by |mu| in each period.
One of them is 1, that of the flow along the orbit, which for a wave is its translation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import Settings
from mol_compactons.errors import InputError, IntegrationError, require
from mol_compactons.integrators.base import insist_on_a_band
from mol_compactons.integrators.gauss_legendre import GaussLegendre
from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

NEUTRAL = 1e-6
"""Directions in which G - 1 is smaller than this, relative to its largest value, are not corrected: along the orbit, and along
a family of orbits."""

CLOSED = 1e-11
"""An orbit is closed when it misses itself by less than this, relative to its size; Newton's method goes on to round-off."""

MOST_CORRECTIONS = 20

LARGEST_CORRECTION = 0.5
"""An orbit that has to change by more than this, relative to its size, is another one than the guess."""

LARGEST = 4000
"""The most unknowns, for the monodromy matrix is dense."""

DENSE = 1600
"""Up to so many unknowns all multipliers are found; beyond, the largest."""

CERTAIN = 1e-3
"""Where the bar of the largest multiplier is wider than this nothing is called stable."""


@dataclass(frozen=True)
class Period(Settings):
    """The map of an orbit: how long, how far, and by how many steps.

    Parameters
    ----------
    time : float
        The period T > 0, nondimensional.
    shift : int
        By how many cells the orbit has moved to the right after it; negative to the left.
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
    """An orbit that is closed up to a shift.

    Parameters
    ----------
    state : array, shape (components, N)
        A point on it.
    monodromy : array, shape (unknowns, unknowns)
        The derivative of the map at it, in the order of ``state.ravel()``.
    residual : float
        The largest |G(y) - y|, each component relative to its largest value.
    correction : float
        How far the point is from the guess, in the same measure.
    """

    state: Array
    monodromy: Array
    residual: float
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
    require(not system.explicit_time, "An orbit is for a system that is the same at all times; this one depends on t.")
    require(
        system.unknowns <= LARGEST,
        f"The monodromy matrix of {system.unknowns} unknowns is too large; choose a grid of at most "
        f"{LARGEST // system.components} cells.",
    )


def close(system: SemiDiscretization, guess: Array, period: Period) -> Orbit:
    """The orbit near a guess, by Newton's method with the monodromy matrix.

    Where directions are neutral, along the orbit and along the family that it belongs to, the smallest correction is taken.

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
    sizes[sizes == 0] = sizes.max() or 1.0
    state, best = guess.astype(np.float64), np.inf
    closed: Orbit | None = None
    for _ in range(MOST_CORRECTIONS):
        try:
            after, monodromy = advance_with_derivative(system, state, period)
        except IntegrationError as error:
            raise InputError(f"No orbit was found near the guess: {error}") from None
        residual = float((np.abs(after - state) / sizes).max())
        if residual >= best and best < CLOSED:
            break
        correction = float((np.abs(state - guess) / sizes).max())
        if residual < best:
            closed, best = Orbit(state, monodromy, residual, correction), residual
        if not correction < LARGEST_CORRECTION:
            break
        state = state + sizes * _smallest_solution(monodromy, (after - state), sizes)
    if closed is None or best > CLOSED:
        raise InputError(
            f"No orbit was found near the guess: it misses itself by {best:.1e} after {period.time:g} and a shift of "
            f"{period.shift}; choose a finer grid, a longer box, or a guess that is nearer."
        )
    return closed


def _smallest_solution(monodromy: Array, missed: Array, sizes: Array) -> Array:
    """The smallest solution of (1 - G') d = G(y) - y in the least-squares sense, each component over its size."""
    from scipy.linalg import lstsq

    scale = np.broadcast_to(sizes, missed.shape).ravel()
    matrix = (np.eye(scale.size) - monodromy) * scale / scale[:, None]
    solution = lstsq(matrix, missed.ravel() / scale, cond=NEUTRAL, lapack_driver="gelsy")[0]
    return np.asarray(solution).reshape(missed.shape)


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Multipliers, the largest first, shape (K,).

    Parameters
    ----------
    values : array
        The multipliers mu.
    conditions : array
        1 / |<y, x>| for unit eigenvectors x to the right and y to the left: by how much a change of the matrix changes mu.
    residuals : array
        |G' x - mu x|.
    modes : array, shape (K, unknowns)
        x.
    """

    values: ComplexArray
    conditions: Array
    residuals: Array
    modes: ComplexArray


def spectrum(monodromy: Array, count: int) -> Spectrum:
    """The multipliers of a monodromy matrix: all of them, or at most `count` of the largest of a matrix above `DENSE`."""
    values, left, right = _eigenpairs(monodromy, count)
    order = np.argsort(-np.abs(values), kind="stable")
    values, left, right = values[order], left[:, order], right[:, order]
    product = np.abs(np.sum(left.conj() * right, axis=0))
    residuals = np.linalg.norm(monodromy @ right - right * values, axis=0)
    return Spectrum(values, 1 / np.maximum(product, np.finfo(float).tiny), residuals, right.T)


def _eigenpairs(matrix: Array, count: int) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Eigenvalues with unit eigenvectors to the left and to the right, in columns."""
    from scipy.linalg import eig

    if matrix.shape[0] > DENSE:
        found = _largest(matrix, count)
        if found is not None:
            return found
    values, left, right = eig(matrix, left=True, right=True)
    return values, left, right


def _largest(matrix: Array, count: int) -> tuple[ComplexArray, ComplexArray, ComplexArray] | None:
    """The same for the largest only, by Arnoldi's method; None where it does not find them."""
    from scipy.sparse.linalg import ArpackNoConvergence, eigs

    def largest(one: Array) -> tuple[ComplexArray, ComplexArray]:
        start = np.random.default_rng(0).normal(size=one.shape[0])
        try:
            values, vectors = eigs(one, k=count, ncv=min(20 * count, one.shape[0] - 1), v0=start)
        except ArpackNoConvergence as error:
            values, vectors = error.eigenvalues, error.eigenvectors
        return np.asarray(values), np.asarray(vectors)

    values, right = largest(matrix)
    others, left = largest(np.ascontiguousarray(matrix.T))
    if not (values.size and others.size):
        return None
    # Those to the left belong to the conjugate values of the transposed matrix.
    partner = np.abs(others[None, :] - values[:, None]).argmin(axis=1)
    return values, left[:, partner].conj(), right


def bars(spectrum: Spectrum, orbit: Orbit) -> Array:
    """How uncertain each multiplier is by rounding and by the orbit's residual, shape (K,).

    The condition of the multiplier times the change of the matrix that these make: |G'| times the rounding error of its
    columns and the residual, and what the eigenpair misses.
    """
    norm = float(np.linalg.norm(orbit.monodromy, 2))
    change = norm * (10 * np.finfo(float).eps + orbit.residual)
    return np.asarray(spectrum.conditions * (change + spectrum.residuals))


def nearest(values: ComplexArray, others: ComplexArray) -> Array:
    """The distance of each value to the nearest of others."""
    return np.asarray(np.abs(values[:, None] - others[None, :]).min(axis=1))


def verdict(values: ComplexArray, errors: Array) -> Literal["stable", "unstable", "undecided"]:
    """Whether a multiplier lies outside the unit circle by more than its bar.

    "stable" is neutral stability: none does, and no bar that reaches out of the circle is wider than `CERTAIN`.
    """
    outside = np.abs(values) - 1
    if (outside > errors).any():
        return "unstable"
    return "undecided" if (outside + errors > CERTAIN).any() else "stable"


Refine = Callable[[Period], tuple[Orbit, Spectrum]]


def with_steps_halved(refine: Refine, period: Period, found: Spectrum, count: int) -> Array:
    """How far the largest `count` multipliers move when the steps are halved, shape (count,)."""
    finer: Any = refine(period.halved)[1]
    return nearest(found.values[:count], finer.values)
