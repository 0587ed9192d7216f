from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from mol_compactons.analysis.collisions import first_collision
from mol_compactons.analysis.flights import free_flights
from tests.analysis.relaxing import MOMENT, SPEEDS, SUPPORT, Relaxing, with_a_third

FAST, SLOW = 0, 1


def end(tracks: xr.Dataset, wave: int) -> float:
    return float(first_collision(tracks).flight_end[wave])


@pytest.mark.parametrize("length", [60.0, 80.0, 100.0])
def test_the_fast_wave_is_free_until_its_front_has_rounded_the_ring(length: float) -> None:
    """Its front, half a support ahead of it, then meets what lies from one support before the collision on."""
    tracks = Relaxing(shifts=(0.0, 0.0), length=length, t_end=length).tracks()
    expected = MOMENT + (length - 1.5 * SUPPORT) / SPEEDS[FAST]
    assert end(tracks, FAST) == pytest.approx(min(expected, length), abs=0.3)
    assert end(Relaxing(shifts=(0.0, 0.0), length=1000.0, t_end=length).tracks(), FAST) == length


def test_what_comes_after_that_changes_nothing() -> None:
    """All that the fast wave suffers from what was left behind."""
    tracks = Relaxing(length=60.0, t_end=80.0).tracks()
    before = first_collision(tracks)
    disturbed = tracks.copy(deep=True)
    late = tracks.t.values > end(tracks, FAST)
    assert late.any()
    disturbed["position"][late, FAST] += 3.0
    disturbed["height"][late, FAST] *= 2.0
    disturbed["mass_left"][late] += 5.0
    xr.testing.assert_identical(first_collision(disturbed), before)
    assert float(before.phase_shift[FAST]) == pytest.approx(1.5, abs=1e-9)


def test_the_next_meeting_on_the_ring_ends_the_flight_of_the_slow_wave() -> None:
    length = 60.0
    tracks = Relaxing(shifts=(0.0, 0.0), length=length, t_end=110.0).tracks()
    met_again = MOMENT + (length - 4.5) / (SPEEDS[FAST] - SPEEDS[SLOW])
    assert end(tracks, SLOW) == pytest.approx(met_again, abs=0.3)


def test_a_wave_that_took_no_part_runs_into_what_others_left_behind() -> None:
    """At the moment of the collision, at x = 24, it is 76 before it: 31 units of time until its front is one support away."""
    tracks = with_a_third(24 - 76 - 2 * MOMENT, Relaxing(t_end=80.0).tracks())
    assert end(tracks, 2) == pytest.approx(MOMENT + (76 - 1.5 * SUPPORT) / 2, abs=0.3)
    ahead = with_a_third(24 + 30 - 2 * MOMENT, Relaxing(t_end=80.0).tracks())
    assert end(ahead, 2) == 80.0


def mirrored(tracks: xr.Dataset) -> xr.Dataset:
    twin = tracks.copy(deep=True)
    twin["position"] = twin.position.copy(data=-tracks.position.values)
    return twin


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(50, 120), st.floats(40, 120))
@settings(max_examples=20, deadline=None)
def test_mirror_images_have_the_same_flights_and_opposite_shifts(
    first: float, second: float, length: float, t_end: float
) -> None:
    tracks = Relaxing(shifts=(first, second), length=length, t_end=t_end).tracks()
    one, other = first_collision(tracks), first_collision(mirrored(tracks))
    assert other.phase_shift.values == pytest.approx(-one.phase_shift.values, abs=1e-9)
    assert np.array_equal(one.flight_end, other.flight_end)
    assert np.isfinite(one.phase_shift).all()


@given(st.floats(-500, 500), st.integers(-3, 3))
@settings(max_examples=20, deadline=None)
def test_the_place_on_the_ring_does_not_matter(offset: float, turns: int) -> None:
    tracks = Relaxing(length=60.0, t_end=90.0).tracks()
    moved = tracks.copy(deep=True)
    moved["position"] += offset
    moved["position"][:, FAST] += 60.0 * turns
    one, other = first_collision(tracks), first_collision(moved)
    assert other.phase_shift.values == pytest.approx(one.phase_shift.values, abs=1e-9)
    assert np.abs(one.flight_end - other.flight_end).max() <= 0.25


def test_the_order_of_the_waves_does_not_matter() -> None:
    tracks = Relaxing(length=60.0, t_end=90.0).tracks()
    swapped = first_collision(tracks.isel(wave=[1, 0]))
    xr.testing.assert_allclose(swapped.isel(wave=[1, 0]), first_collision(tracks))


def test_a_wave_without_a_first_flight_has_no_path() -> None:
    tracks = Relaxing().tracks()
    tracks["isolated"][0] = False
    assert free_flights(tracks) == [None, None]


@given(st.integers(8, 24), st.integers(3, 20))
def test_waves_meet_in_the_middle_of_the_time_in_which_they_are_not_seen(last: int, hidden: int) -> None:
    """Two on a ring of 9.3 with the speeds 3 and 2 are at one place at t = 20 and every 9.3 before and after."""
    times, period = np.arange(60.0), 9.3
    tracks = Relaxing(t_end=15.0).tracks().isel(t=slice(0, 60)).assign_coords(t=times)
    tracks["position"] = (("t", "wave"), 40 + np.outer(times - 20, (3.0, 2.0)), {"period": period})
    tracks["width"] = tracks.width.copy(data=np.ones((60, 2)))
    tracks["isolated"] = tracks.isolated.copy(data=np.repeat((times <= last) | (times >= last + hidden), 2).reshape(60, 2))
    middle = last + hidden / 2
    nearest = 20 + period * round((middle - 20) / period)
    paths = free_flights(tracks)
    assert [path.moment for path in paths if path is not None] == pytest.approx([nearest] * 2)
