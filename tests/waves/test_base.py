from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    Compacton,
    Equation,
    Formula,
    GranularChain,
    GranularCompacton,
    Grid,
    Impact,
    InputError,
    Lattice,
    PeriodicWave,
    PowerContact,
    Ripple,
    Rosenbrock,
    Samples,
    Simulation,
    SolitaryWave,
    Uniform,
    Wave,
    run,
)
from mol_compactons.configuration import hints_of
from mol_compactons.errors import require
from mol_compactons.waves import LocalizedWave, superpose
from tests.systems import Array, one_compacton

GRID = Grid(length=60, size=240)


def test_a_sum_of_waves_is_their_sum() -> None:
    equation = GranularCompacton(3)
    waves = (Compacton(1, 5.5), Compacton(0.25, 15.5, sign=-1))
    assert np.array_equal(superpose(waves, equation, GRID), sum(wave.values(equation, GRID) for wave in waves))


def test_touching_supports_are_allowed_and_overlapping_ones_are_not() -> None:
    equation = GranularCompacton(3)
    width = 2 * np.pi
    superpose((Compacton(1, 10), Compacton(1, 10 + width)), equation, GRID)
    with pytest.raises(InputError, match=r"overlap: their centres are 5 apart; put them at least 6\.283 apart"):
        superpose((Compacton(1, 10), Compacton(1, 15)), equation, GRID)
    with pytest.raises(InputError, match="overlap"):
        superpose((Compacton(1, 1), Compacton(1, 59)), equation, GRID)


def test_a_wave_wider_than_the_box_is_refused() -> None:
    with pytest.raises(InputError, match="does not fit in the box of length 6"):
        superpose((Compacton(1, 1),), GranularCompacton(3), Grid(length=6, size=60))


def test_no_wave_is_refused() -> None:
    with pytest.raises(InputError, match="holds no wave"):
        superpose((), GranularCompacton(3), GRID)


def test_samples_are_taken_as_they_are() -> None:
    values = np.linspace(-1, 1, GRID.size)
    assert np.array_equal(superpose([Samples(tuple(values))], GranularCompacton(2), GRID)[0], values)


@pytest.mark.parametrize(("values", "words"), [((1.0, np.nan), "finite"), ((1.0, np.inf), "finite"), ((1.0, 2.0), "240")])
def test_bad_samples_are_refused(values: tuple[float, ...], words: str) -> None:
    with pytest.raises(InputError, match=words):
        superpose([Samples(values)], GranularCompacton(2), GRID)


@given(st.floats(0, 60), st.floats(0, 60))
def test_two_waves_overlap_exactly_where_their_centres_are_too_near_on_the_ring(one: float, other: float) -> None:
    """Supports of 2 pi each: the sum exists if the centres are 2 pi apart the shorter way round."""
    equation = GranularCompacton(3)
    apart = abs((one - other + 30) % 60 - 30)
    waves = (Compacton(1, one), Compacton(0.5, other, -1))
    if apart < 2 * np.pi - 1e-9:
        with pytest.raises(InputError, match="overlap"):
            superpose(waves, equation, GRID)
    elif apart > 2 * np.pi + 1e-9:
        bright, dark = (wave.values(equation, GRID)[0] for wave in waves)
        assert np.array_equal(superpose(waves, equation, GRID)[0], bright + dark)
        assert not (bright * dark).any()


def test_a_background_is_added_to_waves_and_does_not_overlap_them() -> None:
    equation = GranularCompacton(3)
    state = superpose([Uniform(0.5), Ripple(0.1, 3), Compacton(1, 20)], equation, GRID)[0]
    expected = 0.5 + 0.1 * np.cos(2 * np.pi * 3 * GRID.x / 60) + Compacton(1, 20).values(equation, GRID)[0]
    assert np.allclose(state, expected, atol=1e-14)


@dataclass(frozen=True)
class Positive(GranularCompacton):
    """An equation that has a meaning for positive states alone."""

    def check_state(self, state: Array) -> None:
        require(float(state[0].min()) >= 0, "The state is negative somewhere.")


