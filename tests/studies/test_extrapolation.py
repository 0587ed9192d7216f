import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons.studies.extrapolation import extrapolate


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
