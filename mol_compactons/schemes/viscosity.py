"""The artificial viscosity that the schemes share, in absolute and in grid units."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mol_compactons.compiled import compiled
from mol_compactons.errors import require
from mol_compactons.stencils import SECOND_NEAREST

Array = NDArray[np.float64]


class ViscousScheme(Protocol):
    """A scheme with the damping -(eps + nu h^(p-1)) (-1)^(p/2) D^p."""

    @property
    def viscosity(self) -> float:
        """The coefficient eps, nondimensional."""

    @property
    def grid_viscosity(self) -> float:
        """The coefficient nu, in grid units."""

    @property
    def viscosity_order(self) -> int:
        """The even order p."""


def check_viscosity(scheme: ViscousScheme) -> None:
    """Refuse negative coefficients."""
    for name in ("viscosity", "grid_viscosity"):
        value = getattr(scheme, name)
        require(value >= 0, f"scheme.{name} = {value:g} must not be negative; 0 is none.")


def coefficient(scheme: ViscousScheme, spacing: float) -> float:
    """The whole coefficient eps + nu h^(p-1) on a grid of the spacing h."""
    return scheme.viscosity + scheme.grid_viscosity * spacing ** (scheme.viscosity_order - 1)


class Damping:
    """The damping of a scheme as a finite difference on a periodic grid.

    Parameters
    ----------
    scheme : ViscousScheme
        Whose viscosity.
    spacing : float
        The grid spacing h.
    """

    def __init__(self, scheme: ViscousScheme, spacing: float) -> None:
        amount = coefficient(scheme, spacing)
        self.reach = scheme.viscosity_order // 2 if amount else 0
        self.fastest = amount * (2 / spacing) ** scheme.viscosity_order
        """The rate at which the shortest ripple dies."""
        self.coefficients: Array = np.full(1, -amount * (-1.0) ** self.reach)
        """The stencil, shape (2 reach + 1,)."""
        for _ in range(self.reach):
            self.coefficients = np.convolve(self.coefficients, SECOND_NEAREST.scaled(spacing)[1:4])

    def add(self, u: Array, out: Array) -> None:
        """Add the damping of u, shape (N,), to `out`."""
        if self.reach:
            add_convolution(self.coefficients, u, out)

    def add_to_diagonals(self, diagonals: Array) -> None:
        """Add it to the cyclic diagonals of a Jacobian, shape (2 R + 1, N)."""
        middle = diagonals.shape[0] // 2
        diagonals[middle - self.reach : middle + self.reach + 1] += self.coefficients[:, None]


@compiled
def add_convolution(coefficients: Array, u: Array, out: Array) -> None:
    """Add a stencil of odd length, shape (2 r + 1,), applied to u, shape (N,) with N > 2 r, on a periodic grid."""
    size, reach = u.size, coefficients.size // 2
    inner = out[reach : size - reach]
    for k in range(coefficients.size):
        coefficient, shifted = coefficients[k], u[k:]
        for j in range(inner.size):
            inner[j] += coefficient * shifted[j]
    for edge in range(-reach, reach):
        total = 0.0
        for k in range(coefficients.size):
            total += coefficients[k] * u[(edge - reach + k) % size]
        out[edge] += total
