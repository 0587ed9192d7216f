"""The conservative scheme: a flux form that keeps mass and momentum to round-off, for any n and any sign of W."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons import stencils
from mol_compactons.equations.base import Equation
from mol_compactons.equations.flux import PowerLaw, power_law
from mol_compactons.equations.granular import GranularCompacton
from mol_compactons.equations.rosenau_hyman import RosenauHyman
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.runtime.compiled import compiled
from mol_compactons.runtime.workspace import Workspace
from mol_compactons.schemes.base import Scheme
from mol_compactons.schemes.entropy_flux import (
    needs_powers,
    neighbours,
    subtract_difference,
    subtract_difference_jacobian,
    two_point_fluxes,
    two_point_slopes,
)
from mol_compactons.schemes.rosenau_hyman import RosenauHymanKernel, is_conservative
from mol_compactons.schemes.viscosity import Damping, ViscousScheme, damping_order, default_viscosity
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.stencils import add_convolution

Array = NDArray[np.float64]

WEIGHTS = {2: (1.0,), 4: (4 / 3, -1 / 3), 6: (3 / 2, -3 / 5, 1 / 10)}
"""Richardson's weights of the strides 1, 2, 3 for each order: each removes the next even power of h."""


@dataclass(frozen=True)
class ConservativeScheme(ViscousScheme):
    r"""Skew-symmetric finite differences in flux form for the granular compacton equation and K(m, n); no mass matrix.

    With a = |W|^(n-1) and V = W_x the flux is F = a W + (n+1)/4 [(a V)_x + a V_x], whose bracket is skew-symmetric in V.
    On a grid with the stride s, H = s h:

        V_(j+1/2) = (W_(j+s) - W_j) / H,    a_(j+1/2) = (|W_j|^(n-1) + |W_(j+s)|^(n-1)) / 2
        f*(u, v)  = (|v|^(n+1) - |u|^(n+1)) / ((n+1) (v - u))
        D_(j+1/2) = (a_(j+1/2+s) + a_(j+1/2)) V_(j+1/2+s) - (a_(j+1/2-s) + a_(j+1/2)) V_(j+1/2-s)
        F_(j+1/2) = f*(W_j, W_(j+s)) + (n+1) / (8 H) D_(j+1/2)
        W_j'      = -sum_s w_s (F_(j+1/2) - F_(j+1/2-s)) / H - viscosity

    Mass and momentum are conserved by each stride alone, for any n > 1, any sign of W and every order: W cannot blow up,
    since its norm is fixed. See docs/schemes.md for the proof. For K(m, n), u_t + (u^m)_x + (u^n)_xxx = 0, the same holds
    with v = u^n in place of W in the sum by parts: mass and Int u^(n+1) are kept, see `RosenauHymanKernel`.

    Parameters
    ----------
    order : {2, 4, 6}
        The formal order in space; the half-bandwidth of the Jacobian is the same.
    viscosity : float
        The coefficient eps >= 0 of the damping -eps (-1)^(p/2) D^p W, nondimensional.
    grid_viscosity : float
        The same in grid units: nu >= 0 adds nu h^(p-1) to the viscosity, so that it vanishes with the grid.
    viscosity_order : {4, 6}
        The order p of the derivative that damps; 6 acts closer to the scale of the grid.

    Raises
    ------
    InputError
        If a value is out of range, the equation is another one, or the grid is too small.

    Notes
    -----
    f* is Tadmor's entropy-conservative two-point flux for the entropy W^2 / 2 (Math. Comp. 49 (1987) 91,
    doi:10.1090/S0025-5718-1987-0890255-3). The dispersive part is our own.
    """

    order: Literal[2, 4, 6] = 4
    viscosity: float = 0.0
    grid_viscosity: float = 0.0
    viscosity_order: Literal[4, 6] = 4

    @classmethod
    def default_for(cls, equation: Equation, grid: Grid | Lattice, speed: float) -> ConservativeScheme:
        """Fourth order, with a damping at the scale of the grid that is proportional to the speed of the waves."""
        odd = not isinstance(equation, RosenauHyman) or equation.is_odd
        return cls(order=4, grid_viscosity=default_viscosity(odd, grid.spacing) * speed, viscosity_order=6)

    @property
    def formal_order(self) -> float:
        """The order."""
        return self.order

    def suits(self, equation: Equation) -> float:
        """The granular compacton equation, and K(m, n) where its form allows it."""
        return float((isinstance(equation, GranularCompacton) or is_conservative(equation)) and not equation.has_source)

    @classmethod
    def as_check_of(cls, scheme: Scheme, equation: Equation, grid: Grid | Lattice) -> tuple[float, Scheme]:
        """With a damping of the same order."""
        own = cls(order=4, viscosity_order=damping_order(scheme))
        return own.suits(equation), own

    def discretize(self, equation: Equation, grid: Grid | Lattice) -> SemiDiscretization:
        """The semi-discretisation of the granular compacton equation, or K(m, n), on a grid."""
        if not isinstance(equation, GranularCompacton | RosenauHyman) or equation.has_source or isinstance(grid, Lattice):
            raise InputError(
                "ConservativeScheme is for GranularCompacton and RosenauHyman without a source on a Grid, not for "
                f"{type(equation).__name__} on a {type(grid).__name__}; choose CompactScheme or, for a chain, "
                "NearestNeighbours."
            )
        damping = Damping(self, grid.spacing)
        reach = max(self.order, damping.reach)
        require(
            grid.size >= 2 * reach + 1,
            f"grid.size = {grid.size} is too small: the conservative scheme of order {self.order} couples {2 * reach + 1} "
            f"neighbours; choose at least {2 * reach + 1} points.",
        )
        weights = WEIGHTS[self.order]
        second = stencils.SECOND_NEAREST if self.order == 2 else stencils.SECOND_FIVE_POINT
        kernel: _ConservativeKernel | RosenauHymanKernel
        if isinstance(equation, RosenauHyman):
            kernel = RosenauHymanKernel(equation, grid.size, grid.spacing, weights, damping)
        else:
            kernel = _ConservativeKernel(equation.n, grid.size, grid.spacing, weights, damping)
        bend = partial(second.apply, spacing=grid.spacing)
        return SemiDiscretization(
            size=grid.size,
            components=1,
            reach=reach,
            rhs=kernel.rhs,
            jacobian=kernel.jacobian,
            invariants=lambda state: equation.invariants(state, grid.spacing, bend),
            magnitudes=lambda state: equation.magnitudes(state, grid.spacing, bend),
            damping=damping.fastest,
        )


