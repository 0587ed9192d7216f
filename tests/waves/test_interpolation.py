from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import Grid, InputError
from mol_compactons.waves.interpolation import periodic
from tests.systems import Array

LENGTH = 7.0


def wave(x: Array, seed: int) -> Array:
    """A sum of the first five waves of the period, shape (2, N)."""
    random = np.random.default_rng(seed)
    waves = [np.cos(2 * np.pi * k * x / LENGTH + random.uniform(0, 6, (2, 1))) * random.normal(size=(2, 1)) for k in range(5)]
    return np.asarray(sum(waves))


@given(st.integers(16, 60), st.integers(5, 80), st.floats(-10, 10), st.floats(-10, 10), st.integers(0, 100))
def test_smooth_data_are_those_of_their_series(points: int, size: int, first: float, left: float, seed: int) -> None:
    """From any even grid to any other, wherever both begin, finer or coarser."""
    places, grid = np.linspace(first, first + LENGTH, points, endpoint=False), Grid(LENGTH, size, left)
    found = periodic(places, wave(places, seed), grid)
    assert np.abs(found - wave(grid.x, seed)).max() < 1e-10


@given(st.integers(5, 40), st.integers(-30, 30), st.integers(0, 100))
def test_on_the_same_points_nothing_is_interpolated(size: int, steps: int, seed: int) -> None:
    """Not even where the data begin at another of these points: they come back bit for bit."""
    grid, rows = Grid(LENGTH, size), np.random.default_rng(seed).normal(size=(1, size))
    places = grid.x + steps * grid.spacing
    assert np.array_equal(periodic(places, rows, grid), np.roll(rows, steps, axis=1))


@given(st.integers(5, 40), st.integers(5, 90), st.integers(0, 100))
def test_rough_data_stay_between_their_neighbours(points: int, size: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    places = np.sort(random.uniform(0, LENGTH, points))
    values, grid = random.normal(size=points), Grid(LENGTH, size)
    found = periodic(places, values[None], grid)[0]
    around_places = np.concatenate([places - LENGTH, places, places + LENGTH])
    right = np.searchsorted(around_places, grid.x, side="right")
    ends = np.tile(values, 3)
    low, high = np.minimum(ends[right - 1], ends[right]), np.maximum(ends[right - 1], ends[right])
    assert (found >= low - 1e-9).all()
    assert (found <= high + 1e-9).all()


def test_more_than_a_period_is_refused() -> None:
    with pytest.raises(
        InputError, match="The places of the samples reach over 8, from 0 to 8, but the period of the grid is 7"
    ):
        periodic(np.linspace(0, 8, 9), np.ones((1, 9)), Grid(LENGTH, 20))


@pytest.mark.parametrize("length", [1e-4, 7.0, 1e4])
def test_what_counts_as_even_is_relative_to_the_period(length: float) -> None:
    """Places that are a ten-thousand-millionth of the period off are taken as the points; a millionth off they are not."""
    grid, rows = Grid(length, 24), np.random.default_rng(1).normal(size=(2, 24))
    off = np.where(np.arange(24) == 7, 1.0, 0.0) * length
    assert np.array_equal(periodic(grid.x + 1e-10 * off, rows, grid), rows)
    assert not np.array_equal(periodic(grid.x + 1e-6 * off, rows, grid), rows)


@given(st.integers(3, 40).map(lambda half: 2 * half), st.integers(2, 5), st.integers(0, 100))
def test_the_shortest_wave_goes_through_the_data_too(points: int, finer: int, seed: int) -> None:
    """A little of it, as smooth data have, on a grid that holds the places: the data come back, to round-off."""
    places = np.linspace(0, LENGTH, points, endpoint=False)
    rows = np.random.default_rng(seed).normal(size=(2, 1)) + 3 + 5e-7 * (-1.0) ** np.arange(points)
    found = periodic(places, rows, Grid(LENGTH, finer * points))
    assert found[:, ::finer] == pytest.approx(rows, abs=1e-13)
    assert np.ptp(found, axis=1) == pytest.approx([1e-6, 1e-6], rel=1e-6)


def test_each_row_is_interpolated_as_suits_it_only_where_all_are_smooth() -> None:
    """A step beside a cosine: none of both swings over, as the series of a step does."""
    places = np.linspace(0, LENGTH, 30, endpoint=False)
    rows = np.array([np.cos(2 * np.pi * places / LENGTH), np.sign(places - 3)])
    for given_rows in (rows, rows[::-1]):
        assert np.abs(periodic(places, given_rows, Grid(LENGTH, 90))).max() <= 1 + 1e-12


def test_data_are_smooth_where_the_last_third_of_their_spectrum_is_gone() -> None:
    """Of 30 points waves up to the 10th may be strong: they come back on a finer grid as cosines; the 11th is rough."""
    places, grid = np.linspace(0, LENGTH, 30, endpoint=False), Grid(LENGTH, 90)
    for periods, smooth in ((10, True), (11, False)):
        found = periodic(places, np.cos(2 * np.pi * periods * places / LENGTH)[None], grid)[0]
        exact = np.cos(2 * np.pi * periods * grid.x / LENGTH)
        assert (np.abs(found - exact).max() < 1e-12) == smooth
