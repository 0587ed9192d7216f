"""Solving with Newton's matrix M - gamma df/dy: banded LU, or GMRES with the LU of a banded stand-in as preconditioner."""

from __future__ import annotations

from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import InputError
from mol_compactons.integrators.linear.band import FoldedLU
from mol_compactons.integrators.linear.cyclic_band import CyclicLU
from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]

INNER_TOLERANCE = 1e-3
"""By how much GMRES reduces the residual of one Newton iteration; the next iteration repairs the rest."""

KRYLOV_DIMENSION = 30
"""The largest number of Krylov vectors."""


class NewtonMatrix(Protocol):
    """M - gamma df/dy, to be solved with."""

    def factor(self, t: float, state: Array, gamma: float) -> bool:
        """Prepare at a state; False where the matrix is singular."""

    def solve(self, t: float, state: Array, residual: Array) -> Array:
        """The solution for a residual of shape (components, size); a matrix that is not banded is taken at the state given."""


def newton_matrix(system: SemiDiscretization) -> NewtonMatrix:
    """The way to solve that suits a system."""
    return BandedMatrix(system) if system.jacobian_vector is None else KrylovMatrix(system)


class BandedMatrix:
    """The LU of M - gamma df/dy, kept from one `factor` to the next: without pivoting where that is accurate."""

    def __init__(self, system: SemiDiscretization) -> None:
        self._system = system
        self._diagonals = np.empty_like(system.mass_diagonals)
        self._fast = CyclicLU(system)
        self._factors: CyclicLU | FoldedLU = self._fast

    @cached_property
    def _robust(self) -> FoldedLU:
        """Made when it is needed."""
        return FoldedLU(self._system)

    def linearize(self, t: float, state: Array) -> None:
        """Evaluate df/dy at a state."""
        self._system.jacobian(t, state, self._diagonals)

    def factor_linearized(self, gamma: float) -> bool:
        """Factor with the df/dy of the last `linearize`; False where the matrix is singular."""
        self._factors = self._fast
        if self._fast.factor(self._diagonals, gamma):
            return True
        self._factors = self._robust
        return self._robust.factor(self._diagonals, gamma)

    def factor(self, t: float, state: Array, gamma: float) -> bool:
        """Evaluate df/dy and factor; False where the matrix is singular."""
        self.linearize(t, state)
        return self.factor_linearized(gamma)

    def solve_into(self, residual: Array, out: Array) -> None:
        """Write the solution for a residual of shape (components, size) into `out`, which may be the same array."""
        self._factors.solve_into(residual, out)

    def solve(self, t: float, state: Array, residual: Array) -> Array:
        """The solution for a residual of shape (components, size)."""
        out = np.empty_like(residual)
        self.solve_into(residual, out)
        return out


class KrylovMatrix:
    """GMRES with products with df/dy at the state asked for, preconditioned by the LU of the companion system."""

    def __init__(self, system: SemiDiscretization) -> None:
        from scipy.sparse.linalg import LinearOperator, gmres

        self._operator: Any = LinearOperator
        self._gmres: Any = gmres
        self._system, self._product_with, companion = with_companion(system)
        self._preconditioner = BandedMatrix(companion)
        self._product = np.empty((system.components, system.size))
        self._gamma = 0.0

    def factor(self, t: float, state: Array, gamma: float) -> bool:
        """Factor the companion's matrix; False where it is singular."""
        self._gamma = gamma
        return self._preconditioner.factor(t, state, gamma)

    def solve(self, t: float, state: Array, residual: Array) -> Array:
        """The solution for a residual of shape (components, size), to `INNER_TOLERANCE`."""
        system, shape = self._system, (self._system.unknowns,) * 2

        def multiply(vector: Array) -> Array:
            v = vector.reshape(residual.shape)
            self._product_with(t, state, v, self._product)
            return np.asarray(v - self._gamma * self._product).ravel()

        def precondition(vector: Array) -> Array:
            return self._preconditioner.solve(t, state, vector.reshape(residual.shape)).ravel()

        solution, _ = self._gmres(
            self._operator(shape, matvec=multiply, dtype=np.float64),
            residual.ravel(),
            M=self._operator(shape, matvec=precondition, dtype=np.float64),
            rtol=INNER_TOLERANCE,
            atol=0.0,
            restart=min(KRYLOV_DIMENSION, system.unknowns),
            maxiter=4,
        )
        return np.asarray(solution).reshape(residual.shape)


class KrylovCallbacks:
    """The same matrix in the form in which CVODE asks for it: products, and solves with the companion's LU."""

    def __init__(self, system: SemiDiscretization) -> None:
        self._system, self._product_with, companion = with_companion(system)
        self._preconditioner = BandedMatrix(companion)
        self._state, self._vector, self._product = np.empty((3, system.components, system.size))

    def set_up_preconditioner(self, t: float, y: Array, yp: Array, reuse: int, renewed: list[int], gamma: float) -> None:
        """Factor I - gamma J of the companion; its Jacobian is kept while SUNDIALS allows it."""
        if not reuse:
            self._preconditioner.linearize(t, self._system.unfold(y, out=self._state))
        renewed[0] = int(not reuse)
        self._preconditioner.factor_linearized(gamma)

    def precondition(
        self, t: float, y: Array, yp: Array, residual: Array, result: Array, gamma: float, tolerance: float, side: int
    ) -> None:
        """Solve with the factors."""
        vector = self._system.unfold(residual, out=self._vector)
        self._preconditioner.solve_into(vector, vector)
        self._system.fold(vector, out=result)

    def multiply(self, t: float, y: Array, yp: Array, vector: Array, product: Array) -> None:
        """Write df/dy times a vector."""
        system = self._system
        self._product_with(t, system.unfold(y, out=self._state), system.unfold(vector, out=self._vector), self._product)
        system.fold(self._product, out=product)


def with_companion(system: SemiDiscretization) -> tuple[SemiDiscretization, Any, SemiDiscretization]:
    """A system with its product and its companion; refused where it has none."""
    if system.jacobian_vector is None or system.companion is None:
        raise InputError(
            "integrator.linear_solver = 'krylov' is for schemes without a banded Jacobian, such as FourierScheme; choose "
            "'band'."
        )
    return system, system.jacobian_vector, system.companion
