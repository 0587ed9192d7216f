from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import Grid, InputError, PowerLawEquation
from mol_compactons.configuration import Settings, hints_of
from mol_compactons.equations import (
    CosinePower,
    Derivative,
    Equation,
    Flux,
    GranularCompacton,
    Nesterenko,
    PowerLaw,
    RosenauHyman,
)
from mol_compactons.equations.base import check_terms, compacton_height
from tests.systems import Array

shapes = st.builds(
    CosinePower, amplitude=st.floats(-3, 3).filter(bool), wavenumber=st.floats(0.2, 3), exponent=st.floats(0.5, 6)
)


@given(shapes, st.floats(-20, 20))
def test_the_profile_is_a_power_of_a_cosine_on_its_support_and_zero_outside(shape: CosinePower, z: float) -> None:
    assert shape.width == pytest.approx(math.pi / shape.wavenumber)
    inside = abs(shape.wavenumber * z) < math.pi / 2
    expected = shape.amplitude * max(math.cos(shape.wavenumber * z), 0.0) ** shape.exponent if inside else 0.0
    assert float(shape(np.array(z))) == pytest.approx(expected, rel=1e-12, abs=1e-300)


@given(shapes)
def test_it_is_even_and_highest_in_the_middle(shape: CosinePower) -> None:
    z = np.linspace(0, 0.7 * shape.width, 50)
    values = shape(z)
    assert np.array_equal(values, shape(-z))
    assert values[0] == shape.amplitude
    assert (np.diff(np.abs(values)) <= 0).all()
    assert (values[z > 0.5 * shape.width] == 0).all()


@given(shapes, st.floats(-0.45, 0.45))
def test_the_slope_is_the_derivative(shape: CosinePower, place: float) -> None:
    z, step = np.array([place * shape.width]), 1e-5 * shape.width
    difference = (shape(z + step) - shape(z - step)) / (2 * step)
    assert shape.slope(z) == pytest.approx(difference, rel=1e-4, abs=1e-6 * abs(shape.amplitude * shape.wavenumber))
    outside = np.array([-0.6, 0.5001, 7.0]) * shape.width
    assert shape.slope(outside).tolist() == [0.0, 0.0, 0.0]


@given(st.floats(1.1, 6), st.floats(0.1, 10))
def test_the_height_is_the_root(n: float, power: float) -> None:
    assert compacton_height(power, n) ** (n - 1) == pytest.approx(power, rel=1e-9)


def test_a_height_beyond_the_numbers_is_refused() -> None:
    with pytest.raises(InputError, match=r"has the height exp\(460.* for an exponent 1\.01, out of the range of numbers"):
        compacton_height(100.0, 1.01)


@dataclass(frozen=True)
class Silent(Equation):
    """Names its variable, and has no flux."""

    variables = ("u",)


@dataclass(frozen=True)
class Dispersive(Equation):
    """F = 2 u^2 + 3 (u^2)_xx."""

    variables = ("u",)

    @property
    def dispersive_flux(self) -> Flux:
        return Flux((PowerLaw(2, 2),), PowerLaw(3, 0), PowerLaw(1, 2))


@dataclass(frozen=True)
class Local(Equation):
    """F = u_x, two-way."""

    variables = ("u", "v")
    two_way = True

    def local_flux(self, t: float, x: Array, state: Array, derivative: Derivative) -> Array:
        return derivative(state[0], 1)


GRID = Grid(length=2 * np.pi, size=32)


def exactly(values: Array, order: int) -> Array:
    """The derivative of what the grid resolves."""
    return np.fft.irfft((1j * GRID.wavenumbers) ** order * np.fft.rfft(values), n=GRID.size)


