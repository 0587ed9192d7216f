from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons.integrators.linear.band import FoldedLU
from mol_compactons.semidiscrete import SemiDiscretization


def ring(size: int, components: int, reach: int) -> SemiDiscretization:
    """A system of which only the layout counts."""
    return SemiDiscretization(size, components, reach, rhs=lambda t, state, out: None, invariants=lambda state: {})


@given(st.integers(1, 3), st.integers(1, 2), st.integers(0, 20), st.integers(0, 10**6), st.sampled_from([1.0, 1e-8]))
def test_it_solves_what_numpy_solves(reach: int, components: int, more: int, seed: int, diagonal: float) -> None:
    """Also with a small diagonal, where every row needs its pivot."""
    system = ring(2 * reach + 1 + more, components, reach)
    random = np.random.default_rng(seed)
    jacobian = random.normal(size=system.mass_diagonals.shape)
    jacobian[:, :, reach] *= diagonal
    dense = system.dense(system.mass_diagonals - 0.7 * jacobian)
    if np.linalg.cond(dense) > 1e10:
        return
    residual = random.normal(size=(components, system.size))
    factors = FoldedLU(system)
    assert factors.factor(jacobian, 0.7)
    out = residual.copy()
    factors.solve_into(out, out)
    exact = np.linalg.solve(dense, residual.ravel())
    assert np.allclose(out.ravel(), exact, rtol=1e-5, atol=1e-5 * np.abs(exact).max())


def test_a_singular_matrix_and_nan_are_noticed() -> None:
    system = ring(9, 1, 2)
    factors = FoldedLU(system)
    assert not factors.factor(system.mass_diagonals, 1.0)
    assert not factors.factor(np.full(system.mass_diagonals.shape, np.nan), 1.0)
    assert factors.factor(system.mass_diagonals, 0.5)
