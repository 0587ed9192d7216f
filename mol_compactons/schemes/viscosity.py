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

LARGEST_VISCOSITY = 1e6
"""The largest coefficient eps; that of the paper is 1e-3, and waves of unit size are gone at once for 1 already."""

FASTEST_DAMPING = 1e30
"""The largest rate at which ripples may die."""

ODD_VISCOSITY, OTHER_VISCOSITY = 0.03, 0.01
"""The default damping in grid units for a flux that is odd in u, and that times h^2 for others."""


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
        require(
            self.viscosity <= LARGEST_VISCOSITY,
            f"scheme.viscosity = {self.viscosity:g} must not be above {LARGEST_VISCOSITY:g}; 1e-3 is much already.",
        )

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


def default_viscosity(odd: bool, spacing: float) -> float:
    """The default damping of sixth order in grid units, for waves of speed 1.

    Equations whose flux is odd in u have definite conserved quantities and do not blow up; for these 0.03 spares the
    integrator the ripples at the scale of the grid. In others, as the classical K(2, 2), ripples gather where u rises through
    zero (there -6 u_x v_xx of (uv)_xxx has the sign of antidiffusion) and stand as a jump of fixed size, which grows without
    bound unless nu ~ 1 / h^2. ``python -m benchmarks.robustness --k22`` finds the least nu that survives.

    Parameters
    ----------
    odd : bool
        Whether the flux is odd in u.
    spacing : float
        The grid spacing h.
    """
    return ODD_VISCOSITY if odd else max(ODD_VISCOSITY, OTHER_VISCOSITY / spacing**2)


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
        require(
            self.fastest <= FASTEST_DAMPING,
            f"The viscosity {scheme.viscosity:g} with the grid viscosity {scheme.grid_viscosity:g} damps ripples of "
            f"the spacing {spacing:g} at the rate {self.fastest:.3g}, above {FASTEST_DAMPING:g}; choose smaller ones.",
        )
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
