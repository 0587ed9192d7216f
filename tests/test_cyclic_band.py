from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    Compacton,
    CompactScheme,
    ConservativeScheme,
    GranularCompacton,
    Grid,
    IntegrationError,
    Midpoint,
    run,
)
from mol_compactons.integrators.cyclic_band import CyclicLU
from mol_compactons.integrators.newton import BandedMatrix
from mol_compactons.semidiscrete import SemiDiscretization
from tests.systems import Array, one_compacton


def system_with(jacobian: Array) -> SemiDiscretization:
    """y' = J y, with J given by its cyclic diagonals."""

    def write(t: float, state: Array, out: Array) -> None:
        out[:] = jacobian

    components, _, diagonals, size = jacobian.shape
    return SemiDiscretization(
        size=size,
        components=components,
        reach=(diagonals - 1) // 2,
        rhs=lambda t, state, out: None,
        jacobian=write,
        invariants=lambda state: {},
    )


def random_jacobian(seed: int, components: int, reach: int, size: int) -> Array:
    return np.random.default_rng(seed).normal(size=(components, components, 2 * reach + 1, size))


shapes = st.tuples(st.integers(0, 10**6), st.integers(1, 2), st.integers(1, 4), st.integers(0, 40))


@given(shapes, st.floats(-1, 1))
def test_it_solves_what_numpy_solves(shape: tuple[int, int, int, int], fraction: float) -> None:
    """Rings of any length from the least on, where the band is shorter than its border; steps backwards too."""
    seed, components, reach, more = shape
    size = 2 * reach + 1 + more
    jacobian = random_jacobian(seed, components, reach, size)
    gamma = fraction / (2 * (2 * reach + 1) * components)
    system = system_with(jacobian)
    factors = CyclicLU(system)
    assert factors.factor(jacobian, gamma)
    residual = np.random.default_rng(seed).normal(size=(components, size))
    solution = np.empty_like(residual)
    factors.solve_into(residual, solution)
    exact = np.linalg.solve(np.eye(components * size) - gamma * system.dense(jacobian), residual.ravel())
    assert np.allclose(solution.ravel(), exact, rtol=0, atol=1e-11 * np.abs(exact).max())
    factors.solve_into(residual, residual)
    assert np.array_equal(residual, solution)


@given(shapes, st.sampled_from([1.0, 30.0, 1e6]))
def test_a_matrix_that_needs_pivots_gets_them(shape: tuple[int, int, int, int], gamma: float) -> None:
    """Far from the identity: whichever LU is taken, its residual is small."""
    seed, components, reach, more = shape
    size = 2 * reach + 1 + more
    system = system_with(random_jacobian(seed, components, reach, size))
    matrix = BandedMatrix(system)
    state = np.zeros((components, size))
    assert matrix.factor(0.0, state, gamma)
    dense = np.eye(components * size) - gamma * system.dense(random_jacobian(seed, components, reach, size))
    residual = np.random.default_rng(seed).normal(size=state.shape)
    solution = matrix.solve(0.0, state, residual)
    scale = np.abs(dense).sum(axis=1).max() * np.abs(solution).max()
    assert np.abs(dense @ solution.ravel() - residual.ravel()).max() < 1e-9 * scale


def test_what_cannot_be_factored_is_refused() -> None:
    size = 9
    identity = np.zeros((1, 1, 3, size))
    identity[0, 0, 1] = 1
    factors = CyclicLU(system_with(identity))
    assert not factors.factor(identity, 1.0)
    assert not factors.factor(np.full_like(identity, np.nan), 1.0)
    shift = np.zeros_like(identity)
    shift[0, 0, 2] = 1
    assert not factors.factor(identity + shift, 1.0)
    assert BandedMatrix(system_with(identity + shift)).factor(0.0, np.zeros((1, size)), 1.0)


@pytest.mark.parametrize("scheme", [CompactScheme("wide", 1e-3), CompactScheme("nearest", 1e-5), ConservativeScheme(6)])
@pytest.mark.parametrize("n", [1.5, 3.0])
def test_compactons_need_no_pivots(scheme: CompactScheme | ConservativeScheme, n: float) -> None:
    equation, grid = GranularCompacton(n), Grid(40, 400)
    system = scheme.discretize(equation, grid)
    jacobian = np.empty_like(system.mass_diagonals)
    system.jacobian(0.0, Compacton(1, 20).values(equation, grid), jacobian)
    assert CyclicLU(system).factor(jacobian, 0.02)


def test_a_singular_matrix_is_an_error_of_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    for cls in ("CyclicLU", "FoldedLU"):
        monkeypatch.setattr(f"mol_compactons.integrators.newton.{cls}.factor", lambda *arguments: False)
    with pytest.raises(IntegrationError, match="The matrix of the midpoint rule is singular"):
        run(one_compacton(integrator=Midpoint()))
