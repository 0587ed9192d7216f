from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import InputError
from mol_compactons.expressions import FUNCTIONS, Program, parse, pointwise

NUMPY: dict[str, Any] = {
    **{name: getattr(np, name) for name in FUNCTIONS if hasattr(np, name)},
    "abs": np.abs,
    "max": np.maximum,
    "min": np.minimum,
    "sech": lambda value: 1 / np.cosh(value),
    "heaviside": lambda value: np.heaviside(value, 0.5),
}
"""What the functions of a formula mean."""

leaves = st.sampled_from(["x", "y", "a", "2", "0.5", "1.25e-1", "pi", "e"])


def larger(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.one_of(
        st.builds("({} {} {})".format, inner, st.sampled_from("+-*"), inner),
        st.builds("({}) / (1.5 + ({})**2)".format, inner, inner),
        st.builds("(-{})".format, inner),
        st.builds("({})**{}".format, inner, st.sampled_from([0, 1, 2, 3, 5])),
        st.builds("(1 + ({})**2)**{}".format, inner, st.sampled_from(["-1", "(-2)", "0.5", "1.5", "(1/3)", "-0.75"])),
        st.builds("{}({})".format, st.sampled_from(["sin", "cos", "tanh", "abs", "sech", "sign"]), inner),
        st.builds("{}({}, {})".format, st.sampled_from(["max", "min"]), inner, inner),
    )


formulas = st.recursive(leaves, larger, max_leaves=8)


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


HOSTILE = [
    "__import__('os').system('ls')",
    "__import__(os)",
    "().__class__.__bases__",
    "u.__class__",
    "exec(u)",
    "eval(u)",
    "open(u)",
    "globals()",
    "lambda: u",
    "[u for u in x]",
    "{u: u}",
    "u if u else 0",
    "(u := 3)",
    "'a' * 10",
    "f'{u}'",
    "u[0]",
    "u @ u",
    "u; u",
    "not u",
    "yield",
    "await u",
    "10**10**10",
    "9**9**9**9",
    "(u**1000)**1000",
    "exp(exp(exp(100)))",
    "1e999",
    "9" * 400,
    "(" * 900 + "u" + ")" * 900,
    "-" * 1900 + "u",
    "u" + "+u" * 900,
    "u" * 5000,
    "u\x00",
    "ü",
    "u\\\nu",
    "# u",
    "1j",
    "0x10",
    "1_000",
    "*u",
    "sin(*u)",
    "sin(u=1)",
    "",
    "  \n ",
]


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_texts_get_a_sentence(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing of the text is ever run."""
    monkeypatch.setattr("builtins.eval", None)
    monkeypatch.setattr("builtins.exec", None)
    with pytest.raises(InputError) as caught:
        parse(text, "CustomEquation.flux", ("u", "x", "t"), {"nu": 0.1}, derivatives=True)
    sentence = str(caught.value)
    assert sentence.startswith("CustomEquation.flux")
    assert sentence.endswith((".", "?"))
    assert "\n" not in sentence
    assert len(sentence) < 400


@pytest.mark.parametrize(
    ("text", "place", "cure"),
    [
        ("u^2", "at character 2, '^'", "write ** for a powe"),
        ("u + 2u", "at character 6, 'u'", "write * between them"),
        ("u (u + 1) (u)", "at character 11, '('", "write * between them"),
        ("|u|", "at character 1, '|'", "write abs(...)"),
        ("F = u", "at character 3, '='", "one side of an equation"),
        ("heaviside(u > 0)", "at character 13, '>'", "heaviside"),
        ("u**2 + u_xx", "at character 8, 'u_xx'", "write d2(u)"),
        ("u + nv", "at character 5, 'nv'", "did you mean 'nu'"),
        ("3*W", "at character 3, 'W'", "u, x, t, nu, pi, e"),
        ("\n  u**2\n  + q", "at character 13, 'q'", "it may be"),
        ("sin + u", "at character 1, 'sin'", "write sin(...)"),
        ("u*tg(u)", "at character 3, 'tg'", "tan"),
        ("d4(u)", "at character 1, 'd4'", "did you mean 'd3'"),
        ("nu(u)", "at character 1, 'nu'", "write nu*(...)"),
        ("max(u)", "at character 1, 'max(u)'", "2 arguments"),
        ("sin(u, u)", "at character 1, 'sin(u, u)'", "1 argument"),
        ("1,5*u", "at character 1, '1,5", "decimal point"),
        ("u**u", "at character 4, 'u'", "numbers and parameters"),
        ("2**(u + 1)", "at character 5, 'u + 1'", "write exp((u + 1)*log(2))"),
        ("u**101", "at character 4, '101'", "between -100 and 100"),
        ("u +", "at character 3, '+'", "go on with a value"),
        ("(u", "at character 1", "1 bracket must be closed"),
        ("u))", "at character 2", "2 brackets too many close"),
        ("u // 2", "at character 1, 'u // 2'", "numbers, names and functions"),
        ("u + 1/(2 - 2)", "at character 5, '1/(2 - 2)'", "write one that does"),
        ("(-8)**(1/3)", "at character 1", "write one that does"),
        ("lambda*u", "at character 1, 'lambda'", "choose another name"),
        ("u" + "*u" * 40 + "*q" + "*u" * 40, "...': at character 83, 'q'", "it may be"),
    ],
)
def test_sentences_point_at_the_place_and_say_what_to_write(text: str, place: str, cure: str) -> None:
    with pytest.raises(InputError) as caught:
        parse(text, "CustomEquation.flux", ("u", "x", "t"), {"nu": 0.1}, derivatives=True)
    problem, _, advice = str(caught.value).partition("; ")
    assert place in problem
    assert cure in advice


def test_derivatives_only_where_they_are_allowed() -> None:
    with pytest.raises(InputError, match="a derivative in space stands where there is none"):
        pointwise("d2(x)")
    tree = parse("d2(x)", "f", ("x",), derivatives=True)
    with pytest.raises(InputError, match="d2 stands where there is no grid"):
        Program((tree,)).evaluate(3, {"x": np.zeros(3)})


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


def test_a_slope_that_is_infinite_is_regularised() -> None:
    x = np.array([-1.0, 0.0, 1e-12, 1.0])
    slope = pointwise("abs(x)**0.5").slope("x", x)
    assert np.all(np.isfinite(slope))
    np.testing.assert_allclose(slope[[0, 3]], [-0.5, 0.5], rtol=1e-14)
    assert slope[2] == pytest.approx(0.5 * 1e3)
    assert not np.any(pointwise("abs(x)**0.25").slope("x", np.zeros(3)))


@given(st.integers(0, 1000), st.sampled_from(["x**5", "x**3 - x*abs(x)", "sign(x)*abs(x)**1.3", "sin(x) + x/(1 + x**2)"]))
def test_odd_formulas_are_odd_to_the_last_bit(seed: int, text: str) -> None:
    x = np.random.default_rng(seed).normal(size=9)
    formula = pointwise(text)
    assert np.array_equal(formula(-x), -formula(x))


@given(st.floats(0, 1e3), st.integers(1, 32))
def test_quarter_powers(x: float, quarters: int) -> None:
    assert pointwise(f"abs(x)**({quarters}/4)")(x) == pytest.approx(x ** (quarters / 4), rel=1e-14)


def test_equal_parts_are_computed_once() -> None:
    tree = parse("d2(u**2) + u*d2(u*u) + sin(u)*sin(u)", "f", ("u",), derivatives=True)
    program = Program((tree,))
    assert len(program.differences) == 1
    assert program.rows == len({*program.code[:, 3], *program.inputs.values()})


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
