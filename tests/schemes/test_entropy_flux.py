from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from mol_compactons.schemes.entropy_flux import VACUUM, two_point_fluxes, two_point_slopes
from tests.systems import Array

EXPONENTS = [1.0, 1.1, 1.5, 2.0, 2.5, 3.0, 4.2]

numbers = st.floats(-3, 3).map(lambda u: 0.0 if abs(u) < 1e-12 else u)
distances = st.one_of(st.floats(-1, 1), st.floats(-12, -1).map(lambda power: 10**power))


def fluxes(u: Array, v: Array, n: float) -> Array:
    """The flux of each pair."""
    out = np.empty(u.size)
    two_point_fluxes(u, v, np.abs(u) ** n, np.abs(v) ** n, n, out)
    return out


def slopes(u: Array, v: Array, n: float) -> tuple[Array, Array]:
    """The derivatives of the flux of each pair."""
    by_u, by_v = np.empty((2, u.size))
    two_point_slopes(u, v, np.abs(u) ** n, np.abs(v) ** n, n, by_u, by_v)
    return by_u, by_v


def two_point_flux(u: float, v: float, n: float) -> float:
    """The flux of one pair."""
    return float(fluxes(np.array([u]), np.array([v]), n)[0])


def exact_flux(u: float, v: float, n: float) -> float:
    """The quotient in 60 digits; u and v must differ."""
    with localcontext() as context:
        context.prec = 60
        exponent = Decimal(n) + 1
        powers = [abs(Decimal(value)) ** exponent if value else Decimal(0) for value in (u, v)]
        return float((powers[1] - powers[0]) / (exponent * (Decimal(v) - Decimal(u))))


@pytest.mark.parametrize("n", EXPONENTS)
@given(u=numbers, distance=distances)
@example(u=0.0, distance=1e-9)
@example(u=-1e-9, distance=2e-9)
def test_the_flux_has_no_cancellation(n: float, u: float, distance: float) -> None:
    v = u + distance * max(abs(u), 1e-9)
    if v == u:
        return
    size = max(abs(u), abs(v)) ** n
    assert two_point_flux(u, v, n) == pytest.approx(exact_flux(u, v, n), rel=0, abs=2e-13 * size + VACUUM)


@pytest.mark.parametrize("n", EXPONENTS)
@given(u=numbers, v=numbers)
def test_arrays_have_the_values_of_their_pairs_and_are_odd_and_symmetric(n: float, u: float, v: float) -> None:
    out = fluxes(np.array([u, v, -u, u, 0.0]), np.array([v, u, -v, u, 0.0]), n)
    size = max(abs(u), abs(v)) ** n
    one = two_point_flux(u, v, n)
    assert np.allclose(out, [one, one, -one, np.sign(u) * abs(u) ** n, 0.0], rtol=0, atol=1e-14 * size)


@pytest.mark.parametrize("n", EXPONENTS)
@given(u=numbers, v=numbers)
def test_the_slopes_are_those_of_the_flux(n: float, u: float, v: float) -> None:
    """By central differences, well away from u = 0, where the flux is not smooth, and from u = v for the general n."""
    size = max(abs(u), abs(v))
    step = 1e-5 * size
    if min(abs(u), abs(v)) < 0.05 * size or 0 < abs(u - v) < 0.05 * size or size == 0:
        return
    by_u, by_v = slopes(np.array([u]), np.array([v]), n)
    differences = [
        (two_point_flux(u + step, v, n) - two_point_flux(u - step, v, n)) / (2 * step),
        (two_point_flux(u, v + step, n) - two_point_flux(u, v - step, n)) / (2 * step),
    ]
    assert np.allclose([by_u[0], by_v[0]], differences, rtol=0, atol=1e-6 * size ** (n - 1))


@pytest.mark.parametrize("n", EXPONENTS)
@pytest.mark.parametrize("apart", [0.0, 1e-9, 1e-7, 1e-5, 1e-3, 1e-2])
def test_the_slopes_of_near_neighbours(n: float, apart: float) -> None:
    """The slope of the mean over [u, v] by u is the mean of (1 - s) n w^(n-1) at w = u + s (v - u)."""
    u, v = 0.7, 0.7 * (1 + apart)
    places, weights = np.polynomial.legendre.leggauss(20)
    s = (1 + places) / 2
    exact = 0.5 * np.sum(weights * (1 - s) * n * (u + s * (v - u)) ** (n - 1))
    by_u, _ = slopes(np.array([u]), np.array([v]), n)
    assert by_u[0] == pytest.approx(exact, rel=1e-7)


@pytest.mark.parametrize("n", EXPONENTS)
def test_nothing_of_nothing(n: float) -> None:
    zeros = np.zeros(3)
    assert np.array_equal(fluxes(zeros, zeros, n), zeros)
    by_u, by_v = slopes(zeros, zeros, n)
    expected = 0.5 if n == 1 else 0.0
    assert np.allclose(by_u, expected)
    assert np.allclose(by_v, expected)
