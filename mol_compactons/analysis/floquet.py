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
Eigenpairs = tuple[ComplexArray, ComplexArray, ComplexArray]

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

    All norms are those of the balanced matrix B = T^-1 G' T, with T diagonal, up to the order of the unknowns: a weighted
    norm, without which the shift out of a window has no useful condition. Its error is that of rounding and of the orbit,
    both relative to the norm, and |B x - mu x|. The bar of a multiplier is this error times the condition 1 / |<y, x>|, for
    unit eigenvectors x to the right and y to the left. Where that is more than an eighth of the distance to the next one it is
    no bound any more, and that of `_pair_bar` is taken: the multiplier 1 of a wave is double with one eigenvector.

    Parameters
    ----------
    orbit : Orbit
        The orbit.
    cells : array of bool, shape (N,), optional
        Changes of these cells alone are followed: what leaves them is gone. Without, the whole ring.
    count : int
        How many are found at least, if possible, of a matrix above `DENSE` unknowns; of a smaller one all are.
    """
    from scipy.linalg import matrix_balance

    components, size = orbit.state.shape
    kept = np.flatnonzero(np.tile(np.ones(size, dtype=bool) if cells is None else cells, components))
    # It turns weights into whole numbers on the way, in places that it does not use.
    with np.errstate(invalid="ignore"):
        matrix, transform = matrix_balance(orbit.monodromy[np.ix_(kept, kept)])
    values, left, right = _eigenpairs(matrix, max(count, FEWEST))
    order = np.argsort(-np.abs(values), kind="stable")
    values, left, right = values[order], left[:, order], right[:, order]
    condition = 1 / np.maximum(np.abs(np.sum(left.conj() * right, axis=0)), np.finfo(float).tiny)
    missed = np.linalg.norm(matrix @ right - right * values, axis=0)
    # The largest singular value is below the geometric mean of these two norms.
    norm = float(np.sqrt(np.linalg.norm(matrix, 1) * np.linalg.norm(matrix, np.inf)))
    wrong = norm * (ROUNDING + orbit.uncertainty) + missed
    pairs = values, left, right
    errors = np.array([_bar(index, one, matrix, pairs, wrong) for index, one in enumerate(condition * wrong)])
    modes = np.zeros((values.size, components * size), dtype=np.complex128)
    own = transform @ right
    modes[:, kept] = (own / np.linalg.norm(own, axis=0)).T
    return Spectrum(values, errors, modes)


def _bar(index: int, simple: float, matrix: Array, pairs: Eigenpairs, wrong: Array) -> float:
    """The bar of a multiplier from that of first order, or from its nearest neighbour."""
    gaps = np.abs(pairs[0] - pairs[0][index])
    gaps[index] = np.inf
    nearest = int(gaps.argmin())
    if simple <= gaps[nearest] / 8:
        # Two that repel each other move by a little more than in first order.
        return float(simple * (1 + 2 * simple / gaps[nearest]))
    return _pair_bar([index, nearest], matrix, pairs, wrong)


def _pair_bar(pair: list[int], matrix: Array, pairs: Eigenpairs, wrong: Array) -> float:
    """The bar of two neighbours as one cluster, in whose plane the matrix is P, of two rows.

    With m their mean, an error e of P moves the eigenvalues by at most sqrt((2 |P - m| + e) e), and e is that of the matrix
    times the norm of the projector on the plane. Source: Elsner, Linear Algebra Appl. 71 (1985) 77.
    """
    values, left, right = pairs
    plane, rows = np.linalg.qr(right[:, pair])[0], np.linalg.qr(left[:, pair])[0].conj().T
    overlap = np.linalg.svd(rows @ plane, compute_uv=False)[-1]
    if not overlap > 0:
        return float("inf")
    error = float(wrong[pair].max() / overlap)
    inner = np.linalg.solve(rows @ plane, rows @ matrix @ plane) - values[pair].mean() * np.eye(2)
    return float(np.sqrt((2 * np.linalg.norm(inner, 2) + error) * error))


def _eigenpairs(matrix: Array, count: int) -> Eigenpairs:
    """Eigenvalues with unit eigenvectors to the left and to the right, in columns."""
    from scipy.linalg import eig

    found = _largest(matrix, count) if matrix.shape[0] > DENSE else None
    if found is not None:
        return found
    values, left, right = eig(matrix, left=True, right=True)
    return values, left, right


def _largest(matrix: Array, count: int) -> Eigenpairs | None:
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
