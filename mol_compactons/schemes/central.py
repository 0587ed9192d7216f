"""Central differences for any equation with a local flux, also for one's own formulas."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons.equations.base import Equation, Linearization
from mol_compactons.errors import InputError, require
from mol_compactons.expressions.kernels import add_shifted
from mol_compactons.grid import Grid, Lattice
from mol_compactons.schemes.base import Scheme
from mol_compactons.schemes.viscosity import Damping, ViscousScheme, damping_order, default_viscosity
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.stencils import central, convolve, difference, stencils_of

Array = NDArray[np.float64]

PROBE_CELLS = 97
"""The size of the ring on which the reach of a flux is measured."""

PROBE_TIMES = (0.0, 0.3713, 5.19)
"""When that is done."""


@dataclass(frozen=True)
class CentralScheme(ViscousScheme):
    """Central differences of one order for the flux, its derivatives in space and the source.

        u' = -D1 F + s - viscosity,   two-way: u' = -D1 v - viscosity,  v' = -D1 F + s - viscosity

    F and s are those of the equation, with the central differences D1, D2, D3 of the order in place of derivatives. Without a
    source the mass is conserved to round-off, and without viscosity a discrete energy, where F is the derivative of one: F =
    a(u) + b(u) D2 g(u) with b = kappa g'. Any equation with a local flux will do.

    Parameters
    ----------
    order : {2, 4, 6}
        The power of h at which the error falls on smooth waves.
    viscosity : float
        The coefficient eps >= 0 of the damping -eps (-1)^(p/2) D^p u, nondimensional.
    grid_viscosity : float
        The same in grid units: nu >= 0 adds nu h^(p-1) to the viscosity, so that it vanishes with the grid.
    viscosity_order : {4, 6}
        The order p of the derivative that damps.

    Raises
    ------
    InputError
        If the viscosity is negative, the grid is too small for the differences, or the equation has no local flux.
    """

    order: Literal[2, 4, 6] = 4
    viscosity: float = 0.0
    grid_viscosity: float = 0.0
    viscosity_order: Literal[4, 6] = 4

    @property
    def formal_order(self) -> float:
        """That of the differences."""
        return float(self.order)

    @classmethod
    def default_for(cls, equation: Equation, grid: Grid | Lattice, speed: float) -> CentralScheme:
        """Fourth order; where nothing disperses at rest, with a damping at the grid scale, in proportion to the speed."""
        if not equation.has_local_flux or disperses_at_rest(equation):
            return cls(order=4, viscosity_order=6)
        return cls(order=4, grid_viscosity=default_viscosity(is_odd(equation), grid.spacing) * speed, viscosity_order=6)

    @classmethod
    def as_check_of(cls, scheme: Scheme, equation: Equation, grid: Grid | Lattice) -> tuple[float, Scheme]:
        """With a damping of the same order."""
        own = cls(order=4, viscosity_order=damping_order(scheme))
        return own.suits(equation), own

    def suits(self, equation: Equation) -> float:
        """Best for equations that know their derivatives; else after the schemes that know more about the equation."""
        if not equation.has_local_flux:
            return 0.0
        return 0.6 if equation.linearized(stencils_of(self.order, 1.0)) else 0.2

    def discretize(self, equation: Equation, grid: Grid | Lattice) -> SemiDiscretization:
        """The semi-discretisation of an equation on a grid."""
        if isinstance(grid, Lattice) or not equation.has_local_flux:
            raise InputError(
                f"CentralScheme is for equations with a local flux on a Grid, not for {type(equation).__name__} on a "
                f"{type(grid).__name__}; choose scheme=none for the one that suits best."
            )
        kernel = _CentralKernel(equation, grid, self)
        require(
            grid.size >= 2 * kernel.reach + 1,
            f"grid.size = {grid.size} is too small: the central scheme of order {self.order} couples {2 * kernel.reach + 1} "
            f"neighbours here; choose at least {2 * kernel.reach + 1} points.",
        )
        second = partial(central(2, self.order).apply, spacing=grid.spacing)
        exact: dict[str, Any] = {"jacobian": partial(kernel.jacobian, kernel.linearization)} if kernel.linearization else {}
        return SemiDiscretization(
            size=grid.size,
            components=len(equation.variables),
            reach=kernel.reach,
            rhs=kernel.rhs,
            invariants=lambda state: equation.invariants(state, grid.spacing, second),
            magnitudes=lambda state: equation.magnitudes(state, grid.spacing, second),
            diagnostics=lambda state: equation.diagnostics(state, grid.spacing),
            damping=kernel.damping.fastest,
            explicit_time=equation.depends_on_time or feels_time(equation),
            **exact,
        )


class _CentralKernel:
    """The right-hand side and the Jacobian. It changes nothing of its own, so that threads may share it."""

    def __init__(self, equation: Equation, grid: Grid, scheme: CentralScheme) -> None:
        self._equation, self._x = equation, grid.x
        self._stencils = stencils_of(scheme.order, grid.spacing)
        self._minus_first = -self._stencils[1]
        self.damping = Damping(scheme, grid.spacing)
        equation.check_grid(grid)
        self.linearization = equation.linearized(self._stencils)
        inner = self.linearization.reach if self.linearization else measured_reach(equation, grid, self._stencils)
        self.reach = max(inner + self._minus_first.size // 2, self.damping.reach)

    def rhs(self, t: float, state: Array, out: Array) -> None:
        """Write -D1 F + s - viscosity, for a two-way equation with v in place of F for the first component."""
        derivative = partial(difference, self._stencils)
        convolve(self._minus_first, self._equation.local_flux(t, self._x, state, derivative), out[-1])
        if self._equation.two_way:
            convolve(self._minus_first, state[1], out[0])
        source = self._equation.local_source(t, self._x, state, derivative)
        if source is not None:
            out[-1] += source
        for u, rate in zip(state, out, strict=True):
            self.damping.add(u, rate)

    def jacobian(self, linearization: Linearization, t: float, state: Array, out: Array) -> None:
        """Write the cyclic diagonals of the derivative of `rhs`, exact except where a slope is infinite."""
        out[:] = 0.0
        reach = self._minus_first.size // 2
        for diagonals, total in zip(linearization.flux(t, self._x, state), out[-1], strict=True):
            add_shifted(self._minus_first, diagonals, _middle(total, diagonals.shape[0] // 2 + reach))
        source = linearization.source(t, self._x, state)
        if source is not None:
            for diagonals, total in zip(source, out[-1], strict=True):
                _middle(total, diagonals.shape[0] // 2)[:] += diagonals
        if self._equation.two_way:
            _middle(out[0, 1], reach)[:] += self._minus_first[:, None]
        for component in range(out.shape[0]):
            self.damping.add_to_diagonals(out[component, component])


def _middle(diagonals: Array, reach: int) -> Array:
    """The diagonals of at most a reach."""
    middle = diagonals.shape[0] // 2
    return diagonals[middle - reach : middle + reach + 1]


def disperses_at_rest(equation: Equation) -> bool:
    """Whether ripples of any small size feel a derivative in the flux in proportion to their size, as in Korteweg-de Vries."""
    background = equation.background
    x = np.arange(PROBE_CELLS) * 2 * np.pi / PROBE_CELLS
    ripple = np.cos(3 * x)
    stencils = stencils_of(2, float(x[1]))
    felt = []
    for size in (1e-2, 1e-12):
        state = np.zeros((len(equation.variables), x.size))
        state[0] = background + (abs(background) or 1.0) * size * ripple
        with np.errstate(all="ignore"):
            dispersed = equation.local_flux(0.0, x, state, partial(difference, stencils))
            local = equation.local_flux(0.0, x, state, lambda values, order: np.zeros_like(values))
        felt.append(float(np.linalg.norm(dispersed - local)) / size)
    return felt[1] > felt[0] / 2 > 0


def feels_time(equation: Equation) -> bool:
    """Whether the flux or the source differs between times, though the equation may not say so."""
    x = np.arange(PROBE_CELLS) * 2 * np.pi / PROBE_CELLS
    stencils = stencils_of(2, float(x[1]))
    state = 1 + 0.3 * np.random.default_rng(0).random((len(equation.variables), x.size))
    with np.errstate(all="ignore"):
        terms = [_terms(equation, x, state, stencils, t) for t in PROBE_TIMES]
    return any(not np.array_equal(terms[0], other, equal_nan=True) for other in terms[1:])


def is_odd(equation: Equation) -> bool:
    """Whether the flux of -u is that of u with the other sign."""
    x = np.arange(PROBE_CELLS) * 2 * np.pi / PROBE_CELLS
    state = np.random.default_rng(0).normal(size=(len(equation.variables), x.size))
    derivative = partial(difference, stencils_of(2, float(x[1])))
    with np.errstate(all="ignore"):
        flux, mirrored = (equation.local_flux(0.0, x, sign * state, derivative) for sign in (1.0, -1.0))
    return bool(np.allclose(flux, -mirrored, rtol=1e-9, atol=1e-9 * np.abs(flux).max()))


def measured_reach(equation: Equation, grid: Grid, stencils: Mapping[int, Array]) -> int:
    """How many neighbours the flux and the source of an equation depend on, found by changing one cell of a ring.

    Raises
    ------
    InputError
        If a change is felt on the whole ring.
    """
    x = grid.left + grid.length * np.arange(PROBE_CELLS) / PROBE_CELLS
    rng = np.random.default_rng(0)
    middle, felt = PROBE_CELLS // 2, {0}
    for level in (1.0, -1.0):
        state = level + 0.3 * rng.random((len(equation.variables), PROBE_CELLS))
        for component in range(len(state)):
            changed = state.copy()
            changed[component, middle] *= 1.1
            for t in PROBE_TIMES:
                with np.errstate(all="ignore"):
                    pairs = [_terms(equation, x, one, stencils, t) for one in (state, changed)]
                different = np.flatnonzero(np.any((pairs[0] != pairs[1]) & np.isfinite(pairs[0]), axis=0))
                felt |= {abs(int(place) - middle) for place in different}
    require(
        max(felt) < middle,
        f"The flux of {type(equation).__name__} couples points {max(felt)} apart; CentralScheme takes a local flux only.",
    )
    return max(felt)


def _terms(equation: Equation, x: Array, state: Array, stencils: Mapping[int, Array], t: float = 0.0) -> Array:
    """The flux and the source, shape (2, N)."""
    derivative = partial(difference, stencils)
    source = equation.local_source(t, x, state, derivative)
    return np.array([equation.local_flux(t, x, state, derivative), np.zeros(x.size) if source is None else source])
