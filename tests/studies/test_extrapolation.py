import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons.studies.extrapolation import extrapolate, rest_of_changes


@given(st.floats(0.5, 5.9), st.floats(-2, 2), st.floats(0.01, 1), st.sampled_from([1, -1]), st.floats(1.3, 3))
def test_extrapolation_finds_limit_and_rate(rate: float, limit: float, amount: float, sign: int, ratio: float) -> None:
    parameters = [1.0, 1 / ratio, 1 / ratio**2]
    found = extrapolate(parameters, [np.array(limit + sign * amount * h**rate) for h in parameters], 6, 2)
    assert found.rate == pytest.approx(rate, rel=1e-4)
    assert float(found.limit) == pytest.approx(limit, abs=1e-6)
    assert found.shrinking


def test_extrapolation_with_unequal_ratios() -> None:
    parameters = [0.5, 0.3, 0.1]
    found = extrapolate(parameters, [np.array([1.0, 2.0]) + np.array([3.0, -1.0]) * h**1.5 for h in parameters], 2, 2)
    assert found.rate == pytest.approx(1.5)
    assert found.limit == pytest.approx([1, 2])


def test_differences_that_do_not_shrink_are_not_extrapolated() -> None:
    values = [np.array(v) for v in (1.0, 1.1, 1.25)]
    found = extrapolate([4, 2, 1], values, 2, 2)
    assert not found.shrinking
    assert np.isnan(found.rate)
    assert found.error == pytest.approx(0.45)
    alternating = extrapolate([4, 2, 1], [np.array(v) for v in (1.0, 1.1, 1.06)], 2, 2)
    assert float(alternating.limit) == 1.06
    assert alternating.error == pytest.approx(0.3)
    below_the_noise = extrapolate([4, 2, 1], values, 2, 2, floor=0.2)
    assert below_the_noise.shrinking
    assert extrapolate([1.0], values[:1], 2, 2).error == np.inf


def test_a_rate_above_the_theory_is_taken_for_chance() -> None:
    values = [np.array(v) for v in (0.01213, 0.00970, 0.00938)]
    by_chance = extrapolate([8e-3, 4e-3, 2e-3], values, order=1, cautious_order=1)
    assert by_chance.error == pytest.approx(3 * 0.00243)
    assert float(by_chance.limit) == 0.00938
    cautious = extrapolate([4, 2, 1], [np.array(1 + h**4) for h in (4, 2, 1)], order=4, cautious_order=2)
    assert float(cautious.limit) == pytest.approx(1)
    assert cautious.error == pytest.approx(1.25 * 15 / 3)


@given(st.floats(0.4, 4), st.floats(1.005, 3), st.floats(-2, 2))
def test_what_is_no_smooth_function_is_held_whatever_the_parameters_are(rate: float, ratio: float, limit: float) -> None:
    parameters = [ratio**2, ratio, 1.0]
    values = [np.array(limit + h**rate) for h in parameters]
    assert abs(float(values[-1]) - limit) <= rest_of_changes(parameters, values) * (1 + 1e-6)


def test_the_rest_of_changes_counts_one_that_is_small_by_chance() -> None:
    values = [np.array(v) for v in (0.05, 0.02, 0.02)]
    assert rest_of_changes([4, 2, 1], values) >= 0.03
    assert rest_of_changes([4, 2, 0], values) == pytest.approx(3 * 0.015)
    assert rest_of_changes([1.0], values[:1]) == np.inf


@given(st.floats(1.005, 1.15), st.floats(0, 1), st.floats(0, 1))
def test_parameters_close_to_each_other_hide_an_error_in_the_noise(ratio: float, first: float, second: float) -> None:
    parameters, noise = [ratio**2, ratio, 1.0], 0.01
    error = noise / (ratio**2 - 1)
    values = [np.array(error * h**2) for h in (ratio, 1.0)]
    values = [values[0], *values]
    assert extrapolate(parameters, values, 2, 2, floor=1.001 * noise).error >= error
    far = extrapolate([4, 2, 1], [np.array(noise * v) for v in (first, second, 0.0)], 2, 2, floor=noise)
    assert far.error <= 1.25 * noise
