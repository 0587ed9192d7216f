"""A system of ordinary differential equations M y' = f(t, y) whose unknowns sit on a ring of cells.

Each cell holds one unknown for each component and is coupled to at most `reach` cells on either side, cyclically. A state
has shape (components, size). In the folded order of the cells (0, N-1, 1, N-2, ...) cyclic neighbours lie at most two apart,
so that the Jacobian, corners included, is an ordinary band matrix.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from mol_compactons.errors import require
from mol_compactons.stencils import convolve

Array = NDArray[np.float64]

DIFFERENCE_STEP = 6e-6
"""The step of a central difference relative to the state, about the cube root of the rounding error."""

CANCELLING = 1e-3
"""A first value below this, relative to the sum of the sizes of its parts, is what their cancellation left."""


def drift_scale(first: float, magnitude: float) -> float:
    """What a change of a conserved quantity is relative to: its first value or, where parts of that cancel, their sizes."""
    return abs(first) if abs(first) > CANCELLING * magnitude else magnitude


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
    invariants : callable
        ``invariants(state)`` returns the conserved quantities by name.
    jacobian : callable, optional
        ``jacobian(t, state, out)`` writes the cyclic diagonals of df/dy into `out`, shape (components, components,
        2 reach + 1, size): ``out[r, c, reach + d, j]`` is the derivative of f_r in cell j by y_c in cell j + d. Without one it
        is made by differences of f, see `ColouredJacobian`.
    magnitudes : callable
        ``magnitudes(state)`` returns, for each conserved quantity, the sum of the sizes of what it is a sum of.
    diagnostics : callable
        ``diagnostics(state)`` returns what else is worth a number along t.
    mass : array of shape (2 r + 1,) or None
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
    explicit_time : bool
        Whether f depends on t as such.
    """

    size: int
    components: int
    reach: int
    rhs: Callable[[float, Array, Array], None]
    invariants: Callable[[Array], dict[str, float]]
    jacobian: Callable[[float, Array, Array], None] = None  # type: ignore[assignment]  # made in __post_init__
    magnitudes: Callable[[Array], dict[str, float]] = lambda state: {}
    diagnostics: Callable[[Array], dict[str, float]] = lambda state: {}
    mass: Array | None = None
    damping: float = 0.0
    jacobian_vector: Callable[[float, Array, Array, Array], None] | None = None
    companion: SemiDiscretization | None = None
    split_steps: Callable[[Array, float, int, Array, Array], None] | None = None
    explicit_time: bool = False

    def __post_init__(self) -> None:
        require(
            self.size >= 2 * self.reach + 1,
            f"A ring of {self.size} cells is too small for a reach of {self.reach}; choose at least {2 * self.reach + 1}.",
        )
        require(
            self.mass is None or self.mass.size // 2 <= self.reach,
            f"The mass matrix couples more neighbours than the reach {self.reach}; give the larger of the two as reach.",
        )
        if self.jacobian is None:
            object.__setattr__(self, "jacobian", ColouredJacobian(self.rhs, self.components, self.reach, self.size))

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

    def from_time(self, origin: float) -> SemiDiscretization:
        """The same system whose clock begins at an origin; itself where f does not depend on t as such."""
        if not self.explicit_time:
            return self

        def shifted(function: Any) -> Any:
            return None if function is None else lambda t, *others: function(origin + t, *others)

        return replace(
            self,
            rhs=shifted(self.rhs),
            jacobian=shifted(self.jacobian),
            jacobian_vector=shifted(self.jacobian_vector),
            companion=None if self.companion is None else self.companion.from_time(origin),
        )

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
        half = self.mass.size // 2
        symbol = np.exp(1j * np.multiply.outer(theta, np.arange(-half, half + 1))) @ self.mass
        return np.asarray(np.fft.irfft(np.fft.rfft(out) / symbol, n=self.size))

    @cached_property
    def mass_diagonals(self) -> Array:
        """M in the layout of `jacobian`."""
        diagonals = np.zeros((self.components, self.components, 2 * self.reach + 1, self.size))
        for component in range(self.components):
            if self.mass is None:
                diagonals[component, component, self.reach] = 1
            else:
                half = self.mass.size // 2
                diagonals[component, component, self.reach - half : self.reach + half + 1] = self.mass[:, None]
        return diagonals

    @cached_property
    def folded_places(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
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
        rows, columns = self.folded_places
        pattern = sparse.csc_array((np.ones(rows.size), (rows, columns)), shape=(self.unknowns, self.unknowns))
        pattern.sort_indices()
        pattern.indices, pattern.indptr = pattern.indices.astype(np.int32), pattern.indptr.astype(np.int32)
        return pattern

    @cached_property
    def _csc_entry(self) -> NDArray[np.intp]:
        """For each stored entry of `sparsity`, its index in the flattened cyclic diagonals."""
        rows, columns = self.folded_places
        return np.lexsort((rows, columns))

    def csc_values(self, diagonals: Array) -> Array:
        """Cyclic diagonals as the values of `sparsity`, shape (nnz,)."""
        return np.asarray(diagonals.reshape(-1)[self._csc_entry])


class ColouredJacobian:
    """The cyclic diagonals of df/dy by central differences of f, many columns at once.

    Cells that are more than 2 reach apart have no row in common, so that they are moved together: about 2 (2 reach + 1)
    evaluations of f for each component, however many cells there are. Source: Curtis, Powell and Reid, J. Inst. Math. Appl.
    13 (1974) 117, doi:10.1093/imamat/13.1.117.

    Parameters
    ----------
    rhs : callable
        ``rhs(t, state, out)``.
    components, reach, size : int
        As those of `SemiDiscretization`.
    """

    def __init__(self, rhs: Callable[[float, Array, Array], None], components: int, reach: int, size: int) -> None:
        self._rhs, self._components, self._reach = rhs, components, reach
        width = 2 * reach + 1
        # The last cells of the ring have colours of their own unless the width divides the size.
        regular = size - size % width
        cells = np.arange(size)
        self._colour = np.where(cells < regular, cells % width, width + cells - regular)

    def __call__(self, t: float, state: Array, out: Array) -> None:
        """Write the cyclic diagonals at a state, shape (components, components, 2 reach + 1, size)."""
        out[:] = 0.0
        size = state.shape[1]
        ahead, behind = np.empty((2, *state.shape))
        for component in range(self._components):
            largest = float(np.abs(state[component]).max())
            step = DIFFERENCE_STEP * np.maximum(np.abs(state[component]), largest or 1.0)
            for colour in range(int(self._colour.max()) + 1):
                columns = np.flatnonzero(self._colour == colour)
                for moved, sign in ((ahead, 1.0), (behind, -1.0)):
                    shifted = state.copy()
                    shifted[component, columns] += sign * step[columns]
                    self._rhs(t, shifted, moved)
                change = ahead - behind
                for diagonal in range(-self._reach, self._reach + 1):
                    rows = (columns - diagonal) % size
                    out[:, component, self._reach + diagonal, rows] = change[:, rows] / (2 * step[columns])