def test_a_flux_in_the_one_form_is_one_in_the_other() -> None:
    """u = cos x: u^2 = (1 + cos 2x) / 2, so that F = 1 + cos 2x - 6 cos 2x."""
    equation = Dispersive()
    flux = equation.local_flux(0.0, GRID.x, np.cos(GRID.x)[None], exactly)
    assert np.allclose(flux, 1 - 5 * np.cos(2 * GRID.x), atol=1e-12)
    assert equation.has_local_flux
    assert Local().has_local_flux
    assert Local().dispersive_flux is None


def test_an_equation_without_a_flux_says_how_to_give_one() -> None:
    assert not Silent().has_local_flux
    with pytest.raises(InputError, match="Silent has no flux; give it a method local_flux, or a property dispersive_flux"):
        Silent().local_flux(0.0, GRID.x, np.zeros((1, 32)), exactly)


def test_an_equation_without_compactons_says_what_to_do() -> None:
    with pytest.raises(InputError, match="Local has no compacton of closed form known to this program; give the initial data"):
        Local().compacton(1.0)
    assert Local().compacton_speed(1.0) is None


def test_by_default_what_every_conservation_law_conserves_is_counted() -> None:
    state = np.array([1 + np.cos(GRID.x), 0.25 + np.sin(GRID.x)])
    found = Local().invariants(state, GRID.spacing, lambda values: values)
    assert set(found) == {"mass", "momentum"}
    assert [found["mass"], found["momentum"]] == pytest.approx([2 * np.pi, np.pi / 2])
    assert set(Silent().invariants(state[:1], GRID.spacing, lambda values: values)) == {"mass"}
    assert Silent().diagnostics(state[:1], GRID.spacing) == {}
    assert Silent().local_source(0.0, GRID.x, state[:1], exactly) is None
    assert not Silent().has_source


def test_a_travelling_wave_of_a_two_way_equation_moves_at_its_speed() -> None:
    """u_t = -c u' = -v_x where v = c u."""
    shape, z = CosinePower(2, 0.5, 2), np.linspace(-3, 3, 13)
    one, two = Silent().travelling_state(shape, z, 1.5), Local().travelling_state(shape, z, 1.5)
    assert np.array_equal(one, shape(z)[None])
    assert np.array_equal(two, [shape(z), 1.5 * shape(z)])


@dataclass(frozen=True)
class Answering(Equation):
    """Gives for its flux and its source what its fields say."""

    flux: Literal["sound", "short", "complex", "list"] = "sound"
    source: Literal["none", "sound", "short"] = "none"

    variables = ("u",)

    def local_flux(self, t: float, x: Array, state: Array, derivative: Derivative) -> Array:
        answers: Any = {"sound": state[0], "short": state[0, 1:], "complex": 1j * state[0], "list": list(state[0])}
        return cast(Array, answers[self.flux])

    def local_source(self, t: float, x: Array, state: Array, derivative: Derivative) -> Array | None:
        answers: dict[str, Array | None] = {"none": None, "sound": -state[0], "short": state[0, :1]}
        return answers[self.source]


def test_what_a_flux_or_a_source_returns_is_checked() -> None:
    check_terms(Answering(), GRID)
    check_terms(Answering(source="sound"), GRID)
    for equation, words in (
        (Answering("short"), r"Answering\.local_flux returned ndarray of shape \(31,\); return .* of shape \(32,\)"),
        (Answering("complex"), r"Answering\.local_flux returned ndarray"),
        (Answering("list"), r"Answering\.local_flux returned list"),
        (Answering(source="short"), r"Answering\.local_source returned ndarray of shape \(1,\)"),
    ):
        with pytest.raises(InputError, match=words):
            check_terms(equation, GRID)


def test_by_default_nothing_moves_at_zero_and_nothing_depends_on_time() -> None:
    assert (Local().background, Local().depends_on_time, Silent().two_way) == (0.0, False, False)


