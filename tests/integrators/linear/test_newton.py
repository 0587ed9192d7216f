from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    ConservativeScheme,
    FourierScheme,
    GranularCompacton,
    Grid,
    InputError,
    IntegrationError,
    Midpoint,
    run,
)
from mol_compactons.integrators.linear.band import FoldedLU
from mol_compactons.integrators.linear.cyclic_band import CyclicLU
from mol_compactons.integrators.linear.newton import (
    INNER_TOLERANCE,
    BandedMatrix,
    KrylovCallbacks,
    KrylovMatrix,
    newton_matrix,
)
from mol_compactons.semidiscrete import SemiDiscretization
from tests.integrators.linear.rings import random_jacobian, system_with
from tests.systems import Array, one_compacton, random_state

shapes = st.tuples(st.integers(0, 10**6), st.integers(1, 2), st.integers(1, 4), st.integers(0, 40))


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


def test_a_singular_matrix_is_an_error_of_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    for cls in ("CyclicLU", "FoldedLU"):
        monkeypatch.setattr(f"mol_compactons.integrators.linear.newton.{cls}.factor", lambda *arguments: False)
    with pytest.raises(IntegrationError, match="The matrix of the midpoint rule is singular"):
        run(one_compacton(integrator=Midpoint()))


def test_which_way_suits_a_system() -> None:
    equation, grid = GranularCompacton(2), Grid(10, 24)
    assert isinstance(newton_matrix(ConservativeScheme().discretize(equation, grid)), BandedMatrix)
    assert isinstance(newton_matrix(FourierScheme().discretize(equation, grid)), KrylovMatrix)


@given(shapes, st.sampled_from([0.01, -0.02]))
def test_the_factors_stay_while_the_jacobian_stays(shape: tuple[int, int, int, int], gamma: float) -> None:
    """`linearize` once, `factor_linearized` for several gamma: each solves with its own matrix."""
    seed, components, reach, more = shape
    size = 2 * reach + 1 + more
    system = system_with(random_jacobian(seed, components, reach, size))
    state, residual = np.zeros((components, size)), random_state(seed, components, size)
    matrix, jacobian = BandedMatrix(system), system.dense(random_jacobian(seed, components, reach, size))
    matrix.linearize(0.0, state)
    for factor in (1.0, 0.5):
        assert matrix.factor_linearized(factor * gamma)
        solution = matrix.solve(0.0, state, residual)
        product = (np.eye(components * size) - factor * gamma * jacobian) @ solution.ravel()
        assert np.allclose(product, residual.ravel(), atol=1e-10)


def test_the_lu_without_pivots_is_taken_where_it_is_accurate_and_the_other_elsewhere() -> None:
    size = 31
    friendly, hostile = (np.zeros((1, 1, 3, size)) for _ in range(2))
    friendly[0, 0] = np.array([0.3, -1.0, 0.2])[:, None]
    hostile[0, 0] = np.array([-1.0, 1 - 1e-9, -0.7])[:, None]
    taken = []
    for jacobian in (friendly, hostile, friendly):
        matrix = BandedMatrix(system_with(jacobian))
        assert matrix.factor(0.0, np.zeros((1, size)), 1.0)
        taken.append(type(matrix._factors))
    assert taken == [CyclicLU, FoldedLU, CyclicLU]


def fourier(size: int = 24) -> tuple[SemiDiscretization, Array, Array]:
    """A smooth state of a system without a band, with a dense Jacobian by products with unit vectors."""
    grid = Grid(length=2 * np.pi, size=size)
    system = FourierScheme(dealias=False).discretize(GranularCompacton(3), grid)
    state = (2 + 0.3 * np.cos(grid.x))[None]
    columns = []
    assert system.jacobian_vector is not None
    for unit in np.eye(size):
        product = np.empty((1, size))
        system.jacobian_vector(0.0, state, unit[None], product)
        columns.append(product[0].copy())
    return system, state, np.array(columns).T


def test_gmres_reduces_the_residual_as_far_as_it_says() -> None:
    system, state, jacobian = fourier()
    matrix, gamma, residual = KrylovMatrix(system), 1e-3, random_state(5, 1, 24)
    assert matrix.factor(0.0, state, gamma)
    solution = matrix.solve(0.0, state, residual)
    left = (np.eye(24) - gamma * jacobian) @ solution[0] - residual[0]
    untouched = (np.eye(24) - gamma * jacobian) @ residual[0] - residual[0]
    assert np.linalg.norm(untouched) > 10 * INNER_TOLERANCE * np.linalg.norm(residual)
    # The preconditioned residual is what GMRES measures.
    assert np.linalg.norm(left) < 10 * INNER_TOLERANCE * np.linalg.norm(residual)


def test_gmres_leaves_a_thousandth_of_any_residual() -> None:
    system, state, jacobian = fourier()
    matrix, gamma, shares = KrylovMatrix(system), 1e-2, []
    assert matrix.factor(0.0, state, gamma)
    for seed in range(20):
        residual = random_state(seed, 1, 24)
        left = residual - matrix.solve(0.0, state, residual) @ (np.eye(24) - gamma * jacobian).T
        shares.append(float(np.linalg.norm(left) / np.linalg.norm(residual)))
    assert 5e-4 < max(shares) <= 1e-3


def test_the_callbacks_of_cvode_multiply_and_precondition() -> None:
    """In folded order: the product with df/dy, and the inverse of I - gamma J of the companion."""
    system, state, jacobian = fourier()
    callbacks, vector, result = KrylovCallbacks(system), random_state(6, 1, 24), np.empty(24)
    callbacks.multiply(0.0, system.fold(state), np.empty(24), system.fold(vector), result)
    assert system.unfold(result)[0] == pytest.approx(jacobian @ vector[0], rel=1e-10, abs=1e-10)
    renewed, companion = [0], system.companion
    assert companion is not None
    for gamma, reuse in ((1e-2, 0), (2e-2, 1)):
        callbacks.set_up_preconditioner(0.0, system.fold(state), np.empty(24), reuse, renewed, gamma)
        assert renewed == [1 - reuse]
        callbacks.precondition(0.0, system.fold(state), np.empty(24), system.fold(vector), result, gamma, 1e-3, 1)
        reference = BandedMatrix(companion)
        assert reference.factor(0.0, state, gamma)
        assert np.array_equal(system.unfold(result), reference.solve(0.0, state, vector))


def test_a_system_with_a_band_needs_no_krylov_solver() -> None:
    system, _, _ = fourier()
    for one in (one_compacton().discretize(), replace(system, companion=None)):
        with pytest.raises(InputError, match="'krylov' is for schemes without a banded Jacobian, such as FourierScheme"):
            KrylovMatrix(one)
