"""The compact scheme of the paper, after de Frutos, Lopez-Marcos and Sanz-Serna, for any flux a + b g_xx."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons import stencils
from mol_compactons.equations.base import Equation
from mol_compactons.equations.flux import DispersiveFlux, evaluate_flux
from mol_compactons.errors import InputError, require
from mol_compactons.expressions.kernels import add_shifted
from mol_compactons.grid import Grid, Lattice
from mol_compactons.runtime.compiled import compiled
from mol_compactons.runtime.workspace import Workspace
from mol_compactons.schemes.base import Scheme
from mol_compactons.schemes.viscosity import Damping, ViscousScheme, damping_order, default_viscosity
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.stencils import add_convolution, convolve

Array = NDArray[np.float64]

SECOND_DIFFERENCES = {
    "wide": stencils.SECOND_WIDE,
    "nearest": stencils.SECOND_NEAREST,
    "five_point": stencils.SECOND_FIVE_POINT,
}

MARGIN = 4
"""How far D1 and S together reach."""


@dataclass(frozen=True)
class CompactScheme(ViscousScheme):
    """The paper's compact finite differences with a mass matrix and artificial viscosity.

        M W' + D1 [a(W) + b(W) S g(W)] + eps D4 W = 0

    with M = (1, 26, 66, 26, 1) / 120, D1 = (-1, -10, 0, 10, 1) / (24 h), D4 = (1, -4, 6, -4, 1) / h^4 (or -D6, the sixth
    difference) and S one of three second differences. Without viscosity it conserves the mass and, where the flux is
    variational, a discrete energy. A two-way equation has M u' + D1 v + eps D4 u = 0 and M v' + D1 F + eps D4 v = 0.

    Parameters
    ----------
    second_difference : {"wide", "nearest", "five_point"}
        The stencil of S: the paper's (1, 0, -2, 0, 1) / (4 h^2), second order; (1, -2, 1) / h^2, second order; or
        (-1, 16, -30, 16, -1) / (12 h^2), which makes the whole scheme fourth order. Without viscosity only "wide"
        survives the edge of a compacton.
    viscosity : float
        The coefficient eps >= 0 of the damping -eps (-1)^(p/2) D^p W, nondimensional. The paper takes 1e-3.
    grid_viscosity : float
        The same in grid units: nu >= 0 adds nu h^(p-1) to the viscosity, so that it vanishes with the grid.
    viscosity_order : {4, 6}
        The order p of the derivative that damps; the paper takes 4.

    Raises
    ------
    InputError
        If the viscosity is negative, or the grid is too small for the stencil.

    Notes
    -----
    Source: de Frutos, Lopez-Marcos and Sanz-Serna, J. Comput. Phys. 120 (1995) 248, doi:10.1006/jcph.1995.1161, as
    modified by Vladimirov and Skurativskyi (2015). The paper prints h^2 for the 4 h^2 of "wide"; as printed the scheme
    solves an equation with four times the dispersion.
    """

    second_difference: Literal["wide", "nearest", "five_point"] = "wide"
    viscosity: float = 0.0
    grid_viscosity: float = 0.0
    viscosity_order: Literal[4, 6] = 4

    @property
    def formal_order(self) -> float:
        """That of the second difference."""
        return SECOND_DIFFERENCES[self.second_difference].order

    def suits(self, equation: Equation) -> float:
        """Every flux of the form a + b g_xx."""
        return 0.5 if equation.dispersive_flux is not None else 0.0

    @classmethod
    def default_for(cls, equation: Equation, grid: Grid | Lattice, speed: float) -> CompactScheme:
        """Fourth order, with a damping at the scale of the grid."""
        return cls("five_point", grid_viscosity=default_viscosity(True, grid.spacing) * speed, viscosity_order=6)

    @classmethod
    def as_check_of(cls, scheme: Scheme, equation: Equation, grid: Grid | Lattice) -> tuple[float, Scheme]:
        """With the second difference that needs the least damping, and one of the same order."""
        own = cls("wide", viscosity_order=damping_order(scheme))
        return own.suits(equation), own

    def discretize(self, equation: Equation, grid: Grid | Lattice) -> SemiDiscretization:
        """The semi-discretisation of an equation on a grid.

        Raises
        ------
        InputError
            If the grid has fewer points than the Jacobian couples, or the flux has another form.
        """
        flux = equation.dispersive_flux
        if flux is None or isinstance(grid, Lattice):
            raise InputError(
                f"CompactScheme is for equations with a flux a(u) + b(u) g(u)_xx on a Grid, not for {type(equation).__name__} "
                f"on a {type(grid).__name__}; scheme=none takes the scheme that suits best."
            )
        second = SECOND_DIFFERENCES[self.second_difference]
        damping = Damping(self, grid.spacing)
        kernel: _CompactKernel | _SourceKernel
        kernel = _CompactKernel(flux, equation.two_way, grid.size, grid.spacing, second, damping)
        if equation.has_source:
            kernel = _SourceKernel(equation, grid, kernel, second.order)
        reach = kernel.reach
        require(
            grid.size >= 2 * reach + 1,
            f"grid.size = {grid.size} is too small: the compact scheme couples {2 * reach + 1} neighbours; choose at "
            f"least {2 * reach + 1} points.",
        )
        bend = partial(second.apply, spacing=grid.spacing)
        return SemiDiscretization(
            size=grid.size,
            components=len(equation.variables),
            reach=reach,
            rhs=kernel.rhs,
            jacobian=kernel.jacobian,
            invariants=lambda state: equation.invariants(state, grid.spacing, bend),
            magnitudes=lambda state: equation.magnitudes(state, grid.spacing, bend),
            diagnostics=lambda state: equation.diagnostics(state, grid.spacing),
            mass=np.array(stencils.COMPACT_MASS.coefficients),
            damping=damping.fastest,
            explicit_time=equation.depends_on_time,
        )


class _SourceKernel:
    """The same with M s added for a source s, in which derivatives are central differences."""

    def __init__(self, equation: Equation, grid: Grid, kernel: _CompactKernel, order: int) -> None:
        self._equation, self._x, self._kernel = equation, grid.x, kernel
        self._stencils = stencils.stencils_of(order, grid.spacing)
        self._mass = np.array(stencils.COMPACT_MASS.coefficients)
        self._work = Workspace(grid.size)
        linearization = equation.linearized(self._stencils)
        if linearization is None:
            raise InputError(
                f"CompactScheme takes a source whose derivatives are known, as those of a CustomEquation, not that of "
                f"{type(equation).__name__}; choose CentralScheme."
            )
        equation.check_grid(grid)
        self._linearization = linearization
        self.reach = max(kernel.reach, linearization.reach + self._mass.size // 2)

    def rhs(self, t: float, state: Array, out: Array) -> None:
        """Write the right-hand side."""
        self._kernel.rhs(t, state, out)
        source = self._equation.local_source(t, self._x, state, partial(stencils.difference, self._stencils))
        assert source is not None
        (added,) = self._work.arrays
        convolve(self._mass, source, added)
        out[-1] += added

    def jacobian(self, t: float, state: Array, out: Array) -> None:
        """Write its cyclic diagonals."""
        middle = out.shape[2] // 2
        inner = np.zeros((*out.shape[:2], 2 * self._kernel.reach + 1, out.shape[3]))
        self._kernel.jacobian(t, state, inner)
        out[:] = 0.0
        out[:, :, middle - self._kernel.reach : middle + self._kernel.reach + 1] = inner
        source = self._linearization.source(t, self._x, state)
        assert source is not None
        reach = source.shape[1] // 2 + self._mass.size // 2
        for diagonals, total in zip(source, out[-1], strict=True):
            add_shifted(self._mass, diagonals, total[middle - reach : middle + reach + 1])


class _CompactKernel:
    """The right-hand side and the Jacobian."""

    def __init__(
        self, flux: DispersiveFlux, two_way: bool, size: int, spacing: float, second: stencils.Stencil, damping: Damping
    ) -> None:
        self._flux = flux
        self._two_way = two_way
        self.reach = stencils.COMPACT_FIRST.reach + second.reach
        self._table = flux.table
        self._first = stencils.COMPACT_FIRST.scaled(spacing)
        self._minus_first = -self._first
        self._second = second.scaled(spacing)
        self._damping = damping
        self._work = Workspace(size, size, size, size)

    def rhs(self, t: float, state: Array, out: Array) -> None:
        """Write -D1 F - eps D4 u, for a two-way equation with v in place of F for the first component."""
        damping, (b, g, f, difference) = self._damping.coefficients, self._work.arrays
        if self._table is None:
            self._flux.evaluate(state[0], b, g, f)
            _rates(self._minus_first, self._second, damping, state, b, g, f, difference, out)
        else:
            table = self._table
            _rates_of_power_laws(table, self._minus_first, self._second, damping, state, b, g, f, difference, out)

    def jacobian(self, t: float, state: Array, out: Array) -> None:
        """Write the cyclic diagonals of the derivative of `rhs`; regularised at zeros of u where b has a singular slope."""
        u, out[:] = state[0], 0
        b_slope, slope, local = np.empty((3, u.size))
        b, g, f, difference = self._work.arrays
        self._flux.evaluate(u, b, g, f)
        self._flux.slopes(u, b_slope, slope, local)
        convolve(self._second, g, difference)
        _add_product(b_slope, difference, local)
        local, b, slope = (np.concatenate((c[-MARGIN:], c, c[:MARGIN])) for c in (local, b, slope))
        _subtract_flux_jacobian(self._first, self._second, local, b, slope, out[-1, 0])
        reach = (out.shape[2] - 1) // 2
        near = slice(reach - 2, reach + 3)
        if self._two_way:
            out[0, 1, near] -= self._first[:, None]
        for component in range(out.shape[0]):
            self._damping.add_to_diagonals(out[component, component])


@compiled
def _rates_of_power_laws(
    table: Array,
    minus_first: Array,
    second: Array,
    damping: Array,
    state: Array,
    b: Array,
    g: Array,
    f: Array,
    difference: Array,
    out: Array,
) -> None:
    """The right-hand side in one call, the flux from its table; b, g, f and difference are scratch."""
    evaluate_flux(table, state[0], b, g, f)
    _rates(minus_first, second, damping, state, b, g, f, difference, out)


@compiled
def _rates(
    minus_first: Array,
    second: Array,
    damping: Array,
    state: Array,
    b: Array,
    g: Array,
    f: Array,
    difference: Array,
    out: Array,
) -> None:
    """The right-hand side from b, g and a, of which a, in f, becomes the flux; difference is scratch."""
    convolve(second, g, difference)
    _add_product(b, difference, f)
    convolve(minus_first, f, out[-1])
    if state.shape[0] > 1:
        convolve(minus_first, state[1], out[0])
    if damping.size > 1:
        for component in range(state.shape[0]):
            add_convolution(damping, state[component], out[component])


@compiled
def _add_product(b: NDArray[np.float64], c: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    for j in range(out.size):
        out[j] += b[j] * c[j]


@compiled
def _subtract_flux_jacobian(
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    local: NDArray[np.float64],
    b: NDArray[np.float64],
    slope: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Subtract the cyclic diagonals of D1 dF/du, where dF_j/du_k = local_j delta_jk + b_j S_jk slope_k.

    local, b and slope have a periodic margin of `MARGIN`.
    """
    reach, size = (out.shape[0] - 1) // 2, out.shape[1]
    bent = np.empty(size + 4)
    for p in range(-2, 3):
        if second[p + 2] != 0.0:
            inner, outer = b[MARGIN - 2 :], slope[MARGIN - 2 + p :]
            for j in range(bent.size):
                bent[j] = second[p + 2] * inner[j] * outer[j]
            for m in range(-2, 3):
                _subtract(first[m + 2], bent[m + 2 :], out[reach + m + p])
    for m in range(-2, 3):
        _subtract(first[m + 2], local[MARGIN + m :], out[reach + m])


@compiled
def _subtract(factor: float, values: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    """Subtract factor times the values, of which there may be more than needed."""
    if factor != 0.0:
        for j in range(out.size):
            out[j] -= factor * values[j]
