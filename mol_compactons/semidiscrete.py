"""A system of ordinary differential equations M y' = f(t, y) whose unknowns sit on a ring of cells.

Each cell holds one unknown for each component and is coupled to at most `reach` cells on either side, cyclically. A state
has shape (components, size). In the folded order of the cells (0, N-1, 1, N-2, ...) cyclic neighbours lie at most two apart,
so that the Jacobian, corners included, is an ordinary band matrix.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from mol_compactons.stencils import convolve

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SemiDiscretization:
    """The system M y' = f(t, y).

    Parameters
    ----------
    size, components : int
        Number of cells N and of unknowns in each.
    reach : int
        The farthest neighbour on which f or M depends.
    rhs : callable
        ``rhs(t, state, out)`` writes f into `out`; both have shape (components, size).
    jacobian : callable
        ``jacobian(t, state, out)`` writes the cyclic diagonals of df/dy into `out`, shape (components, components,
        2 reach + 1, size): ``out[r, c, reach + d, j]`` is the derivative of f_r in cell j by y_c in cell j + d.
    invariants : callable
        ``invariants(state)`` returns the conserved quantities by name.
    mass : array of shape (5,) or None
        The circulant stencil of M, the same for each component; None if M is the identity.
    jacobian_vector : callable or None
        ``jacobian_vector(t, state, vector, out)`` writes df/dy times a vector; for a system whose Jacobian is not banded.
    companion : SemiDiscretization or None
        A system with a banded Jacobian close to that of such a system, to precondition with.
    split_steps : callable or None
        ``split_steps(state, step, count, drifts, kicks)`` takes `count` steps of a splitting method, in place; for an
        oscillator, whose first component moves with the second and whose second is pushed by the first.
    damping : float
        The fastest rate at which f damps a grid-scale ripple; 0 for an undamped system, whose spectrum is nearly imaginary.
    """

    size: int
    components: int
    reach: int
    rhs: Callable[[float, Array, Array], None]
    jacobian: Callable[[float, Array, Array], None]
    invariants: Callable[[Array], dict[str, float]]
    mass: Array | None = None
    damping: float = 0.0
    jacobian_vector: Callable[[float, Array, Array, Array], None] | None = None
    companion: SemiDiscretization | None = None
    split_steps: Callable[[Array, float, int, Array, Array], None] | None = None

    @property
    def unknowns(self) -> int:
        """The number of unknowns."""
        return self.size * self.components

    @property
    def half_bandwidth(self) -> int:
        """The half-bandwidth of the Jacobian and of M in folded order."""
        return min(2 * self.reach * self.components + self.components - 1, self.unknowns - 1)

    @cached_property
    def order(self) -> NDArray[np.intp]:
        """The folded order: ``state.ravel()[order]`` is the state folded, components of a cell side by side."""
        cells = np.empty(self.size, dtype=np.intp)
        cells[0::2] = np.arange((self.size + 1) // 2)
        cells[1::2] = np.arange(self.size - 1, (self.size + 1) // 2 - 1, -1)
        return np.asarray((cells[:, None] + self.size * np.arange(self.components)).ravel())

    @cached_property
    def position(self) -> NDArray[np.intp]:
        """The inverse of `order`."""
        inverse = np.empty_like(self.order)
        inverse[self.order] = np.arange(self.unknowns)
        return inverse

    def fold(self, state: Array, out: Array | None = None) -> Array:
        """A state of shape (components, size) as a vector in folded order, shape (components * size,)."""
        return state.reshape(-1).take(self.order, out=out, mode="clip")

    def unfold(self, vector: Array, out: Array | None = None) -> Array:
        """The inverse of `fold`."""
        out = np.empty((self.components, self.size)) if out is None else out
        vector.take(self.position, out=out.reshape(-1), mode="clip")
        return out

    def apply_mass(self, state: Array, out: Array) -> None:
        """Write M state into `out`; both have shape (components, size)."""
        if self.mass is None:
            out[:] = state
            return
        for u, product in zip(state, out, strict=True):
            convolve(self.mass, u, product)

    def rate(self, t: float, state: Array) -> Array:
        """Y' = M^-1 f(t, y), shape (components, size)."""
        out = np.empty_like(state)
        self.rhs(t, state, out)
        if self.mass is None:
            return out
        theta = 2 * np.pi * np.fft.rfftfreq(self.size)
        symbol = np.cos(np.multiply.outer(theta, np.arange(-2, 3))) @ self.mass
        return np.asarray(np.fft.irfft(np.fft.rfft(out) / symbol, n=self.size))

    @cached_property
    def mass_diagonals(self) -> Array:
        """M in the layout of `jacobian`."""
        diagonals = np.zeros((self.components, self.components, 2 * self.reach + 1, self.size))
        for component in range(self.components):
            if self.mass is None:
                diagonals[component, component, self.reach] = 1
            else:
                diagonals[component, component, self.reach - 2 : self.reach + 3] = self.mass[:, None]
        return diagonals

    @cached_property
    def _places(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Folded row and column of each entry of the cyclic diagonals, flattened."""
        rows, columns = self._natural_places
        return self.position[rows], self.position[columns]

    @property
    def _natural_places(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """The same in the order of ``state.ravel()``."""
        row_component, column_component, diagonal, cell = np.indices(self.mass_diagonals.shape)
        rows = row_component * self.size + cell
        columns = column_component * self.size + (cell + diagonal - self.reach) % self.size
        return rows.ravel(), columns.ravel()

    def dense(self, diagonals: Array) -> Array:
        """Cyclic diagonals as a dense matrix in the order of ``state.ravel()``, shape (unknowns, unknowns)."""
        matrix = np.zeros((self.unknowns, self.unknowns))
        matrix[self._natural_places] = diagonals.reshape(-1)
        return matrix

    @cached_property
    def sparsity(self) -> sparse.csc_array:
        """The pattern of M and df/dy together in folded order, as CSC with sorted indices."""
        rows, columns = self._places
        pattern = sparse.csc_array((np.ones(rows.size), (rows, columns)), shape=(self.unknowns, self.unknowns))
        pattern.sort_indices()
        pattern.indices, pattern.indptr = pattern.indices.astype(np.int32), pattern.indptr.astype(np.int32)
        return pattern

    @cached_property
    def _csc_entry(self) -> NDArray[np.intp]:
        """For each stored entry of `sparsity`, its index in the flattened cyclic diagonals."""
        rows, columns = self._places
        return np.lexsort((rows, columns))

    def csc_values(self, diagonals: Array) -> Array:
        """Cyclic diagonals as the values of `sparsity`, shape (nnz,)."""
        return np.asarray(diagonals.reshape(-1)[self._csc_entry])

    @cached_property
    def band_entries(self) -> NDArray[np.intp]:
        """For each entry of the cyclic diagonals its index in a folded band, flattened; see `integrators.band`."""
        rows, columns = self._places
        width = self.half_bandwidth
        return np.asarray(rows * (3 * width + 1) + columns - rows + width)
