"""LU of a cyclic band matrix without pivoting, compiled: linear in N, with inner loops of constant length.

The unknowns stand in the order of the cells from some cell on, the components of a cell side by side. All but the last
b = reach * components of them form an ordinary band of half-width w = b + components - 1; the last b are its border:

    [ B  R ] [ x   ]   [ y   ]
    [ S  C ] [ x_b ] = [ y_b ],        B = L U, where U has a unit diagonal.

Row i of B stands at rows[w + i], its diagonal in the middle, after w rows of zeros that spare the loops a beginning of their
own; R likewise at right[w + i], and S by columns at below[w + i]. After `factor` these hold L (each row divided by its
diagonal, which is kept inverted), U, L^-1 R and S U^-1, and the corner C - S B^-1 R, of which `CyclicLU` keeps the inverse.

The fill of R and S decays away from the two ends where J is small; where it is below `NEGLIGIBLE` it is dropped, which
changes the matrix by less than its rounding. Without pivoting the rounding errors are small as long as the factors are, and
`factor` refuses a matrix whose factors are not. That happens where the ring is cut through a wave, and it is cut anew where J
is small; what is refused then is for `band`, which pivots. w and b are given as the lengths of tuples, constants for the
compiler. Source: Golub and Van Loan, "Matrix Computations", 4th ed., sections 3.3 and 4.3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mol_compactons.runtime.compiled import compiled
from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]
Length = tuple[int, ...]

NEGLIGIBLE = 1e-20
"""Fill below this, relative to the largest entry of the matrix, is dropped."""

FAINT = 1e-250
"""A solution that has faded below this is zero from there on: it would end in subnormal numbers, whose arithmetic is slow."""

LOOKS = 32
"""After how many unknowns it is looked whether the solution has faded; a power of two."""

LARGEST_GROWTH = 1e3
"""How large an entry of L times one of U may be, relative to the largest entry of the matrix."""


class CyclicLU:
    """The factors of M - gamma J of a system, without pivoting."""

    def __init__(self, system: SemiDiscretization) -> None:
        border = system.reach * system.components
        width = border + system.components - 1
        self._edge, self._half = (0,) * border, (0,) * width
        self._mass = system.mass_diagonals
        self._rows = np.empty((width + system.unknowns, 2 * width + 1))
        self._right, self._below = np.empty((2, width + system.unknowns, border))
        self._corner = np.empty((border, border))
        self._inverse: Array = self._corner
        self._work = np.zeros(system.unknowns + 2 * width)
        self._head = self._first = 0

    def factor(self, jacobian: Array, gamma: float) -> bool:
        """Factor M - gamma J from the cyclic diagonals of J; False where that would be inaccurate."""
        if self._factor_as_cut(jacobian, gamma):
            return True
        self._first = quietest_cell(jacobian)
        return self._factor_as_cut(jacobian, gamma)

    def _factor_as_cut(self, jacobian: Array, gamma: float) -> bool:
        """The same with the ring cut where it was cut the last time."""
        parts = (self._rows, self._right, self._below, self._corner)
        largest = assemble(self._mass, jacobian, gamma, self._first, self._half, *parts)
        self._head = factor(self._rows, self._right, self._below, self._corner, self._half, self._edge, largest)
        if self._head < 0:
            return False
        try:
            self._inverse = np.asarray(np.linalg.inv(self._corner))
        except np.linalg.LinAlgError:
            return False
        return bool(np.isfinite(self._inverse).all())

    def solve_into(self, residual: Array, out: Array) -> None:
        """Write the solution for a residual of shape (components, size) into `out`, which may be the same array."""
        matrix = (self._rows, self._right, self._below, self._inverse)
        solve(*matrix, self._half, self._edge, self._head, self._first, residual, self._work, out)


def quietest_cell(jacobian: Array) -> int:
    """The middle of that eighth of the ring in which the entries of J are smallest, given by its cyclic diagonals."""
    size = int(jacobian.shape[-1])
    # Where an entry is not finite any cell will do: `factor` refuses the matrix.
    with np.errstate(over="ignore", invalid="ignore"):
        sizes = np.abs(jacobian).sum(axis=(0, 1, 2))
        window = max(size // 8, 1)
        total = np.cumsum(np.concatenate(([0.0], sizes, sizes[:window])))
        quietest = int(np.argmin(total[window:-1] - total[: -window - 1]))
    return (quietest + window // 2) % size


@compiled
def assemble(
    mass: Array,
    jacobian: Array,
    gamma: float,
    first: int,
    half: Length,
    rows: Array,
    right: Array,
    below: Array,
    corner: Array,
) -> float:
    """Write M - gamma J, both given by their cyclic diagonals, from a first cell on; the largest entry is returned."""
    components, diagonals, size = jacobian.shape[1], jacobian.shape[2], jacobian.shape[3]
    width, reach = len(half), (diagonals - 1) // 2
    rows[:] = 0.0
    right[:] = 0.0
    below[:] = 0.0
    corner[:] = 0.0
    largest = 0.0
    for r in range(components):
        for c in range(components):
            for diagonal in range(diagonals):
                place = (diagonal - reach) * components + c - r + width
                for start, stop, shift in ((first, size, -first), (0, first, size - first)):
                    m, j = mass[r, c, diagonal, start:stop], jacobian[r, c, diagonal, start:stop]
                    column = rows[width + (start + shift) * components + r :: components, place]
                    for k in range(stop - start):
                        value = m[k] - gamma * j[k]
                        column[k] = value
                        largest = max(largest, abs(value))
    _move_border(rows, right, below, corner, width)
    return largest


@compiled
def _move_border(rows: Array, right: Array, below: Array, corner: Array, width: int) -> None:
    """Move what couples the border, across the end of the ring too, from the rows to where it belongs."""
    border, unknowns = corner.shape[0], rows.shape[0] - width
    inner = unknowns - border
    for i in range(unknowns):
        if width <= i < inner - width:
            continue
        for place in range(2 * width + 1):
            column = (i - width + place) % unknowns
            value = rows[width + i, place]
            if value != 0.0 and (i >= inner or column >= inner):
                rows[width + i, place] = 0.0
                if i < inner:
                    right[width + i, column - inner] = value
                elif column < inner:
                    below[width + column, i - inner] = value
                else:
                    corner[i - inner, column - inner] = value


@compiled
def factor(rows: Array, right: Array, below: Array, corner: Array, half: Length, edge: Length, largest: float) -> int:
    """Factor in place; how many rows at the front stay coupled to the border, or -1 where the factors are too large."""
    width, border = len(half), len(edge)
    inner = rows.shape[0] - width - border
    size_of_l, size_of_u, inverses = 0.0, 1.0, 0.0
    head, still = inner, 0
    for i in range(inner):
        row = rows[width + i]
        for k in range(width):
            for q in range(width):
                row[k + 1 + q] -= row[k] * rows[i + k, width + 1 + q]
        inverse = 1.0 / row[width]
        inverses += abs(inverse)
        if i < head or i >= inner - width:
            ahead, under = right[width + i], below[width + i]
            for k in range(width):
                for s in range(border):
                    ahead[s] -= row[k] * right[i + k, s]
                    under[s] -= rows[i + k, 2 * width - k] * below[i + k, s]
            fill = 0.0
            for s in range(border):
                ahead[s] *= inverse
                fill = max(fill, abs(ahead[s]), abs(under[s]) / largest)
                size_of_l, size_of_u = max(size_of_l, abs(under[s])), max(size_of_u, abs(ahead[s]))
                for t in range(border):
                    corner[t, s] -= under[t] * ahead[s]
            still = still + 1 if fill < NEGLIGIBLE else 0
            if still == width:
                head = min(head, i + 1)
        size_of_l = max(size_of_l, abs(row[width]))
        for k in range(width):
            size_of_l, size_of_u = max(size_of_l, abs(row[k])), max(size_of_u, abs(inverse * row[width + 1 + k]))
            row[k] *= inverse
            row[width + 1 + k] *= inverse
        row[width] = inverse
    if not (size_of_l * size_of_u < LARGEST_GROWTH * largest < np.inf and inverses < np.inf):
        return -1
    return int(head)


@compiled
def solve(
    rows: Array,
    right: Array,
    below: Array,
    inverse: Array,
    half: Length,
    edge: Length,
    head: int,
    first: int,
    residual: Array,
    work: Array,
    solution: Array,
) -> None:
    """Solve with the factors for a residual of shape (components, size), which may be the solution's own array.

    `work` has room for all unknowns and 2 w numbers more, of which the first w and the last w are zero.
    """
    width, border = len(half), len(edge)
    components, size = residual.shape
    unknowns = components * size
    for r in range(components):
        part = work[width + r : width + unknowns : components]
        part[: size - first], part[size - first :] = residual[r, first:], residual[r, :first]
    end = work[width + unknowns - border : width + unknowns]
    _solve_with_lower(rows, below, half, edge, head, work, end)
    solved = np.zeros(border)
    for s in range(border):
        for t in range(border):
            solved[s] += inverse[s, t] * end[t]
    end[:] = solved
    _solve_with_upper(rows, right, half, edge, head, work, solved)
    for r in range(components):
        part = work[width + r : width + unknowns : components]
        solution[r, first:], solution[r, :first] = part[: size - first], part[size - first :]


@compiled
def _solve_with_lower(rows: Array, below: Array, half: Length, edge: Length, head: int, work: Array, end: Array) -> None:
    """Solve with L in place, and subtract from the border's end of the residual what follows for it.

    The entry just found goes on in a register: its way through the memory would take longer than the arithmetic.
    """
    width, border = len(half), len(edge)
    inner = rows.shape[0] - width - border
    value = 0.0
    for i in range(inner):
        row = rows[width + i]
        total = work[width + i] * row[width]
        for k in range(width - 1):
            total -= row[k] * work[i + k]
        value = total - row[width - 1] * value
        work[width + i] = value
        if i & (LOOKS - 1) == 0 and _has_faded(work[i + 1 : width + i + 1]):
            value = 0.0
        if i < head or i >= inner - width:
            for s in range(border):
                end[s] -= below[width + i, s] * value


@compiled
def _solve_with_upper(rows: Array, right: Array, half: Length, edge: Length, head: int, work: Array, solved: Array) -> None:
    """Solve with U in place, given the solution in the border."""
    width, border = len(half), len(edge)
    inner = rows.shape[0] - width - border
    value = 0.0
    for i in range(inner - 1, -1, -1):
        row = rows[width + i]
        total = work[width + i]
        if i < head or i >= inner - width:
            for s in range(border):
                total -= right[width + i, s] * solved[s]
        for q in range(width - 1, 0, -1):
            total -= row[width + 1 + q] * work[width + i + 1 + q]
        value = total - row[width + 1] * value
        work[width + i] = value
        if i & (LOOKS - 1) == 0 and _has_faded(work[width + i : 2 * width + i]):
            value = 0.0


@compiled
def _has_faded(latest: Array) -> bool:
    """Whether all of the latest entries of a solution are faint; then they become zero."""
    for value in latest:
        if not abs(value) < FAINT:
            return False
    latest[:] = 0.0
    return True
