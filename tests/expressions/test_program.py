from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import InputError
from mol_compactons.expressions import Program, parse
from tests.expressions.formulas import NUMPY, formulas
from tests.systems import Array, random_state

NAMES = ("u", "v")


def tree(text: str) -> Program:
    return Program((parse(text, "f", NAMES, derivatives=True),))


def test_equal_parts_are_computed_once() -> None:
    tree = parse("d2(u**2) + u*d2(u*u) + sin(u)*sin(u)", "f", ("u",), derivatives=True)
    program = Program((tree,))
    assert len(program.differences) == 1
    assert program.rows == len({*program.code[:, 3], *program.inputs.values()})


def test_several_formulas_share_what_they_have_in_common() -> None:
    first, second = (parse(text, "f", NAMES) for text in ("sin(u*v) + 1", "cos(u*v)"))
    together = Program((first, second))
    assert together.rows == Program((first,)).rows + Program((second,)).rows - 3
    u, v = random_state(1, 2, 7)
    values = together.evaluate(7, {"u": u, "v": v, "unused": u})
    assert values[together.outputs[0]] == pytest.approx(np.sin(u * v) + 1, rel=1e-14)
    assert values[together.outputs[1]] == pytest.approx(np.cos(u * v), rel=1e-14)


def test_a_number_stands_for_its_array() -> None:
    program, u = tree("u*v"), np.linspace(0, 1, 5)
    assert np.array_equal(program.evaluate(5, {"u": u, "v": 2.0})[program.outputs[0]], 2 * u)


def spectral(values: Array, order: int) -> Array:
    """The derivative on a ring of 2 pi, exact for what it resolves."""
    wavenumbers = np.arange(values.size // 2 + 1)
    return np.fft.irfft((1j * wavenumbers) ** order * np.fft.rfft(values), n=values.size)


def test_differences_are_those_that_are_given() -> None:
    """u d2(u) + d1(u^2) + d3(u) for u = sin x: -sin^2 x + sin 2x - cos x; differences in differences too."""
    x = 2 * np.pi * np.arange(16) / 16
    program = tree("u*d2(u) + d1(u**2) + d3(u) + d1(u*d1(u))")
    found = program.evaluate(16, {"u": np.sin(x)}, spectral)[program.outputs[0]]
    assert found == pytest.approx(-(np.sin(x) ** 2) + np.sin(2 * x) - np.cos(x) + np.cos(2 * x), abs=1e-13)


@given(formulas, st.integers(0, 100))
def test_a_program_is_its_formula(text: str, seed: int) -> None:
    """Values and the points where there is none are those of numpy, for whole arrays at once."""
    program = Program((parse(text, "f", ("x", "y"), {"a": 0.75}),))
    x, y = random_state(seed, 2, 6)
    with np.errstate(all="ignore"):
        expected = eval(text, {}, {**NUMPY, "pi": np.pi, "e": np.e, "x": x, "y": y, "a": 0.75}) + np.zeros(6)
    if np.all(np.abs(expected) < 1e50):
        found = program.evaluate(6, {"x": x, "y": y})[program.outputs[0]]
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * (1 + np.abs(expected).max()))


def test_where_there_is_no_value_is_said_with_the_cure() -> None:
    program, u = tree("1/u + v"), np.array([1.0, 0.0, 2.0])
    values = program.evaluate(3, {"u": u, "v": u})
    with pytest.raises(InputError, match=r"flux: .*divides by 'u', which is 0 at place 1; add a small number to it"):
        program.refuse_singular(values, "flux", "at place {}".format)
    fine = program.evaluate(3, {"u": u + 1, "v": u})
    program.refuse_singular(fine, "flux", "at place {}".format)
    assert fine[program.outputs[0]] == pytest.approx(1 / (u + 1) + u)


STENCILS = {1: np.array([-0.5, 0.0, 0.5]), 2: np.array([1.0, -2.0, 1.0]), 3: np.array([-0.5, 1.0, 0.0, -1.0, 0.5])}


def difference(values: Array, order: int) -> Array:
    reach = STENCILS[order].size // 2
    return np.asarray(sum(c * np.roll(values, reach - k) for k, c in enumerate(STENCILS[order])))


@pytest.mark.parametrize(
    ("text", "reach"), [("u*v", 0), ("u*d1(u)", 1), ("d2(u**3) + v**2", 1), ("d1(u*d1(v))", 2), ("sin(u) + d3(v)*d1(u)", 2)]
)
def test_slopes_through_differences_are_those_of_the_values(text: str, reach: int) -> None:
    """A directional derivative of the whole, by a difference, against the cyclic diagonals of each name."""
    program, (u, v) = tree(text), random_state(3, 2, 9)
    table, direction, step = program.evaluate(9, {"u": u, "v": v}, difference), random_state(4, 2, 9), 1e-6

    def value(sign: float) -> Array:
        moved = {"u": u + sign * step * direction[0], "v": v + sign * step * direction[1]}
        return np.asarray(program.evaluate(9, moved, difference)[program.outputs[0]])

    diagonals = program.diagonals(table, STENCILS, NAMES)
    assert diagonals.shape == (2, 2 * reach + 1, 9)
    assert program.reach(STENCILS) == reach
    found = np.zeros(9)
    for field, along in enumerate(direction):
        for offset in range(-reach, reach + 1):
            found += diagonals[field, reach + offset] * np.roll(along, -offset)
    assert found == pytest.approx((value(1) - value(-1)) / (2 * step), rel=1e-6, abs=1e-7)
