from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    Compacton,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    Lattice,
    Nesterenko,
    PowerContact,
    RosenauHyman,
)

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


def test_a_sign_other_than_plus_or_minus_one_is_refused() -> None:
    with pytest.raises(InputError, match="1 for a bright wave or -1"):
        Compacton(1, 1, sign=2)


@given(st.floats(0.1, 4), st.sampled_from([1, -1]))
def test_its_outline_is_that_of_the_equation(speed: float, sign: int) -> None:
    """n = 3: the height sqrt(2 c) and the width 2 pi."""
    height, width = Compacton(speed, 7, sign).outline(GranularCompacton(3))
    assert height == pytest.approx(sign * np.sqrt(2 * speed), rel=1e-12)
    assert width == pytest.approx(2 * np.pi, rel=1e-12)


def test_of_a_two_way_equation_the_velocity_is_the_speed_times_the_stress() -> None:
    stress, velocity = Compacton(-1.5, 30).values(Nesterenko(3), GRID)
    assert stress.max() > 1
    assert np.array_equal(velocity, -1.5 * stress)


def test_a_dark_wave_of_k_2_2_moves_left() -> None:
    equation = RosenauHyman(2, 2)
    wave = Compacton(-1, 30, -1)
    before, after = (wave.values(equation, GRID, t)[0] for t in (0.0, 2.0))
    assert GRID.x[before.argmin()] == pytest.approx(30)
    assert GRID.x[after.argmin()] == pytest.approx(28)
    with pytest.raises(InputError, match="wrong sign for a dark wave"):
        Compacton(1, 30, -1).values(equation, GRID)


def test_on_a_chain_it_is_the_compacton_of_the_continuum() -> None:
    """Its rates add up to zero on the ring, though the wave is no exact one there."""
    chain, lattice = GranularChain(PowerContact(3)), Lattice(60)
    stress, rate = Compacton(1, 20.3).values(chain, lattice)
    assert stress == pytest.approx(Nesterenko(3).compacton(1)(lattice.offset(20.3)))
    assert np.abs(rate).max() > 0.1
    assert abs(rate.sum()) < 1e-14
