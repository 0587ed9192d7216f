"""Floquet multipliers: the eigenvalues of a monodromy matrix, with their error bars, and what they say.

A small change of an orbit grows by |mu| in each period. One multiplier is 1, that of the flow along the orbit, which for a
wave is its translation; and again, in one Jordan block with it, that of the wave's speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.orbits import Orbit

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

DENSE = 1600
"""Up to so many unknowns all multipliers are found; beyond, the largest."""

FEWEST = 6
"""How many of the largest are looked for at least."""

ROUNDING = 10 * np.finfo(float).eps
"""The rounding error of a monodromy matrix, relative to its norm."""

CERTAIN = 1e-3
"""Where the bar of a multiplier near the unit circle is wider than this nothing is called stable."""

Verdict = Literal["stable", "unstable", "undecided"]


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Multipliers, the largest first, shape (K,).

    Parameters
    ----------
    values : array
        The multipliers mu.
    errors : array
        By how much each may be wrong, see `spectrum`.
    modes : array, shape (K, unknowns)
        The unit eigenvectors, in the order of ``state.ravel()``.
    """

    values: ComplexArray
    errors: Array
    modes: ComplexArray


def spectrum(orbit: Orbit, cells: NDArray[np.bool_] | None = None, count: int = FEWEST) -> Spectrum:
    """The multipliers of an orbit.

    The bar of a multiplier is its condition 1 / |<y, x>|, for unit eigenvectors x to the right and y to the left, times the
    error of the matrix: rounding and the uncertainty of the orbit, both relative to the norm, and |G' x - mu x|.

    Parameters
    ----------
    orbit : Orbit
        The orbit.
    cells : array of bool, shape (N,), optional
        Changes of these cells alone are followed: what leaves them is gone. Without, the whole ring.
    count : int
        How many are found at least, if possible, of a matrix above `DENSE` unknowns; of a smaller one all are.
    """
    components, size = orbit.state.shape
    kept = np.flatnonzero(np.tile(np.ones(size, dtype=bool) if cells is None else cells, components))
    matrix = np.ascontiguousarray(orbit.monodromy[np.ix_(kept, kept)])
    values, left, right = _eigenpairs(matrix, max(count, FEWEST))
    order = np.argsort(-np.abs(values), kind="stable")
    values, left, right = values[order], left[:, order], right[:, order]
    condition = 1 / np.maximum(np.abs(np.sum(left.conj() * right, axis=0)), np.finfo(float).tiny)
    missed = np.linalg.norm(matrix @ right - right * values, axis=0)
    # The largest singular value is below the geometric mean of these two norms.
    norm = float(np.sqrt(np.linalg.norm(matrix, 1) * np.linalg.norm(matrix, np.inf)))
    modes = np.zeros((values.size, components * size), dtype=np.complex128)
    modes[:, kept] = right.T
    return Spectrum(values, condition * (norm * (ROUNDING + orbit.uncertainty) + missed), modes)


def _eigenpairs(matrix: Array, count: int) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Eigenvalues with unit eigenvectors to the left and to the right, in columns."""
    from scipy.linalg import eig

    found = _largest(matrix, count) if matrix.shape[0] > DENSE else None
    if found is not None:
        return found
    values, left, right = eig(matrix, left=True, right=True)
    return values, left, right


def _largest(matrix: Array, count: int) -> tuple[ComplexArray, ComplexArray, ComplexArray] | None:
    """The same for the largest only, by Arnoldi's method; None where it does not find one."""
    values, right = _arnoldi(matrix, count)
    others, left = _arnoldi(np.ascontiguousarray(matrix.T), count)
    if not (values.size and others.size):
        return None
    # An eigenvector y of the transposed matrix is the conjugate of one to the left.
    partner = np.abs(others[None, :] - values[:, None]).argmin(axis=1)
    return values, left[:, partner].conj(), right


def _arnoldi(matrix: Array, count: int) -> tuple[ComplexArray, ComplexArray]:
    """The largest eigenvalues that Arnoldi's method finds, and their eigenvectors in columns."""
    from scipy.sparse.linalg import ArpackNoConvergence, eigs

    start = np.random.default_rng(0).normal(size=matrix.shape[0])
    try:
        values, vectors = eigs(matrix, k=count, ncv=min(20 * count, matrix.shape[0] - 1), v0=start)
    except ArpackNoConvergence as error:
        values, vectors = error.eigenvalues, error.eigenvectors
    return np.asarray(values), np.asarray(vectors)


def changes(values: ComplexArray, others: ComplexArray) -> Array:
    """By how much the modulus of each multiplier differs from that of the nearest of others."""
    nearest = np.abs(values[:, None] - others[None, :]).argmin(axis=1)
    return np.asarray(np.abs(np.abs(values) - np.abs(others[nearest])))


def verdict(values: ComplexArray, errors: Array) -> Verdict:
    """Whether a multiplier lies outside the unit circle by more than its bar: "unstable" if so.

    "stable" is neutral stability: none does, and no bar of one that may lie outside is wider than `CERTAIN`. What lies inside
    by more than that does not count, however wide its bar: a shift out of a window has multipliers 0, of so large a
    condition that rounding spreads them over a disk.
    """
    outside = np.abs(values) - 1
    if (outside > errors).any():
        return "unstable"
    return "undecided" if ((outside > -CERTAIN) & (outside + errors > CERTAIN)).any() else "stable"
