from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import Compacton, GranularCompacton
from mol_compactons.analysis.following import LONGEST_ABSENCE, PERSISTENCE, Followed, Followers, clear
from mol_compactons.analysis.sighting import Frames, Sighting, frames_of
from mol_compactons.results.reading import outlines_of
from tests.analysis.painted import GRID, painted

PEAK = Sighting(1, 0.0, 1.0, 2.0, 4.0, math.nan, None, math.nan)


@given(st.floats(-100, 100), st.floats(-3, 3), st.floats(-0.4, 0.4))
def test_a_place_goes_on_where_the_wave_comes_round_again(start: float, speed: float, ahead: float) -> None:
    """It is the one of its images on the ring that is nearest to what was foretold."""
    wave = Followed(1, start, speed, 1.0, 2.0)
    place = start + 5 * speed + ahead
    wave.take(7, 5.0, replace(PEAK, position=place % 10), 10.0)
    assert wave.seen[7].position == pytest.approx(place, abs=1e-9)
    assert wave.first == 7


def test_the_speed_of_free_flight_is_that_of_the_last_places_or_of_the_height() -> None:
    wave = Followed(1, 0.0, 0.0, 1.0, 2.0)
    for index in range(8):
        wave.take(index, 0.1 * index, replace(PEAK, position=0.25 * index + (index < 3)), 60.0)
        wave.remember(index, 0.1 * index)
    assert wave.speed == pytest.approx(2.5)
    assert wave.foretold(1.0) == pytest.approx(2.5)
    wave.take(8, 0.8, replace(PEAK, position=2.0, residual=0.01, family_speed=2.25), 60.0)
    wave.remember(8, 0.8)
    assert wave.speed == 2.25
    assert wave.width == PEAK.support


def test_of_a_flight_that_bends_the_last_five_places_give_the_speed() -> None:
    """Of k^2 at the times k, from 3 to 7, the line of least squares has the slope in their middle, 10."""
    wave = Followed(1, 0.0, 0.0, 1.0, 2.0)
    for index in range(8):
        wave.take(index, float(index), replace(PEAK, position=float(index**2)), 600.0)
        wave.remember(index, float(index))
    assert wave.speed == pytest.approx(10)


def test_a_gap_in_the_flight_ends_it() -> None:
    wave = Followed(1, 0.0, 1.0, 1.0, 2.0)
    for index in (0, 1, 2, 5):
        wave.take(index, float(index), replace(PEAK, position=float(index)), 60.0)
        wave.remember(index, float(index))
    assert [frame for frame, _, _ in wave.flight] == [5]


def frames(states: np.ndarray) -> Frames:
    """Frames of compactons of n = 2."""
    result = painted(2, [(Compacton(1, 10), 0, 0)])
    return replace(frames_of(result), states=states[:, None], times=np.arange(float(len(states))))


def test_waves_are_clear_of_others_but_not_of_much_lower_ones_born_later() -> None:
    """And of the points that are not known."""
    waves = [Followed(1, place, 0.0, height, 4.0) for place, height in ((10, 1.0), (13, 0.9), (20, 1.0), (22, 0.2))]
    places, heights = np.array([10.0, 13, 20, 22]), np.array([1.0, 0.9, 1.0, 0.2])
    here = frames(np.zeros((1, 600)))
    assert clear(waves, places, heights, here).tolist() == [False, False, True, False]
    assert clear([*waves[:3], replace(waves[3], from_start=True)], places, heights, here).tolist() == [False] * 4
    assert clear(waves, np.array([10.0, np.nan, 20, 22]), heights, here).tolist() == [True, True, True, False]
    part = replace(here, hidden=GRID.x > 21)
    assert clear(waves, places, heights, part).tolist() == [False, False, False, False]


def followers(result: xr.Dataset, newborn: bool = True) -> list[Followed]:
    return Followers(frames_of(result), outlines_of(result), None, newborn).run()


@pytest.mark.parametrize(("frames_seen", "waves"), [(PERSISTENCE - 1, 1), (PERSISTENCE, 2)])
def test_a_new_wave_has_to_last(frames_seen: int, waves: int) -> None:
    result, shape = painted(3, [(Compacton(1, 10), 0, 0)], t_end=20), GranularCompacton(3).compacton(0.32)
    for index in range(40, 40 + frames_seen):
        result.W[index] += shape(GRID.offset(40 + 0.32 * float(result.t[index])))
    found = followers(result)
    assert len(found) == waves
    assert [wave.first for wave in found] == [0, 40][:waves]
    assert len(followers(result, newborn=False)) == 1


@pytest.mark.parametrize(("absent", "waves"), [(LONGEST_ABSENCE, 2), (LONGEST_ABSENCE + 2, 1)])
def test_a_new_peak_may_be_away_for_some_frames(absent: int, waves: int) -> None:
    result, shape = painted(3, [(Compacton(1, 10), 0, 0)], t_end=20), GranularCompacton(3).compacton(0.32)
    for index in [*range(40, 43), *range(43 + absent, 46 + absent)]:
        result.W[index] += shape(GRID.offset(40 + 0.32 * float(result.t[index])))
    assert len(followers(result)) == waves


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_a_wave_that_wanes_is_known_by_the_height_that_it_had_last(size: float) -> None:
    """It falls to a tenth of its height, whatever that is, and slows down as it does."""
    result, equation, place = painted(2, [(Compacton(size, 10), 0, 0)], t_end=30 / size), GranularCompacton(2), 10.0
    speeds = size * np.geomspace(1, 0.1, 161)
    for index, speed in enumerate(speeds):
        result.W[index] = equation.compacton(speed)(GRID.offset(place))
        place += speed * float(result.t[1])
    (wave,) = followers(result)
    assert [wave.seen[index].height for index in range(161)] == pytest.approx(1.5 * speeds)


def test_waves_of_one_sign_are_named_by_their_heights_after_they_met() -> None:
    """The taller comes out ahead by less than it would have flown, and the lower one behind; neither was away in between."""
    fast, slow = Compacton(1, 8), Compacton(0.5, 18)
    result = painted(3, [(fast, 16, -2.5), (slow, 16, 2.5)], t_end=50)
    for wave, height in zip(followers(result), (2**0.5, 1), strict=True):
        assert wave.seen[160].height == pytest.approx(height)
        assert wave.seen[0].height == pytest.approx(height)
