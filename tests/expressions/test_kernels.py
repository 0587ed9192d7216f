from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons.expressions import kernels, pointwise
from tests.systems import Array, random_state


@pytest.mark.parametrize(
    ("text", "slope"),
    [
        ("abs(x)", lambda x: np.sign(x)),
        ("sign(x) + heaviside(x)", lambda x: 0 * x),
        ("exp(x)", np.exp),
        ("log(1 + x**2)", lambda x: 2 * x / (1 + x**2)),
        ("tan(x)", lambda x: 1 / np.cos(x) ** 2),
        ("sinh(x) - cosh(2*x)", lambda x: np.cosh(x) - 2 * np.sinh(2 * x)),
        ("sech(x)", lambda x: -np.tanh(x) / np.cosh(x)),
        ("max(x, x**2)", lambda x: np.where(x >= x**2, 1, 2 * x)),
        ("min(x, x**2)", lambda x: np.where(x < x**2, 1, 2 * x)),
        ("abs(x)**2.3", lambda x: 2.3 * np.abs(x) ** 1.3 * np.sign(x)),
        ("sqrt(4 + x)", lambda x: 0.5 / np.sqrt(4 + x)),
        ("x**-3", lambda x: -3 / x**4),
        ("7 + 0*x", lambda x: 0 * x),
    ],
)
def test_slopes_of_single_functions(text: str, slope: Any) -> None:
    x = np.array([-2.0, -0.7, 0.4, 1.9])
    np.testing.assert_allclose(pointwise(text).slope("x", x), slope(x), rtol=1e-12, atol=1e-12)


def test_a_slope_that_is_infinite_is_regularised() -> None:
    x = np.array([-1.0, 0.0, 1e-12, 1.0])
    slope = pointwise("abs(x)**0.5").slope("x", x)
    assert np.all(np.isfinite(slope))
    np.testing.assert_allclose(slope[[0, 3]], [-0.5, 0.5], rtol=1e-14)
    assert slope[2] == pytest.approx(0.5 * 1e3)
    assert not np.any(pointwise("abs(x)**0.25").slope("x", np.zeros(3)))


@given(st.floats(0, 1e3), st.integers(1, 32))
def test_quarter_powers(x: float, quarters: int) -> None:
    assert pointwise(f"abs(x)**({quarters}/4)")(x) == pytest.approx(x ** (quarters / 4), rel=1e-14)


def test_instructions_run_one_after_the_other_and_only_those_that_are_asked_for() -> None:
    """Rows: x, 2, x + 2, (x + 2) x."""
    code = np.array([[kernels.NUMBER, 0, 0, 1], [kernels.ADD, 0, 1, 2], [kernels.MULTIPLY, 2, 0, 3]])
    numbers, x = np.array([2.0, 0.0, 0.0]), np.linspace(-1, 1, 5)
    values = np.full((4, 5), -7.0)
    values[0] = x
    kernels.execute(code, numbers, 0, 2, values)
    assert np.array_equal(values[2], x + 2)
    assert (values[3] == -7).all()
    kernels.execute(code, numbers, 2, 3, values)
    assert np.array_equal(values[3], (x + 2) * x)
    slopes = np.zeros((4, 5))
    slopes[3] = 1
    kernels.differentiate(code, numbers, np.array([2, 1, 0]), values, slopes)
    assert slopes[0] == pytest.approx(2 * x + 2)


def test_every_operation_has_its_number() -> None:
    assert [getattr(kernels, name.upper()) for name in kernels.OPERATIONS] == list(range(len(kernels.OPERATIONS)))


@given(st.integers(0, 1000), st.integers(0, 2), st.integers(0, 2), st.integers(1, 9))
def test_the_diagonals_of_a_difference_are_those_of_the_matrix_product(seed: int, outer: int, inner: int, size: int) -> None:
    """On rings that are shorter than the stencils too, where they wrap."""
    random = np.random.default_rng(seed)
    stencil, diagonals = random.normal(size=2 * outer + 1), random.normal(size=(2 * inner + 1, size))
    out = np.zeros((2 * (outer + inner) + 1, size))
    kernels.add_shifted(stencil, diagonals, out)
    difference = np.tile(stencil[:, None], (1, size))
    assert dense(out) == pytest.approx(dense(difference) @ dense(diagonals), abs=1e-12)


def dense(diagonals: Array) -> Array:
    """Cyclic diagonals as a matrix."""
    reach, size = diagonals.shape[0] // 2, diagonals.shape[1]
    matrix = np.zeros((size, size))
    for offset in range(-reach, reach + 1):
        for cell in range(size):
            matrix[cell, (cell + offset) % size] += diagonals[reach + offset, cell]
    return matrix


def test_rows_that_others_write_are_left_alone() -> None:
    code = np.array([[kernels.SIN, 0, 0, 1], [kernels.COS, 0, 0, 2]])
    values = np.zeros((3, 4))
    values[0] = random_state(1, 1, 4)[0]
    kernels.execute(code, np.zeros(2), 0, 2, values)
    slopes = np.zeros((3, 4))
    slopes[1] = 1
    kernels.differentiate(code, np.zeros(2), np.array([0]), values, slopes)
    assert slopes[0] == pytest.approx(np.cos(values[0]))
    assert not slopes[2].any()
