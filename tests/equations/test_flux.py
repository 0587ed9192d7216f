import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons.equations import GranularCompacton
from mol_compactons.equations.flux import Flux, PowerLaw, whole_power

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
