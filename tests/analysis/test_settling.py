from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons.analysis.settling import (
    EARLIEST,
    ENDLESS,
    FEWEST_FRAMES,
    SAFETY,
    WIDE_SAFETY,
    WINDOWS,
    line_through,
    reading_noise,
    remaining,
    windows,
)


@given(st.floats(-5, 5), st.floats(-5, 5), st.integers(2, 30))
def test_a_line_is_found_to_round_off_and_has_no_noise(value: float, slope: float, size: int) -> None:
    times = 3 + 0.5 * np.arange(float(size))
    line = line_through(times, value + slope * (times - 7))
    assert line.at(7) == pytest.approx(value, abs=1e-11)
    assert line.slope == pytest.approx(slope, abs=1e-11)
    assert max(line.scatter, line.noise_at(100.0)) < 1e-10


def test_the_noise_of_a_line_is_the_spread_of_lines_through_noise() -> None:
    rng, times = np.random.default_rng(1), np.linspace(0, 10, 101)
    lines = [line_through(times, 2 + 3 * times + rng.normal(0, 0.1, times.size)) for _ in range(200)]
    for far in (5.0, 30.0):
        spread = np.std([line.at(far) for line in lines])
        assert spread < np.mean([line.noise_at(far) for line in lines]) < 2 * spread


def test_residuals_that_keep_their_sign_are_few() -> None:
    """The same residuals in another order, one sign after the other, make the line less certain."""
    times = np.arange(40.0)
    mixed = np.where(np.arange(40) % 2, 1.0, -1.0)
    swell = np.sign(np.sin(2 * np.pi * (times + 0.5) / 20))
    assert line_through(times, swell).value_noise > 2 * line_through(times, mixed).value_noise


def test_the_noise_of_one_reading_is_told_from_a_smooth_course() -> None:
    rng, times = np.random.default_rng(2), np.linspace(0, 10, 4001)
    course = 3 + 2 * times - 0.1 * times**2 + np.sin(0.3 * times)
    assert reading_noise(course) < 1e-9
    assert reading_noise(course + rng.normal(0, 0.01, times.size)) == pytest.approx(0.01, rel=0.1)


def test_three_readings_tell_no_noise() -> None:
    assert np.isnan(reading_noise(np.array([1.0, 2.0, 4.0])))
    assert np.isnan(reading_noise(np.array([1.0, 2.0, np.nan, 3.0, 4.0])))


def test_windows_follow_each_other_by_one_ratio() -> None:
    times = np.linspace(0, 100, 2001)
    parts = windows(times, np.flatnonzero(times >= 30), since=20.0)
    ends = [times[part[-1]] - 20 for part in parts]
    assert len(parts) == WINDOWS
    assert np.array_equal(np.concatenate(parts), np.flatnonzero(times >= 30))
    assert ends == pytest.approx([10 * 2, 10 * 4, 10 * 8], abs=0.1)


def test_windows_from_the_start_leave_out_the_first_part() -> None:
    times = np.linspace(0, 100, 2001)
    parts = windows(times, np.arange(times.size), since=0.0)
    assert times[parts[0][0]] == pytest.approx(100 * EARLIEST)
    assert [times[part[-1]] for part in parts] == pytest.approx([25, 50, 100], abs=0.1)


def test_too_few_frames_give_no_windows() -> None:
    times = np.arange(100.0)
    assert windows(times, np.arange(60, 60 + WINDOWS * FEWEST_FRAMES - 1), since=0.0) == []
    assert windows(times, np.arange(20, 40), since=50.0) == []


@given(
    st.floats(0.35, 4), st.floats(1e-6, 10), st.sampled_from([-1, 1]), st.floats(1.1, 3), st.floats(-3, 3), st.floats(1, 1000)
)
def test_what_remains_of_a_power_of_the_time_is_held(
    power: float, size: float, sign: int, ratio: float, limit: float, first: float
) -> None:
    times = first * ratio ** np.arange(3.0)
    values = limit + sign * size * (times / first) ** -power
    assert abs(values[-1] - limit) <= remaining(times, values, 0.0) * (1 + 1e-6) + 1e-12


@given(st.floats(0.1, 3), st.floats(-3, 3))
def test_what_remains_of_an_exponential_and_a_slow_tail_is_held(rate: float, tail: float) -> None:
    times = np.array([10.0, 20.0, 40.0])
    values = 3 * np.exp(-rate * (times - 10)) * np.sign(tail or 1) + tail / times
    assert abs(values[-1]) <= remaining(times, values, 0.0) + 1e-12


def test_noise_hides_no_more_than_it_can() -> None:
    times, still = np.array([10.0, 20.0, 40.0]), np.ones(3)
    assert remaining(times, still, 0.0) == 0
    assert remaining(times, still, 1e-3) == pytest.approx(SAFETY * 1e-3)
    assert remaining(np.array([100.0, 101.0, 102.0]), still, 1e-3) > 0.1


def test_what_swings_or_does_not_shrink_is_not_extrapolated() -> None:
    times = np.array([10.0, 20.0, 40.0])
    assert remaining(times, np.array([0.0, 1.0, 0.2]), 0.0) == pytest.approx(WIDE_SAFETY)
    assert remaining(times, np.array([0.0, 1.0, 2.0]), 0.0) == pytest.approx(ENDLESS)
    assert remaining(times, np.array([0.0, 1.0, 4.0]), 0.0) == pytest.approx(3 * ENDLESS)


def test_nothing_is_said_of_what_is_not_known() -> None:
    assert np.isnan(remaining(np.array([1.0, 2.0, 4.0]), np.array([1.0, np.nan, 1.0]), 0.0))


@given(st.floats(0.1, 100), st.floats(-2, 2))
def test_units_do_not_matter(unit: float, offset: float) -> None:
    times, values = np.array([10.0, 17.0, 40.0]), np.array([1.0, 0.3, 0.1])
    one = remaining(times, values, 1e-3)
    assert remaining(unit * times, unit * values + offset, 1e-3 * unit) == pytest.approx(unit * one)
    assert remaining(times, -values, 1e-3) == pytest.approx(one)
