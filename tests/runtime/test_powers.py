"""Powers of any exponent, against numbers of many digits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import atanh, exp, log, mp, mpf, sqrt

from mol_compactons.runtime import powers
from mol_compactons.runtime.compiled import compiled
from tests.systems import Array


@compiled
def of_all(x: Array, p: float, out: Array) -> None:
    for k in range(x.size):
        out[k] = powers.size_power(x[k], p)


def power(x: Array, p: float) -> Array:
    out = np.empty_like(x)
    of_all(x, p, out)
    return out


def units_off(x: Array, p: float) -> float:
    """The largest error in units of the last place, where the power is a normal number."""
    with mp.workprec(200):
        exact = [mpf(float(value)) ** mpf(p) for value in x]
        found = power(x, p).tolist()
        normal = [(one, true) for one, true in zip(found, exact, strict=True) if mpf(2) ** -1022 < true < mpf(2) ** 1023]
        return max((float(abs(mpf(one) - true) / mpf(math.ulp(float(true)))) for one, true in normal), default=0.0)


@given(st.integers(0, 2**32 - 1), st.floats(-6, 12))
def test_powers_of_ordinary_size_are_right_to_two_units(seed: int, p: float) -> None:
    x = np.exp2(np.random.default_rng(seed).uniform(-30 / max(1, abs(p)), 30 / max(1, abs(p)), 50))
    assert units_off(x, p) < 2


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.1, 1 / 3, 0.7, 1.7, 2.7, -0.3, 5.3, 17.2, 200.1, 900.0, -900.0]))
def test_all_numbers_are_right_to_eight_units(seed: int, p: float) -> None:
    """Bases from the smallest subnormal number on, and near 1."""
    rng = np.random.default_rng(seed)
    assert units_off(np.exp2(rng.uniform(-1074, 1024, 30)), p) < 8
    assert units_off(1 + rng.uniform(-0.3, 0.4, 30), p) < 8


@pytest.mark.parametrize("p", [0.0, 1.0, 2.0, -1.0, 0.5, 1.7, -2.3])
def test_the_ends_of_the_numbers(p: float) -> None:
    zero, one, infinity, nothing = power(np.array([0.0, 1.0, np.inf, np.nan]), p)
    assert zero == (1 if p == 0 else 0)
    assert one == 1
    assert infinity == (1 if p == 0 else np.inf if p > 0 else 0)
    assert np.isnan(nothing)


def test_what_is_too_large_or_too_small_is_infinite_or_zero() -> None:
    assert power(np.array([1e300, 1e-300]), 3.3).tolist() == [np.inf, 0.0]
    assert power(np.array([1e300, 1e-300]), -3.3).tolist() == [0.0, np.inf]
    subnormal = power(np.array([1e-100]), 3.15)[0]
    assert subnormal == pytest.approx(1e-315, rel=1e-7)


def test_without_a_compiler_the_values_are_the_same() -> None:
    for x in (0.0, 1e-300, 0.3, 1.0, 7.7):
        for p in (0.0, 0.7, 2.3):
            assert powers._plain_power(x, p) == pytest.approx(float(power(np.array([x]), p)[0]), rel=1e-14)
    assert np.isnan(powers._plain_power(np.nan, 1.7))


def horner(coefficients: tuple[float, ...], x: mpf) -> mpf:
    value = mpf(0)
    for one in reversed(coefficients):
        value = value * x + mpf(one)
    return value


def test_the_polynomials_are_what_they_stand_for() -> None:
    """Within 2^-59 of the logarithm, and 2^-53 of the exponential, which have one unit each."""
    with mp.workprec(200):
        largest = ((sqrt(2) - 1) / (sqrt(2) + 1)) ** 2
        for z in (largest * k / 40 for k in range(1, 41)):
            assert abs(horner(powers.LOGARITHM, z) - (atanh(sqrt(z)) / sqrt(z) - 1) / z) * z < mpf(2) ** -59
        for g in (log(2) / 2 * k / 40 for k in range(-40, 41) if k):
            assert abs(horner(powers.EXPONENTIAL, g) - (exp(g) - 1 - g) / g**2) * g**2 < mpf(2) ** -54
        assert float(1 / log(2) - mpf(powers.LOG2E)) == powers.LOG2E_REST
