"""LU of a folded band matrix with partial pivoting, by LAPACK.

For the matrices for which `cyclic_band`, which is faster, is not accurate enough. In the layout of LAPACK's ``gbtrf`` the
entry of row i and column j stands at [2 w + i - j, j]; the first w rows are room for what pivoting fills in.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]


class FoldedLU:
    """The factors of M - gamma J of a system in folded order, with partial pivoting."""

    def __init__(self, system: SemiDiscretization) -> None:
        self._system = system
        self._width = system.half_bandwidth
        self._band = np.empty((3 * self._width + 1, system.unknowns), order="F")
        self._pivots = np.empty(system.unknowns, dtype=np.int32)

    @cached_property
    def _entries(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """For each entry of the cyclic diagonals its row and column in the band."""
        rows, columns = self._system.folded_places
        return 2 * self._width + rows - columns, columns

    def factor(self, jacobian: Array, gamma: float) -> bool:
        """Factor M - gamma J from the cyclic diagonals of J; False where the matrix is singular or not finite."""
        self._band[:] = 0.0
        self._band[self._entries] = self._system.mass_diagonals.reshape(-1) - gamma * jacobian.reshape(-1)
        if not np.isfinite(self._band).all():
            return False
        self._band, self._pivots, failed = lapack.dgbtrf(self._band, self._width, self._width, overwrite_ab=1)
        return bool(failed == 0)

    def solve_into(self, residual: Array, out: Array) -> None:
        """Write the solution for a residual of shape (components, size) into `out`, which may be the same array."""
        right = self._system.fold(residual)
        solution, _ = lapack.dgbtrs(self._band, self._width, self._width, right, self._pivots, overwrite_b=1)
        self._system.unfold(solution, out=out)
