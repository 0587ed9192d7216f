from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import InputError
from mol_compactons.expressions import pointwise
from tests.expressions.formulas import NUMPY, formulas


@given(formulas, st.integers(0, 1000))
def test_values_are_those_of_numpy(text: str, seed: int) -> None:
    x, y = np.random.default_rng(seed).normal(size=(2, 5))
    with np.errstate(all="ignore"):
        expected = eval(text, {}, {**NUMPY, "pi": np.pi, "e": np.e, "x": x, "y": y, "a": 0.75}) + np.zeros(5)
    if np.all(np.abs(expected) < 1e50):
        found = pointwise(text, ("x", "y"), {"a": 0.75})(x, y)
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * (1 + np.abs(expected).max()))


@given(formulas, st.integers(0, 1000))
def test_slopes_are_the_derivatives_by_complex_steps(text: str, seed: int) -> None:
    """Im f(x + i h) / h is f' without cancellation, for the functions that are analytic."""
    if any(name in text for name in ("abs", "max", "min", "sign")):
        return
    rng = np.random.default_rng(seed)
    x, y = rng.normal(size=(2, 5))
    names = {**NUMPY, "pi": np.pi, "e": np.e, "y": y, "a": 0.75}
    with np.errstate(all="ignore"):
        complex_value = eval(text, {}, {**names, "x": x + 1e-200j}) + np.zeros(5)
    expected = complex_value.imag / 1e-200
    if np.all(np.abs(complex_value) < 1e50) and np.all(np.abs(expected) < 1e50):
        found = pointwise(text, ("x", "y"), {"a": 0.75}).slope("x", x, y)
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8 * (1 + np.abs(expected).max()))


@pytest.mark.parametrize(
    ("text", "x", "sentence"),
    [
        ("1 + 2/x", 0.0, "'2/x' at character 5 divides by 'x', which is 0 at x = 0"),
        ("x**-2", 0.0, "raises 'x', which is 0 at x = 0, to the power -2"),
        ("x**1.5", -3.0, r"raises 'x', which is negative at x = -3, to the power 1.5; write abs\(x\)\*\*1.5"),
        ("sqrt(x - 1)", 0.5, "raises 'x - 1', which is negative at x = 0.5"),
        ("log(x)", 0.0, r"takes the logarithm of 'x', which is not positive at x = 0; write log\(abs\(x\) \+ 1e-9\)"),
    ],
)
def test_a_place_without_a_value_is_named(text: str, x: float, sentence: str) -> None:
    formula = pointwise(text, role="initial")
    assert np.isfinite(formula(2.0))
    with pytest.raises(InputError, match="initial: .*" + sentence):
        formula([2.0, x])


@given(st.integers(0, 1000), st.sampled_from(["x**5", "x**3 - x*abs(x)", "sign(x)*abs(x)**1.3", "sin(x) + x/(1 + x**2)"]))
def test_odd_formulas_are_odd_to_the_last_bit(seed: int, text: str) -> None:
    x = np.random.default_rng(seed).normal(size=9)
    formula = pointwise(text)
    assert np.array_equal(formula(-x), -formula(x))


def test_parameters_may_be_exponents() -> None:
    assert pointwise("abs(x)**(n - 1)*x", parameters={"n": 1.5})(4.0) == 8.0
    assert pointwise("x**n", parameters={"n": 3})(-2.0) == -8.0


def test_the_shape_is_that_of_the_values() -> None:
    formula = pointwise("x*t + 1", names=("x", "t"))
    assert isinstance(formula(2.0, 3.0), float)
    assert formula(np.ones((2, 3)), 2.0).shape == (2, 3)
    assert formula([1.0, 2.0], 1.0).tolist() == [2.0, 3.0]
    assert formula.slope("t", [1.0, 2.0], 1.0).tolist() == [1.0, 2.0]
    with pytest.raises(InputError, match="is a function of x, t; give 2 values"):
        formula(1.0)


def test_a_formula_can_be_stored_and_sent() -> None:
    formula = pointwise("k*x**2", parameters={"k": 3})
    assert pickle.loads(pickle.dumps(formula)) == formula
    assert hash(formula) == hash(pointwise("k*x**2", parameters={"k": 3}))
    assert formula != pointwise("k*x**2", parameters={"k": 4})


def test_threads_may_share_a_formula() -> None:
    formula = pointwise("exp(-x**2/4) + x*sin(3*x)")
    arrays = [np.linspace(-1, 1, 2000) + k for k in range(16)]
    expected = [formula(x) for x in arrays]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(formula, arrays))
    assert all(np.array_equal(a, b) for a, b in zip(found, expected, strict=True))