class _ConservativeKernel:
    """The right-hand side and the Jacobian."""

    def __init__(self, n: float, size: int, spacing: float, weights: tuple[float, ...], damping: Damping) -> None:
        self._n = n
        self._size, self._spacing = size, spacing
        self._weights = np.array(weights)
        self._law = PowerLaw(1, n - 1)
        self._damping = damping
        self._margin = 2 * len(weights)
        extended = size + 2 * self._margin
        self._work = Workspace(extended, extended, extended, extended, size + len(weights))

    def rhs(self, t: float, state: Array, out: Array) -> None:
        """Write -sum_s w_s N_s(W) and the damping."""
        w, a, _, powers, flux = self._work.arrays
        damping = self._damping.coefficients
        _rate(state[0], w, a, powers, self._margin, self._weights, self._n, self._spacing, flux, damping, out[0])

    def jacobian(self, t: float, state: Array, out: Array) -> None:
        """Write the cyclic diagonals of the derivative of `rhs`; regularised at zeros of W where n < 2."""
        u, margin = state[0], self._margin
        w, a, slope, powers, _ = self._work.arrays
        w[margin:-margin] = u
        w[:margin], w[-margin:] = u[-margin:], u[:margin]
        self._law.evaluate(w, a)
        self._law.derivative().evaluate(w, slope)
        _take_powers(w, a, self._n, powers)
        out[:] = 0
        for index, weight in enumerate(self._weights):
            _subtract_divergence_jacobian(w, a, slope, powers, margin, index + 1, weight, self._n, self._spacing, out[0, 0])
        self._damping.add_to_diagonals(out[0, 0])


