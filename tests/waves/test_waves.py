import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import Compacton, GranularCompacton, Grid, InputError, Samples
from mol_compactons.waves import superpose

GRID = Grid(length=60, size=240)


@given(
    st.sampled_from([1.5, 2, 3, 4]), st.floats(0.1, 3), st.floats(-100, 100), st.integers(-300, 300), st.sampled_from([1, -1])
)
def test_shift_sign_and_period(n: float, speed: float, center: float, steps: int, sign: int) -> None:
    equation = GranularCompacton(n)
    wave = Compacton(speed, center, sign).values(equation, GRID)
    assert np.array_equal(-wave, Compacton(speed, center, -sign).values(equation, GRID))
    shifted = Compacton(speed, center + steps * GRID.spacing, sign).values(equation, GRID)
    assert np.allclose(np.roll(wave, steps), shifted, atol=1e-6)
    assert np.allclose(wave, Compacton(speed, center + GRID.length, sign).values(equation, GRID), atol=1e-6)


@given(st.floats(0.1, 4), st.floats(0, 20))
def test_the_wave_moves_at_its_speed(speed: float, t: float) -> None:
    equation = GranularCompacton(3)
    moved = Compacton(speed, 7).values(equation, GRID, t)
    assert np.allclose(moved, Compacton(speed, 7 + speed * t).values(equation, GRID), atol=1e-9)


def test_it_vanishes_outside_its_support() -> None:
    equation = GranularCompacton(3)
    width = equation.compacton(1).width
    values = Compacton(speed=1, center=30).values(equation, GRID)[0]
    inside = np.abs(GRID.x - 30) < width / 2
    assert width == pytest.approx(2 * np.pi)
    assert (values[inside] > 0).all()
    assert (values[~inside] == 0).all()


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


def test_a_sign_other_than_plus_or_minus_one_is_refused() -> None:
    with pytest.raises(InputError, match="1 for a bright wave or -1"):
        Compacton(1, 1, sign=2)


def test_samples_are_taken_as_they_are() -> None:
    values = np.linspace(-1, 1, GRID.size)
    assert np.array_equal(superpose([Samples(tuple(values))], GranularCompacton(2), GRID)[0], values)


@pytest.mark.parametrize(("values", "words"), [((1.0, np.nan), "finite"), ((1.0, np.inf), "finite"), ((1.0, 2.0), "240")])
def test_bad_samples_are_refused(values: tuple[float, ...], words: str) -> None:
    with pytest.raises(InputError, match=words):
        superpose([Samples(values)], GranularCompacton(2), GRID)