def test_sizes_of_what_is_conserved_do_not_cancel() -> None:
    """u = cos x and v = 2 sin x: the integrals vanish, those of the sizes are 4 and 8."""
    fine = Grid(length=2 * np.pi, size=4000)
    state = np.array([np.cos(fine.x), 2 * np.sin(fine.x)])
    sums, sizes = (of(state, fine.spacing, lambda values: values) for of in (Local().invariants, Local().magnitudes))
    assert sums == pytest.approx({"mass": 0, "momentum": 0}, abs=1e-12)
    assert sizes == pytest.approx({"mass": 4, "momentum": 8}, rel=1e-5)


@dataclass(frozen=True)
class Driven(Local):
    """The same with a source."""

    def local_source(self, t: float, x: Array, state: Array, derivative: Derivative) -> Array | None:
        return np.asarray(-state[1])


def test_what_a_source_changes_is_a_diagnostic() -> None:
    state = np.array([1 + np.cos(GRID.x), 0.25 + np.sin(GRID.x)])
    assert Driven().invariants(state, GRID.spacing, lambda values: values) == pytest.approx({"mass": 2 * np.pi})
    assert Driven().diagnostics(state, GRID.spacing) == pytest.approx({"momentum": np.pi / 2})


@pytest.mark.parametrize(
    "equation",
    [
        GranularCompacton(2),
        Nesterenko(2),
        RosenauHyman(2, 2),
        PowerLaw(1, 2),
        PowerLawEquation(PowerLaw(1, 2), PowerLaw(1, 0), PowerLaw(1, 2)),
    ],
)
def test_every_field_is_checked(equation: Settings) -> None:
    for name in hints_of(type(equation)):
        with pytest.raises(InputError, match=rf"{type(equation).__name__}\.{name}"):
            replace(equation, **{name: "?"})  # type: ignore[type-var]


@given(st.floats(1.2, 5), st.floats(1e-6, 1e6), st.sampled_from([1, -1]))
def test_a_height_has_the_shape_and_the_speed_of_its_compacton(n: float, height: float, sign: int) -> None:
    for equation in (
        GranularCompacton(n),
        RosenauHyman(n, n, absolute=True),
        Nesterenko(n, strength=2.0),
        RosenauHyman(2, 2),
        RosenauHyman(3, 3),
    ):
        shape, speed = equation.solitary_shape(height, sign), equation.solitary_speed(height, sign)
        assert shape is not None
        assert speed is not None
        assert shape == equation.compacton(speed, sign)
        assert shape.amplitude == pytest.approx(sign * height, rel=1e-9)
        assert float(shape(np.array([shape.half_width / 2]))[0]) == pytest.approx(sign * height / 2, rel=1e-9)
    assert (RosenauHyman(2, 2).solitary_speed(height, -1) or 0) < 0 < (RosenauHyman(3, 3).solitary_speed(height, -1) or 0)


def test_sound_makes_waves_of_nesterenko_faster() -> None:
    equation = Nesterenko(3, prestress=0.5)
    speed = equation.solitary_speed(1.1)
    assert speed is not None
    assert speed**2 == pytest.approx(0.5 + 2 * 1.1**2 / 4)
    assert equation.compacton(-speed, -1).amplitude == pytest.approx(-1.1)


def test_an_equation_without_compactons_has_no_shape() -> None:
    assert RosenauHyman(3, 2).solitary_shape(1.0) is None
    assert RosenauHyman(3, 2).solitary_speed(1.0) is None


@dataclass(frozen=True)
class Contradiction(GranularCompacton):
    """Its speed does not belong to its height."""

    def compacton_speed(self, height: float) -> float:
        return 2 * super().compacton_speed(height)


def test_methods_that_contradict_each_other_are_refused() -> None:
    with pytest.raises(InputError, match=r"Contradiction.compacton_speed\(1\) is 1, but the compacton of this speed has"):
        Contradiction(3).solitary_shape(1.0)
    for height in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(InputError, match="The height of a solitary wave is positive"):
            GranularCompacton(3).solitary_speed(height)