@compiled
def _rate(
    u: Array,
    w: Array,
    a: Array,
    powers: Array,
    margin: int,
    weights: Array,
    n: float,
    spacing: float,
    flux: Array,
    damping: Array,
    out: Array,
) -> None:
    """The right-hand side in one call; w, a, powers and flux are scratch, all but the last with a periodic margin."""
    size = u.size
    w[margin : margin + size] = u
    w[:margin] = u[size - margin :]
    w[margin + size :] = u[:margin]
    power_law(w, 1.0, n - 1.0, False, False, a)
    _take_powers(w, a, n, powers)
    out[:] = 0.0
    for index in range(weights.size):
        _subtract_divergence(w, a, powers, margin, index + 1, weights[index], n, spacing, flux, out)
    if damping.size > 1:
        add_convolution(damping, u, out)


@compiled
def _take_powers(w: Array, a: Array, n: float, powers: Array) -> None:
    """Write |w|^n = a |w|, where the two-point fluxes need it."""
    if needs_powers(n):
        for k in range(w.size):
            powers[k] = a[k] * abs(w[k])


@compiled
def _subtract_divergence(
    w: Array,
    a: Array,
    powers: Array,
    margin: int,
    stride: int,
    weight: float,
    n: float,
    spacing: float,
    flux: Array,
    out: Array,
) -> None:
    """Subtract weight N_s(W); w and a = |w|^(n-1) have a periodic margin."""
    step = stride * spacing
    factor = (n + 1) / (16 * step * step)
    count = out.size + stride
    first = margin - 2 * stride
    left, u, v, right = neighbours(w, first, stride)
    a_left, a_u, a_v, a_right = neighbours(a, first, stride)
    _, of_u, of_v, _ = neighbours(powers, first, stride)
    two_point_fluxes(u, v, of_u, of_v, n, flux[:count])
    for k in range(count):
        after, before = a_right[k] + 2 * a_v[k] + a_u[k], a_v[k] + 2 * a_u[k] + a_left[k]
        flux[k] += factor * (after * (right[k] - v[k]) - before * (u[k] - left[k]))
    subtract_difference(flux, stride, weight / step, out)


@compiled
def _subtract_divergence_jacobian(
    w: Array,
    a: Array,
    slope: Array,
    powers: Array,
    margin: int,
    stride: int,
    weight: float,
    n: float,
    spacing: float,
    out: Array,
) -> None:
    """Subtract the cyclic diagonals of weight dN_s/dW; slope is the derivative of a."""
    step = stride * spacing
    factor = (n + 1) / (16 * step * step)
    count, first = out.shape[1] + stride, margin - 2 * stride
    derivatives = np.empty((4, count))
    by_left, by_u, by_v, by_right = derivatives[0], derivatives[1], derivatives[2], derivatives[3]
    left, u, v, right = neighbours(w, first, stride)
    a_left, a_u, a_v, a_right = neighbours(a, first, stride)
    _, of_u, of_v, _ = neighbours(powers, first, stride)
    s_left, s_u, s_v, s_right = neighbours(slope, first, stride)
    two_point_slopes(u, v, of_u, of_v, n, by_u, by_v)
    for k in range(count):
        after, before = a_right[k] + 2 * a_v[k] + a_u[k], a_v[k] + 2 * a_u[k] + a_left[k]
        ahead, behind = right[k] - v[k], u[k] - left[k]
        by_left[k] = factor * (before - s_left[k] * behind)
        by_u[k] += factor * (s_u[k] * ahead - 2 * s_u[k] * behind - before)
        by_v[k] += factor * (2 * s_v[k] * ahead - s_v[k] * behind - after)
        by_right[k] = factor * (s_right[k] * ahead + after)
    subtract_difference_jacobian(derivatives, stride, weight / step, out)
