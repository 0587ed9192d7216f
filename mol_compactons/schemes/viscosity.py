"""The artificial viscosity that the schemes share, in absolute and in grid units."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import require
from mol_compactons.schemes.base import Scheme
from mol_compactons.stencils import SECOND_NEAREST, add_convolution

Own = TypeVar("Own", bound="ViscousScheme")

Array = NDArray[np.float64]


class ViscousScheme(Scheme):
    """A scheme with the damping -(eps + nu h^(p-1)) (-1)^(p/2) D^p.

    A subclass is a frozen dataclass with the three fields.
    """

    viscosity: float
    """The coefficient eps, nondimensional."""

    grid_viscosity: float
    """The coefficient nu, in grid units."""

    viscosity_order: int
    """The even order p."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("viscosity", "grid_viscosity"):
            value = getattr(self, name)
            require(value >= 0, f"scheme.{name} = {value:g} must not be negative; 0 is none.")

    def with_viscosity(self: Own, viscosity: float, grid_viscosity: float) -> Own:
        """The same scheme with other coefficients."""
        return cast(Own, replace(cast(Any, self), viscosity=viscosity, grid_viscosity=grid_viscosity))

    @property
    def viscosities(self) -> tuple[float, float]:
        """The coefficients eps and nu."""
        return self.viscosity, self.grid_viscosity

    @property
    def _unsaid(self) -> set[str]:
        return {"viscosity", "grid_viscosity"} | ({"viscosity_order"} if self.viscosity_order == 4 else set())


def damping_order(scheme: Scheme) -> Literal[4, 6]:
    """The order of the damping that a scheme has, 4 or 6, for another one that is to be compared with it."""
    return 6 if isinstance(scheme, ViscousScheme) and scheme.viscosity_order == 6 else 4


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
