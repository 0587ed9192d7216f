"""What a Krylov solver needs where the Jacobian is not banded: products with it, and a banded stand-in for it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import InputError
from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]


class KrylovLinearization:
    """Newton's matrix I - gamma df/dy of CVODE, as products and as the LU of the banded Jacobian of a companion system."""

    def __init__(self, system: SemiDiscretization) -> None:
        from scipy.linalg import lapack

        if system.jacobian_vector is None or system.companion is None:
            raise InputError(
                "integrator.linear_solver = 'krylov' is for schemes without a banded Jacobian, such as FourierScheme; choose "
                "'band'."
            )
        self._lapack: Any = lapack
        self._system = system
        self._product_with = system.jacobian_vector
        self._companion = system.companion
        self._state, self._vector, self._product = np.empty((3, system.components, system.size))
        self._diagonals = np.empty_like(system.companion.mass_diagonals)
        self._width = system.companion.half_bandwidth
        self._lu: Array = np.empty(0)
        self._pivots: NDArray[np.int32] = np.empty(0, dtype=np.int32)

    def set_up_preconditioner(self, t: float, y: Array, yp: Array, reuse: int, renewed: list[int], gamma: float) -> None:
        """Factor I - gamma J of the companion; its Jacobian is kept while SUNDIALS allows it."""
        companion = self._companion
        if not reuse:
            companion.jacobian(t, self._system.unfold(y, out=self._state), self._diagonals)
        renewed[0] = int(not reuse)
        band = companion.banded(companion.mass_diagonals - gamma * self._diagonals)
        self._lu, self._pivots, _ = self._lapack.dgbtrf(band, self._width, self._width)

    def precondition(
        self, t: float, y: Array, yp: Array, residual: Array, result: Array, gamma: float, tolerance: float, side: int
    ) -> None:
        """Solve with the factors."""
        result[:], _ = self._lapack.dgbtrs(self._lu, self._width, self._width, residual, self._pivots)

    def multiply(self, t: float, y: Array, yp: Array, vector: Array, product: Array) -> None:
        """Write df/dy times a vector."""
        system = self._system
        self._product_with(t, system.unfold(y, out=self._state), system.unfold(vector, out=self._vector), self._product)
        system.fold(self._product, out=product)
