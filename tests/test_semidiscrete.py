from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import CompactScheme, GranularCompacton, Grid, stencils
from mol_compactons.semidiscrete import SemiDiscretization
from tests.systems import dense_stencil, random_state


def system(size: int, components: int = 1) -> SemiDiscretization:
    one = CompactScheme().discretize(GranularCompacton(3), Grid(length=10, size=size))
    return replace(one, components=components)


@given(st.integers(9, 40), st.integers(1, 2), st.integers(0, 1000))
def test_folding_is_undone(size: int, components: int, seed: int) -> None:
    ring = system(size, components)
    state = random_state(seed, components, size)
    assert np.array_equal(ring.unfold(ring.fold(state)), state)


@pytest.mark.parametrize("components", [1, 2])
@pytest.mark.parametrize("size", [9, 10, 31, 32])
def test_folded_neighbours_on_the_ring_lie_within_the_band(size: int, components: int) -> None:
    ring = system(size, components)
    rows, columns = ring.sparsity.nonzero()
    assert np.abs(rows - columns).max() <= ring.half_bandwidth


def test_dense_and_sparse_hold_the_same_matrix() -> None:
    ring = system(20)
    diagonals = np.random.default_rng(1).normal(size=ring.mass_diagonals.shape)
    matrix = ring.sparsity.copy()
    matrix.data = ring.csc_values(diagonals)
    assert np.array_equal(matrix.toarray(), ring.dense(diagonals)[np.ix_(ring.order, ring.order)])


def test_rate_solves_with_the_mass_matrix() -> None:
    ring = system(21)
    state = random_state(3, 1, 21)
    f, product = np.empty_like(state), np.empty_like(state)
    ring.rhs(0.0, state, f)
    ring.apply_mass(ring.rate(0.0, state), product)
    assert np.allclose(product, f, atol=1e-12 * np.abs(f).max())
    assert np.allclose(product[0], dense_stencil(stencils.COMPACT_MASS, 21, 1.0) @ ring.rate(0.0, state)[0])


def test_mass_diagonals_are_the_mass_matrix() -> None:
    ring = system(15)
    matrix = ring.sparsity.copy()
    matrix.data = ring.csc_values(ring.mass_diagonals)
    folded = dense_stencil(stencils.COMPACT_MASS, 15, 1.0)[np.ix_(ring.order, ring.order)]
    assert np.allclose(matrix.toarray(), folded)
