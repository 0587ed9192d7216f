import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import InputError
from mol_compactons.equations import GranularCompacton
from mol_compactons.equations.flux import DERIVATIVE_FLOOR, Flux, PowerLaw, contact_flux, whole_power

exponents = st.sampled_from([0.0, 0.25, 0.5, 1.0, 1.25, 2.0, 2.75, 3.0, 5.0, 1 / 3, 2.345])
POINTS = np.array([-2.5, -1.0, -0.3, 0.4, 1.0, 3.7])


@given(exponents, st.floats(-3, 3), st.booleans())
def test_value_is_the_power(exponent: float, coefficient: float, odd: bool) -> None:
    expected = coefficient * np.abs(POINTS) ** exponent * (np.sign(POINTS) if odd else 1)
    assert np.allclose(PowerLaw(coefficient, exponent, odd)(POINTS), expected, rtol=1e-14, atol=1e-300)


@given(exponents, st.booleans())
def test_derivative_and_antiderivative_are_what_they_say(exponent: float, odd: bool) -> None:
    law, step = PowerLaw(1.5, exponent, odd), 1e-5
    assert np.allclose((law(POINTS + step) - law(POINTS - step)) / (2 * step), law.derivative()(POINTS), rtol=1e-7, atol=1e-8)
    assert np.allclose(law.antiderivative().derivative()(POINTS), law(POINTS), rtol=1e-13)


def test_a_negative_exponent_stays_finite_at_zero() -> None:
    assert np.isfinite(PowerLaw(1, -0.75)(np.zeros(2))).all()


def test_whole_power_has_the_parity_of_its_exponent() -> None:
    assert np.allclose(whole_power(2, 3)(POINTS), 2 * POINTS**3)
    assert np.allclose(whole_power(2, 2)(POINTS), 2 * POINTS**2)


@given(st.integers(1001, 7000))
def test_granular_flux_is_variational(thousandths: int) -> None:
    n = thousandths / 1000
    assert GranularCompacton(n).dispersive_flux.variational_constant == pytest.approx(2 / (n + 1), rel=1e-15)


def test_a_flux_without_that_relation_is_not_variational() -> None:
    assert Flux((PowerLaw(1, 2),), PowerLaw(1, 0), PowerLaw(1, 2)).variational_constant is None


def test_convective_part_is_the_sum_of_its_laws() -> None:
    flux = Flux((PowerLaw(2, 3, odd=True), PowerLaw(0.5, 1, odd=True)), PowerLaw(1, 1), PowerLaw(1, 2))
    out = np.empty_like(POINTS)
    flux.convective(POINTS, out)
    assert np.allclose(out, 2 * POINTS**3 + 0.5 * POINTS)
    flux.convective_derivative(POINTS, out)
    assert np.allclose(out, 6 * POINTS**2 + 0.5)


@given(exponents, st.booleans())
def test_a_law_is_added_to_what_is_there_or_takes_its_place(exponent: float, odd: bool) -> None:
    law = PowerLaw(1.7, exponent, odd)
    there = np.cos(POINTS)
    added, placed = there.copy(), there.copy()
    law.evaluate(POINTS, added, add=True)
    law.evaluate(POINTS, placed)
    assert placed == pytest.approx(law(POINTS), rel=1e-15)
    assert added == pytest.approx(there + law(POINTS), rel=1e-14)


@given(st.floats(-1.9, -0.1), st.booleans())
def test_a_negative_exponent_is_that_of_a_small_part_of_the_largest_at_zero(exponent: float, odd: bool) -> None:
    """An odd law is zero there, an even one as high as at DERIVATIVE_FLOOR times the largest value; others are exact."""
    u = np.array([0.0, 2.0, -0.5])
    values = PowerLaw(1.5, exponent, odd)(u)
    assert values[1:] == pytest.approx([1.5 * 2**exponent, (-1.5 if odd else 1.5) * 0.5**exponent], rel=1e-13)
    assert values[0] == pytest.approx(0 if odd else 1.5 * (2 * DERIVATIVE_FLOOR) ** exponent, rel=1e-12)


@pytest.mark.parametrize("n", [1.5, 2, 2.7, 3, 4])
def test_the_flux_of_a_contact_has_its_strength_and_its_dispersion(n: float) -> None:
    """a = C |u|^(n-1) u, b = C beta |u|^((n-1)/2), g = |u|^((n-1)/2) u; for n = 3 b and g may both change their sign."""
    b, g, a = np.empty((3, POINTS.size))
    contact_flux(n, 1.3, 0.2).evaluate(POINTS, b, g, a)
    size = np.abs(POINTS)
    assert a == pytest.approx(1.3 * size ** (n - 1) * POINTS, rel=1e-13)
    assert b * g == pytest.approx(1.3 * 0.2 * size ** (n - 1) * POINTS, rel=1e-13)
    assert np.abs(g) == pytest.approx(size ** ((n + 1) / 2), rel=1e-13)


def test_value_and_slopes_of_a_flux_of_several_terms() -> None:
    flux = Flux((PowerLaw(2, 3, odd=True), PowerLaw(0.5, 1, odd=True), PowerLaw(-1, 2)), PowerLaw(3, 1), PowerLaw(1, 2.5))
    b, g, a = np.empty((3, POINTS.size))
    flux.evaluate(POINTS, b, g, a)
    size = np.abs(POINTS)
    assert np.allclose([b, g, a], [3 * size, size**2.5, 2 * POINTS**3 + 0.5 * POINTS - POINTS**2], rtol=1e-13)
    flux.slopes(POINTS, b, g, a)
    sign = np.sign(POINTS)
    assert np.allclose([b, g, a], [3 * sign, 2.5 * sign * size**1.5, 6 * POINTS**2 + 0.5 - 2 * POINTS], rtol=1e-13)


def test_the_energy_has_a_potential_and_a_dispersive_part() -> None:
    """F = 2 u^3 + u / 2 + 3 u (u^2)_xx: A = u^4 / 2 + u^2 / 4 and kappa = 3/2."""
    flux = Flux((PowerLaw(2, 3, odd=True), PowerLaw(0.5, 1, odd=True)), PowerLaw(3, 1, odd=True), PowerLaw(1, 2))
    second = np.cos(POINTS)
    potential, dispersive = flux.energy_parts(POINTS, second)
    assert potential == pytest.approx(POINTS**4 / 2 + POINTS**2 / 4, rel=1e-13)
    assert dispersive == pytest.approx(0.75 * POINTS**2 * second, rel=1e-13)
    with pytest.raises(InputError, match="b must be a multiple of the derivative of g"):
        Flux((PowerLaw(1, 2),), PowerLaw(1, 0), PowerLaw(1, 2)).energy_parts(POINTS, second)
    with pytest.raises(InputError, match="must hold at least one power law"):
        Flux((), PowerLaw(1, 0), PowerLaw(1, 2))
