from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import GranularCompacton, Grid, InputError, Lattice, Nesterenko, Ripple, Uniform

GRID = Grid(length=6, size=24, left=-1)


@given(st.floats(-5, 5))
def test_a_background_is_the_same_everywhere_and_at_rest(value: float) -> None:
    assert np.array_equal(Uniform(value).values(GranularCompacton(3), GRID), np.full((1, 24), value))
    assert np.array_equal(Uniform(value).values(Nesterenko(3), GRID), [np.full(24, value), np.zeros(24)])


@given(st.floats(0.1, 3), st.integers(1, 12))
def test_a_ripple_is_one_wave_of_the_grid(amplitude: float, periods: int) -> None:
    """Its Fourier transform has one entry, amplitude N / 2, or amplitude N for the shortest wave."""
    spectrum = np.fft.rfft(Ripple(amplitude, periods).values(GranularCompacton(3), GRID)[0])
    assert spectrum[periods].real == pytest.approx(amplitude * (24 if periods == 12 else 12), rel=1e-12)
    spectrum[periods] = 0
    assert np.abs(spectrum).max() < 1e-12


def test_a_ripple_begins_with_its_crest_wherever_the_grid_begins() -> None:
    expected = 0.5 * np.cos(2 * np.pi * 2 * (GRID.x + 1) / 6)
    assert Ripple(0.5, 2).values(GranularCompacton(3), GRID)[0] == pytest.approx(expected, abs=1e-14)
    assert Ripple(0.5, 2).values(GranularCompacton(3), Lattice(8))[0] == pytest.approx([0.5, 0, -0.5, 0] * 2, abs=1e-14)


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match=r"Ripple\.periods = 0 must be at least 1"):
        Ripple(1, 0)
    with pytest.raises(InputError, match=r"Ripple\.periods = 13 needs at least 26 grid points; grid\.size = 24"):
        Ripple(1, 13).values(GranularCompacton(3), GRID)
