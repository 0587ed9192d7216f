"""Finite-difference stencils on a periodic grid, by name, with their symbols and orders."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import factorial

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import InputError, require
from mol_compactons.runtime.compiled import compiled


@dataclass(frozen=True)
class Stencil:
    """Coefficients of u_(j-r) .. u_(j+r) that approximate h^derivative times a derivative of u.

    Parameters
    ----------
    coefficients : tuple of float
        The 2 r + 1 coefficients.
    derivative : int
        Which derivative; 0 for an average.
    order : int
        The power of h at which the error falls; for the members of a compact pair, that of the pair.
    """

    coefficients: tuple[float, ...]
    derivative: int
    order: int

    @property
    def offsets(self) -> NDArray[np.intp]:
        """The neighbours that the coefficients belong to, -r .. r."""
        half = len(self.coefficients) // 2
        return np.arange(-half, half + 1)

    @property
    def reach(self) -> int:
        """How many neighbours on each side take part."""
        return max(abs(int(offset)) for offset, c in zip(self.offsets, self.coefficients, strict=True) if c)

    def scaled(self, spacing: float) -> NDArray[np.float64]:
        """The coefficients divided by h^derivative, shape (2 r + 1,)."""
        return np.array(self.coefficients) / spacing**self.derivative

    def apply(self, u: NDArray[np.float64], spacing: float) -> NDArray[np.float64]:
        """The derivative of u, shape (N,) with N > 2 r, on a periodic grid; same shape."""
        result = np.empty_like(u)
        convolve(self.scaled(spacing), u, result)
        return result

    def symbol(self, theta: NDArray[np.float64]) -> NDArray[np.complex128]:
        """The eigenvalues of the stencil on exp(i theta j), complex, same shape as theta (theta = k h)."""
        return np.asarray(np.exp(1j * np.multiply.outer(np.asarray(theta), self.offsets)) @ np.array(self.coefficients))


WIDEST = 4
"""The most neighbours on each side for which the coefficients are found exactly."""


@cache
def central(derivative: int, order: int) -> Stencil:
    """The narrowest central difference for a derivative, 1 or more, to an even order.

    Examples
    --------
    >>> central(2, 4).coefficients == SECOND_FIVE_POINT.coefficients
    True
    """
    half = (derivative + 1) // 2 + order // 2 - 1
    require(
        order % 2 == 0 and derivative >= 1 and 1 <= half <= WIDEST,
        f"A central difference of order {order} for the derivative {derivative} is not known; choose an even order, and at "
        f"most {WIDEST} neighbours on each side.",
    )
    offsets = np.arange(-half, half + 1)
    moments = np.vander(offsets.astype(float), increasing=True).T
    wanted = np.zeros(offsets.size)
    wanted[derivative] = factorial(derivative)
    # The coefficients are rational with small denominators; rounding them to these makes sums of them vanish exactly.
    common = 1209600
    return Stencil(tuple(np.round(np.linalg.solve(moments, wanted) * common) / common), derivative, order)


COMPACT_MASS = Stencil((1 / 120, 26 / 120, 66 / 120, 26 / 120, 1 / 120), derivative=0, order=6)
"""The mass matrix of quintic B-splines; with `COMPACT_FIRST` a sixth-order first derivative. De Frutos, Lopez-Marcos and
Sanz-Serna (1995), doi:10.1006/jcph.1995.1161."""

COMPACT_FIRST = Stencil((-1 / 24, -10 / 24, 0.0, 10 / 24, 1 / 24), derivative=1, order=6)
"""The first difference that belongs to `COMPACT_MASS`."""

SECOND_WIDE = Stencil((1 / 4, 0.0, -1 / 2, 0.0, 1 / 4), derivative=2, order=2)
"""The paper's second difference over (2h)^2, with the denominator 4 h^2 that the paper misprints as h^2."""

SECOND_NEAREST = Stencil((0.0, 1.0, -2.0, 1.0, 0.0), derivative=2, order=2)
"""The second difference of the nearest neighbours."""

SECOND_FIVE_POINT = Stencil((-1 / 12, 16 / 12, -30 / 12, 16 / 12, -1 / 12), derivative=2, order=4)
"""The five-point second difference."""


@compiled
def convolve(stencil: NDArray[np.float64], u: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    """Apply a stencil, shape (2 r + 1,), to u, shape (N,) with N > 2 r, on a periodic grid; result in `out`."""
    if stencil.size == 5:
        _convolve_five(stencil, u, out)
    else:
        out[:] = 0.0
        add_convolution(stencil, u, out)


@compiled
def _convolve_five(stencil: NDArray[np.float64], u: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    """The same for the usual width, in one loop."""
    size = u.size
    far_left, left, middle, right, far_right = stencil[0], stencil[1], stencil[2], stencil[3], stencil[4]
    for k in range(size - 4):
        out[k + 2] = far_left * u[k] + left * u[k + 1] + middle * u[k + 2] + right * u[k + 3] + far_right * u[k + 4]
    for k in range(-2, 2):
        j = k if k >= 0 else k + size
        out[j] = (
            far_left * u[(j - 2) % size]
            + left * u[(j - 1) % size]
            + middle * u[j]
            + right * u[(j + 1) % size]
            + far_right * u[(j + 2) % size]
        )


@compiled
def add_convolution(stencil: NDArray[np.float64], u: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    """Add a stencil, shape (2 r + 1,), applied to u, shape (N,) with N > 2 r, on a periodic grid."""
    size, reach = u.size, stencil.size // 2
    inner = out[reach : size - reach]
    for k in range(stencil.size):
        coefficient, shifted = stencil[k], u[k:]
        for j in range(inner.size):
            inner[j] += coefficient * shifted[j]
    for edge in range(-reach, reach):
        total = 0.0
        for k in range(stencil.size):
            total += stencil[k] * u[(edge - reach + k) % size]
        out[edge] += total


def stencils_of(order: int, spacing: float) -> dict[int, NDArray[np.float64]]:
    """The central differences of an order for the derivatives 1 to 3, each scaled, shape (2 r + 1,)."""
    return {derivative: central(derivative, order).scaled(spacing) for derivative in (1, 2, 3)}


def difference(stencils: Mapping[int, NDArray[np.float64]], values: NDArray[np.float64], order: int) -> NDArray[np.float64]:
    """The derivative of an order of values on a periodic grid, shape (N,), by one of some differences."""
    if order not in stencils:
        raise InputError(f"There is no difference for a derivative of order {order}; write it by those of order 1, 2 and 3.")
    result = np.empty(values.size)
    convolve(stencils[order], np.ascontiguousarray(values, dtype=np.float64), result)
    return result