def test_the_equation_may_refuse_the_sum() -> None:
    """A dark wave alone is refused, and on a background that keeps it positive it is not."""
    dark = Compacton(0.2, 30, -1)
    with pytest.raises(InputError, match="The state is negative somewhere"):
        superpose([dark], Positive(3), GRID)
    assert superpose([Uniform(5.0), dark], Positive(3), GRID)[0].min() == pytest.approx(5 - np.sqrt(0.4))


def test_the_equation_may_refuse_a_place() -> None:
    chain = GranularChain(PowerContact(3), ends="free")
    with pytest.raises(InputError, match="lies outside the chain"):
        superpose([Compacton(1, 70)], chain, Lattice(60))


def test_waves_with_a_place_are_told_from_those_without() -> None:
    assert issubclass(LocalizedWave, Wave)
    kinds = {kind.__name__: issubclass(kind, LocalizedWave) for kind in (Compacton, Uniform, Ripple, Samples)}
    assert kinds == {"Compacton": True, "Uniform": False, "Ripple": False, "Samples": False}


@dataclass(frozen=True)
class Answer(Wave):
    """Gives for its values what its field says."""

    what: str

    def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> Array:
        sound = np.ones((1, grid.size))
        answers = {
            "sound": sound,
            "nan": sound * np.nan,
            "short": sound[:, 1:],
            "complex": 1j * sound,
            "whole": sound.astype(int),
        }
        return answers[self.what]


@pytest.mark.parametrize(
    ("what", "words"),
    [
        ("nan", r"Answer\.values returned NaN or infinity; return finite numbers"),
        ("short", r"Answer\.values returned an array of shape \(1, 239\) .* of shape \(1, 240\)"),
        ("complex", r"returned an array of shape \(1, 240\) and type complex128; return real numbers"),
    ],
)
def test_what_a_wave_of_ones_own_returns_is_checked(what: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        superpose([Answer(what)], GranularCompacton(3), GRID)
    assert superpose([Answer("sound"), Answer("whole")], GranularCompacton(3), GRID).tolist() == [[2.0] * 240]


@pytest.mark.parametrize(
    "wave",
    [
        Compacton(1, 2),
        Uniform(1),
        Ripple(1, 2),
        Samples((1.0,)),
        Formula("x"),
        PeriodicWave(1, 1.2),
        SolitaryWave(1, 2),
        Impact(1),
    ],
)
def test_every_field_is_checked(wave: Wave) -> None:
    for name, hint in hints_of(type(wave)).items():
        wrong: object = 5.5 if hint is str else {"?": "?"}
        with pytest.raises(InputError, match=rf"{type(wave).__name__}\.{name}"):
            replace(wave, **{name: wrong})  # type: ignore[type-var]


@pytest.mark.parametrize(
    "simulation",
    [
        one_compacton(size=600, t_end=2, frames=2, viscosity=1e-5, integrator=Rosenbrock(rtol=1e-6)),
        replace(
            one_compacton(size=64, t_end=2, frames=2, integrator=Rosenbrock(rtol=1e-6)),
            grid=Grid(2 * np.pi, 64),
            initial=[PeriodicWave(1, 1.5**0.5)],
        ),
    ],
)
def test_what_a_wave_calls_a_solution_is_one(simulation: Simulation) -> None:
    """The run moves, and comes near to it."""
    dataset, exact = run(simulation), simulation.exact_state(simulation.t_end)
    assert exact is not None
    moved = np.linalg.norm(exact[0] - dataset.W.values[0]) / np.linalg.norm(exact)
    wrong = np.linalg.norm(exact[0] - dataset.W.values[-1]) / np.linalg.norm(exact)
    assert moved > 0.1
    assert wrong < 0.02 * moved


def test_no_solution_is_known_of_several_waves_or_of_those_of_another_equation() -> None:
    one = one_compacton(size=120, t_end=1, frames=2)
    assert replace(one, initial=[Compacton(1, 5), Compacton(0.5, 20)]).exact_state(1) is None
    assert replace(one, initial=[Formula("exp(-(x - 9)**2)")]).exact_state(1) is None
    chain = GranularChain(PowerContact(3), ends="periodic")
    assert not Compacton(1, 10).is_solution(chain)
    assert SolitaryWave(1, 10).is_solution(chain)
    assert not SolitaryWave(1, 10).is_solution(replace(chain, ends="held"))
