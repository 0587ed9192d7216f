"""The four stencils with which the literature solves the Rosenau-Hyman equation, by name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons.equations.base import Equation
from mol_compactons.equations.flux import Flux
from mol_compactons.equations.rosenau_hyman import RosenauHyman
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.runtime.workspace import Workspace
from mol_compactons.schemes.base import Scheme
from mol_compactons.schemes.viscosity import Damping, ViscousScheme, damping_order
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.stencils import COMPACT_FIRST, COMPACT_MASS, SECOND_NEAREST, Stencil, add_convolution, convolve

Array = NDArray[np.float64]

THIRD = Stencil((-1 / 2, 1.0, 0.0, -1.0, 1 / 2), derivative=3, order=2)
"""The third difference C that all four share; its order with a mass matrix stands in `PADE_STENCILS`."""


@dataclass(frozen=True)
class PadeStencil:
    """One pair of rational differences with a common mass matrix: A^-1 B for u_x and A^-1 C for u_xxx.

    Parameters
    ----------
    mass : Stencil
        A.
    first : Stencil
        B, with the order of A^-1 B.
    third_order : int
        The order of A^-1 C.
    """

    mass: Stencil
    first: Stencil
    third_order: int

    @property
    def order(self) -> int:
        """The lower of the two orders."""
        return min(self.first.order, self.third_order)


PADE_STENCILS = {
    "ismail_taha": PadeStencil(
        Stencil((0.0, 0.0, 1.0, 0.0, 0.0), derivative=0, order=2),
        Stencil((0.0, -1 / 2, 0.0, 1 / 2, 0.0), derivative=1, order=2),
        third_order=2,
    ),
    "de_frutos": PadeStencil(COMPACT_MASS, COMPACT_FIRST, third_order=4),
    "pade_6": PadeStencil(
        Stencil((1 / 240, 56 / 240, 126 / 240, 56 / 240, 1 / 240), derivative=0, order=4),
        Stencil(COMPACT_FIRST.coefficients, derivative=1, order=4),
        third_order=6,
    ),
    "pade_8": PadeStencil(
        Stencil((1 / 70, 16 / 70, 36 / 70, 16 / 70, 1 / 70), derivative=0, order=8),
        Stencil((-5 / 84, -32 / 84, 0.0, 32 / 84, 5 / 84), derivative=1, order=8),
        third_order=2,
    ),
}
"""The four members by name."""


@dataclass(frozen=True)
class PadeScheme(ViscousScheme):
    """Rational differences on five points for K(m, n), with one mass matrix for both derivatives.

        A u' + B u^m + C u^n + eps D4 u = 0,    C = (-1/2, 1, 0, -1, 1/2) / h^3

    The mass is conserved; for m = n, without viscosity, so is the sum of u^(n+1), since A^-1 (B + C) is skew.

    Parameters
    ----------
    stencil : {"ismail_taha", "de_frutos", "pade_6", "pade_8"}
        Which A and B, see docs/schemes.md. The orders of u_x and u_xxx are 2 and 2; 6 and 4; 4 and 6; 8 and 2.
        "ismail_taha" has no mass matrix, and is ``ConservativeScheme(order=2)`` where m = n.
    viscosity : float
        The coefficient eps >= 0 of the damping -eps (-1)^(p/2) D^p u, nondimensional.
    grid_viscosity : float
        The same in grid units: nu >= 0 adds nu h^(p-1) to the viscosity, so that it vanishes with the grid.
    viscosity_order : {4, 6}
        The order p of the derivative that damps.

    Raises
    ------
    InputError
        If the viscosity is negative, the equation is no K(m, n), or the grid has fewer points than are coupled.

    Notes
    -----
    Sources: Ismail and Taha, Math. Comput. Simul. 47 (1998) 519; de Frutos, Lopez-Marcos and Sanz-Serna, J. Comput. Phys. 120
    (1995) 248; Rus and Villatoro, Math. Comput. Simul. 76 (2007) 188. The four side by side: Rus and Villatoro,
    arXiv:0708.0486.
    """

    stencil: Literal["ismail_taha", "de_frutos", "pade_6", "pade_8"] = "de_frutos"
    viscosity: float = 0.0
    grid_viscosity: float = 0.0
    viscosity_order: Literal[4, 6] = 4

    @property
    def formal_order(self) -> float:
        """The lower of the orders of its two derivatives."""
        return float(PADE_STENCILS[self.stencil].order)

    def suits(self, equation: Equation) -> float:
        """K(m, n), after the schemes that know more about it."""
        return 0.4 if isinstance(equation, RosenauHyman) and not equation.has_source else 0.0

    @classmethod
    def as_check_of(cls, scheme: Scheme, equation: Equation, grid: Grid | Lattice) -> tuple[float, Scheme]:
        """With a damping of the same order."""
        own = cls(viscosity_order=damping_order(scheme))
        return own.suits(equation), own

    def discretize(self, equation: Equation, grid: Grid | Lattice) -> SemiDiscretization:
        """The semi-discretisation of K(m, n) on a grid."""
        if not isinstance(equation, RosenauHyman) or equation.has_source or isinstance(grid, Lattice):
            raise InputError(
                f"PadeScheme is for RosenauHyman without a source on a Grid, not for {type(equation).__name__} on a "
                f"{type(grid).__name__}; scheme=none takes the scheme that suits best."
            )
        damping = Damping(self, grid.spacing)
        reach = max(THIRD.reach, damping.reach)
        require(
            grid.size >= 2 * reach + 1,
            f"grid.size = {grid.size} is too small: the scheme couples {2 * reach + 1} neighbours; choose at least "
            f"{2 * reach + 1} points.",
        )
        member = PADE_STENCILS[self.stencil]
        kernel = _PadeKernel(equation.dispersive_flux, grid, member.first, damping)

        def bend(values: Array) -> Array:
            return SECOND_NEAREST.apply(values, grid.spacing)

        return SemiDiscretization(
            size=grid.size,
            components=1,
            reach=reach,
            rhs=kernel.rhs,
            jacobian=kernel.jacobian,
            invariants=lambda state: equation.invariants(state, grid.spacing, bend),
            magnitudes=lambda state: equation.magnitudes(state, grid.spacing, bend),
            mass=np.array(member.mass.coefficients) if member.mass.reach else None,
            damping=damping.fastest,
        )


class _PadeKernel:
    """The right-hand side and the Jacobian."""

    def __init__(self, flux: Flux, grid: Grid, first: Stencil, damping: Damping) -> None:
        self._flux, self._damping = flux, damping
        self._minus_first, self._minus_third = -first.scaled(grid.spacing), -THIRD.scaled(grid.spacing)
        self._work = Workspace(grid.size, grid.size)

    def rhs(self, t: float, state: Array, out: Array) -> None:
        """Write -B u^m - C u^n and the damping."""
        convected, dispersed = self._work.arrays
        self._flux.convective(state[0], convected)
        self._flux.g.evaluate(state[0], dispersed)
        convolve(self._minus_first, convected, out[0])
        add_convolution(self._minus_third, dispersed, out[0])
        self._damping.add(state[0], out[0])

    def jacobian(self, t: float, state: Array, out: Array) -> None:
        """Write the cyclic diagonals of the derivative of `rhs`."""
        convected, dispersed = self._work.arrays
        self._flux.convective_derivative(state[0], convected)
        self._flux.g.derivative().evaluate(state[0], dispersed)
        out[:] = 0.0
        middle = out.shape[2] // 2
        for offset, first, third in zip(THIRD.offsets, self._minus_first, self._minus_third, strict=True):
            row = out[0, 0, middle + offset]
            row += first * np.roll(convected, -offset) + third * np.roll(dispersed, -offset)
        self._damping.add_to_diagonals(out[0, 0])
