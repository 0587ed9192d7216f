from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons.integrators import band


def factored(dense: np.ndarray, width: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, bool]:
    size = dense.shape[0]
    storage, lower = np.zeros((size, 3 * width + 1)), np.empty((size, width))
    pivots = np.empty(size, dtype=np.intp)
    rows, columns = np.nonzero(np.abs(np.subtract.outer(np.arange(size), np.arange(size))) <= width)
    entries = rows * (3 * width + 1) + columns - rows + width
    mass, jacobian = dense[rows, columns] + 2.0, np.ones(rows.size)
    band.assemble(mass, jacobian, 2.0, entries, storage)
    return storage, lower, pivots, band.factor(storage, lower, pivots)


@given(st.integers(1, 30), st.integers(1, 6), st.integers(0, 10**6), st.sampled_from([1.0, 1e-8]))
def test_it_solves_what_numpy_solves(size: int, width: int, seed: int, diagonal: float) -> None:
    """Also with a small diagonal, where every row needs its pivot, and in any order of the unknowns."""
    random = np.random.default_rng(seed)
    dense = random.normal(size=(size, size))
    dense[np.abs(np.subtract.outer(np.arange(size), np.arange(size))) > width] = 0
    np.fill_diagonal(dense, diagonal * np.diag(dense))
    storage, lower, pivots, regular = factored(dense, width)
    residual, order = random.normal(size=size), random.permutation(size)
    if np.linalg.cond(dense) > 1e10:
        return
    assert regular
    solution = np.empty(size)
    band.solve(storage, lower, pivots, order, residual, np.zeros(size + 2 * width), solution)
    exact = np.linalg.solve(dense, residual[order])
    assert np.allclose(solution[order], exact, rtol=1e-5, atol=1e-5 * np.abs(exact).max())


def test_a_singular_matrix_and_nan_are_noticed() -> None:
    assert not factored(np.zeros((4, 4)), 1)[-1]
    assert not factored(np.full((4, 4), np.nan), 1)[-1]
