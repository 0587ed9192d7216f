from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mol_compactons import (
    Compacton,
    CompactScheme,
    ConservativeScheme,
    GranularCompacton,
    Grid,
)
from mol_compactons.integrators.linear.band import FoldedLU
from mol_compactons.integrators.linear.cyclic_band import LARGEST_GROWTH, CyclicLU
from mol_compactons.integrators.linear.newton import BandedMatrix
from tests.integrators.linear.rings import random_jacobian, system_with
from tests.systems import Array

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
    """Wherever they are, across the end of the ring too; the solutions are those of the LU that pivots."""
    equation, grid = GranularCompacton(n), Grid(40, 400)
    system = scheme.discretize(equation, grid)
    jacobian = np.empty_like(system.mass_diagonals)
    factors, reference = CyclicLU(system), FoldedLU(system)
    residual = np.random.default_rng(0).normal(size=(1, grid.size))
    solution, other = np.empty_like(residual), np.empty_like(residual)
    for center in (20, 0, 39.5, 3, 36):
        system.jacobian(0.0, Compacton(1, center).values(equation, grid), jacobian)
        assert factors.factor(jacobian, 0.02)
        assert reference.factor(jacobian, 0.02)
        factors.solve_into(residual, solution)
        reference.solve_into(residual, other)
        assert np.abs(solution - other).max() < 1e-11 * np.abs(other).max()


def test_factors_that_grow_are_refused() -> None:
    """A well-conditioned matrix (5.5) whose first pivots are small at every cut."""
    size = 31
    for small in (1e-3, 1e-6, 1e-9):
        jacobian = np.zeros((1, 1, 3, size))
        jacobian[0, 0] = np.array([-1.0, 1 - small, -0.7])[:, None]
        system = system_with(jacobian)
        assert not CyclicLU(system).factor(jacobian, 1.0)
        residual = np.random.default_rng(1).normal(size=(1, size))
        matrix = BandedMatrix(system)
        assert matrix.factor(0.0, residual, 1.0)
        solution = matrix.solve(0.0, residual, residual)
        dense = np.eye(size) - system.dense(jacobian)
        assert np.abs(dense @ solution[0] - residual[0]).max() < 1e-13


def test_fill_that_is_negligible_is_dropped_and_no_other() -> None:
    """On a long ring where the fill decays slowly the solution is that of numpy, though most of the ring does without it."""
    size = 2000
    jacobian = random_jacobian(3, 1, 2, size)
    jacobian[0, 0, 2] = 0
    system = system_with(jacobian)
    factors = CyclicLU(system)
    assert factors.factor(jacobian, 0.2)
    assert 30 < factors._head < size - 100
    residual = np.zeros((1, size))
    residual[0, [0, 1, -1, -2]] = 1
    solution = np.empty_like(residual)
    factors.solve_into(residual, solution)
    exact = np.linalg.solve(np.eye(size) - 0.2 * system.dense(jacobian), residual[0])
    assert np.abs(solution[0] - exact).max() < 1e-14
    near, far = np.abs(exact) > 1e-14, np.abs(exact) < 1e-25
    assert np.allclose(solution[0][near], exact[near], rtol=1e-2)
    assert np.abs(solution[0][far]).max() < 1e-19


def test_an_infinite_entry_is_refused_wherever_it_stands() -> None:
    for cell in (0, 5, 39):
        for diagonal in range(7):
            jacobian = 0.01 * random_jacobian(1, 1, 3, 40)
            jacobian[0, 0, diagonal, cell] = np.inf
            assert not CyclicLU(system_with(jacobian)).factor(jacobian, 0.5)


def growth(matrix: Array, border: int) -> float:
    """The largest entry of L times that of U where all but the border is eliminated, relative to the largest of the matrix."""
    rest, lower, upper = matrix.copy(), 0.0, 1.0
    for pivot in range(len(matrix) - border):
        column, row = rest[pivot:, pivot].copy(), rest[pivot, pivot + 1 :] / rest[pivot, pivot]
        lower, upper = max(lower, np.abs(column).max()), max(upper, np.abs(row).max())
        rest[pivot + 1 :, pivot + 1 :] -= np.outer(column[1:], row)
    return float(lower * upper / np.abs(matrix).max())


@given(st.integers(0, 10**6), st.integers(1, 2), st.integers(5, 12), st.floats(0.1, 3), st.sampled_from([1, 1e-3, 1e3]))
@settings(max_examples=300)
def test_it_refuses_growth_wherever_it_is(seed: int, reach: int, size: int, exponent: float, scale: float) -> None:
    """At any scale: few entries beside the diagonal, and one small pivot, after which some entries of L or U are large."""
    rng = np.random.default_rng(seed)
    matrix = random_jacobian(seed, 1, reach, size) * (rng.random((1, 1, 2 * reach + 1, size)) < 0.4)
    matrix[0, 0, reach] = 1
    matrix[0, 0, reach, rng.integers(size - reach)] = 10**-exponent
    matrix *= scale
    identity = np.zeros_like(matrix)
    identity[0, 0, reach] = 1
    system = system_with(identity - matrix)
    expected = growth(np.eye(size) - system.dense(identity - matrix), reach)
    assume(abs(np.log(expected / LARGEST_GROWTH)) > 1e-6)
    assert CyclicLU(system)._factor_as_cut(identity - matrix, 1.0) == (expected < LARGEST_GROWTH)


@pytest.mark.parametrize("place", [0, 1, 31, 32, 63, 64, 95, 127, 150, 199])
def test_a_nan_in_the_residual_stays_in_the_solution(place: int) -> None:
    """It does not count as a solution that has faded."""
    jacobian = random_jacobian(1, 1, 2, 200)
    factors = CyclicLU(system_with(jacobian))
    assert factors.factor(jacobian, 0.02)
    residual = np.zeros((1, 200))
    residual[0, place] = np.nan
    solution = np.empty_like(residual)
    factors.solve_into(residual, solution)
    assert np.isnan(solution[0, place])


def test_far_from_its_residual_a_solution_is_zero_and_no_subnormal_number() -> None:
    size = 3000
    jacobian = random_jacobian(3, 1, 2, size)
    system = system_with(jacobian)
    factors = CyclicLU(system)
    assert factors.factor(jacobian, 0.02)
    residual = np.zeros((1, size))
    residual[0, size // 2] = 1.0
    solution = np.empty_like(residual)
    factors.solve_into(residual, solution)
    exact = np.linalg.solve(np.eye(size) - 0.02 * system.dense(jacobian), residual.ravel())
    assert np.abs(solution[0] - exact).max() < 1e-14
    subnormal = (solution != 0) & (np.abs(solution) < np.finfo(float).tiny)
    assert subnormal.sum() < 40
    assert (solution == 0).sum() > size // 2
