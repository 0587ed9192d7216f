"""The conservative scheme for the Rosenau-Hyman equation: it keeps the mass and Int u^(n+1) to round-off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mol_compactons.equations.base import Equation
from mol_compactons.equations.flux import PowerLaw
from mol_compactons.equations.rosenau_hyman import RosenauHyman
from mol_compactons.errors import require
from mol_compactons.runtime.compiled import compiled
from mol_compactons.runtime.workspace import Workspace
from mol_compactons.schemes.entropy_flux import (
    needs_powers,
    neighbours,
    subtract_difference,
    subtract_difference_jacobian,
    two_point_fluxes,
    two_point_slopes,
)
from mol_compactons.schemes.viscosity import Damping

Array = NDArray[np.float64]


def is_conservative(equation: Equation) -> bool:
    """Whether an equation is a K(m, n) in which v^(m/n) is a function of v = u^n."""
    if not isinstance(equation, RosenauHyman):
        return False
    return equation.is_odd or equation.m == equation.n


class RosenauHymanKernel:
    """The right-hand side and the Jacobian.

    In v = u^n, the derivative of the energy u^(n+1) / (n+1), the flux is v^(m/n) + v_xx. With the stride s, H = s h:

        F_(j+1/2) = f*(v_j, v_(j+s)) + (v_(j+2s) - v_(j+s) - v_j + v_(j-s)) / (2 H^2)
        u_j'      = -sum_s w_s (F_(j+1/2) - F_(j+1/2-s)) / H - viscosity

    f* is the mean of v^(m/n) between its arguments, so that the sum of v f* times the difference of v telescopes.

    Raises
    ------
    InputError
        If v^(m/n) is no function of v: in the classical form with m other than n.
    """

    def __init__(
        self, equation: RosenauHyman, size: int, spacing: float, weights: tuple[float, ...], damping: Damping
    ) -> None:
        require(
            is_conservative(equation),
            f"ConservativeScheme takes K(m, n) for m = n, for odd m and n, or with absolute=True, not K({equation.m:g}, "
            f"{equation.n:g}) in the classical form; choose CompactScheme, or absolute=True.",
        )
        self._power = equation.dispersive_flux.g
        self._ratio = equation.m / equation.n
        self._spacing, self._weights, self._damping = spacing, weights, damping
        self._margin = 2 * len(weights)
        self._law = PowerLaw(1, self._ratio)
        self._work = Workspace(size + 2 * self._margin, size + 2 * self._margin, size, size + len(weights))

    def _extend(self, u: Array, v: Array, powers: Array) -> None:
        """Write v = u^n with a periodic margin on both sides and, where the fluxes need it, |v|^(m/n)."""
        margin = self._margin
        self._power.evaluate(u, v[margin:-margin])
        v[:margin], v[-margin:] = v[-2 * margin : -margin], v[margin : 2 * margin]
        if needs_powers(self._ratio):
            self._law.evaluate(v, powers)

    def rhs(self, t: float, state: Array, out: Array) -> None:
        """Write -sum_s w_s N_s(u) and the damping."""
        v, powers, _, flux = self._work.arrays
        self._extend(state[0], v, powers)
        out[0] = 0
        for index, weight in enumerate(self._weights):
            _subtract_divergence(v, powers, self._margin, index + 1, weight, self._ratio, self._spacing, flux, out[0])
        self._damping.add(state[0], out[0])

    def jacobian(self, t: float, state: Array, out: Array) -> None:
        """Write the cyclic diagonals of the derivative of `rhs`."""
        v, powers, slope, _ = self._work.arrays
        self._extend(state[0], v, powers)
        self._power.derivative().evaluate(state[0], slope)
        out[:] = 0
        for index, weight in enumerate(self._weights):
            _subtract_jacobian(v, powers, self._margin, index + 1, weight, self._ratio, self._spacing, slope, out[0, 0])
        self._damping.add_to_diagonals(out[0, 0])


@compiled
def _subtract_divergence(
    v: Array, powers: Array, margin: int, stride: int, weight: float, ratio: float, spacing: float, flux: Array, out: Array
) -> None:
    """Subtract weight N_s(u); v = u^n has a periodic margin."""
    step = stride * spacing
    count, first = out.size + stride, margin - 2 * stride
    before, left, right, after = neighbours(v, first, stride)
    _, of_left, of_right, _ = neighbours(powers, first, stride)
    two_point_fluxes(left, right, of_left, of_right, ratio, flux[:count])
    factor = 1 / (2 * step * step)
    for k in range(count):
        flux[k] += factor * (after[k] - right[k] - left[k] + before[k])
    subtract_difference(flux, stride, weight / step, out)


@compiled
def _subtract_jacobian(
    v: Array, powers: Array, margin: int, stride: int, weight: float, ratio: float, spacing: float, slope: Array, out: Array
) -> None:
    """Subtract the cyclic diagonals of weight dN_s/du; slope is dv/du."""
    size, first = out.shape[1], margin - stride
    step = stride * spacing
    bend = 1 / (2 * step * step)
    derivatives = np.empty((4, size + stride))
    derivatives[:] = bend
    by_left, by_right = np.empty((2, size + stride))
    two_point_slopes(v[first:], v[first + stride :], powers[first:], powers[first + stride :], ratio, by_left, by_right)
    for k in range(size + stride):
        derivatives[1, k] = by_left[k] - bend
        derivatives[2, k] = by_right[k] - bend
        for place in range(4):
            derivatives[place, k] *= slope[(k + (place - 2) * stride) % size]
    subtract_difference_jacobian(derivatives, stride, weight / step, out)
