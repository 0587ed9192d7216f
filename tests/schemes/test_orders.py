"""Observed orders: on the exact smooth wave, on a manufactured one, and on compactons with their edges."""

import numpy as np
import pytest

from benchmarks.orders import (
    FORMAL_ORDERS,
    AnyScheme,
    compacton_error,
    fitted_rate,
    manufactured_error,
    periodic_wave_error,
    short,
)
from mol_compactons import (
    CentralScheme,
    CompactScheme,
    ConservativeScheme,
    FourierScheme,
    GranularCompacton,
    Grid,
    Nesterenko,
    Scheme,
)

FINITE = [scheme for scheme, order in FORMAL_ORDERS.items() if np.isfinite(order)]
EXPONENTS = (1.5, 2.0, 3.0, 4.2)


@pytest.mark.parametrize("scheme", FINITE, ids=short)
def test_on_the_exact_periodic_wave(scheme: AnyScheme) -> None:
    sizes = (48, 96) if FORMAL_ORDERS[scheme] > 2 else (24, 48)
    rate = fitted_rate(sizes, [periodic_wave_error(scheme, size, t_end=0.1) for size in sizes])
    print(f"{short(scheme)}: rate {rate:.2f}")
    assert rate == pytest.approx(FORMAL_ORDERS[scheme], abs=0.2)


@pytest.mark.parametrize("scheme", FINITE, ids=short)
@pytest.mark.parametrize("n", EXPONENTS)
def test_on_a_manufactured_wave(scheme: AnyScheme, n: float) -> None:
    sizes = (32, 64)
    rate = fitted_rate(sizes, [manufactured_error(scheme, n, size, t_end=0.1) for size in sizes])
    print(f"{short(scheme)}, n = {n:g}: rate {rate:.2f}")
    assert rate == pytest.approx(FORMAL_ORDERS[scheme], abs=0.2)


def test_the_order_that_a_scheme_states_is_the_one_that_it_has() -> None:
    assert [scheme.formal_order for scheme in FINITE] == [FORMAL_ORDERS[scheme] for scheme in FINITE]
    assert [CentralScheme(order).formal_order for order in (2, 4, 6)] == [2, 4, 6]


def test_the_fourier_error_falls_exponentially() -> None:
    """Doubling N divides the error by 200 or more, where the sixth order divides it by 64, down to the error of time."""
    errors = [periodic_wave_error(FourierScheme(), size, t_end=0.05) for size in (16, 32, 64)]
    assert errors[0] > 200 * errors[1] > 200**2 * errors[2]
    assert max(manufactured_error(FourierScheme(), n, 32, t_end=0.05) for n in EXPONENTS) < 1e-9


@pytest.mark.parametrize(("n", "least"), [(1.5, 3.5), (2, 2.2), (3, 1.2)])
def test_the_edge_of_a_compacton_limits_the_order(n: float, least: float) -> None:
    """Order 4 falls at the rate that the smoothness of the edge allows, less than 4 for n = 2 and 3."""
    sizes = (75, 150, 300)
    rate = fitted_rate(sizes, [compacton_error(ConservativeScheme(order=4), n, size, t_end=1) for size in sizes])
    print(f"n = {n:g}: rate {rate:.2f}")
    assert least < rate < (4.5 if n < 2 else 3.5)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", FINITE, ids=short)
@pytest.mark.parametrize("n", EXPONENTS)
def test_on_a_manufactured_wave_for_longer_and_finer(scheme: AnyScheme, n: float) -> None:
    sizes = (32, 64, 128)
    rate = fitted_rate(sizes, [manufactured_error(scheme, n, size) for size in sizes])
    assert rate == pytest.approx(FORMAL_ORDERS[scheme], abs=0.2)


@pytest.mark.slow
def test_the_wide_difference_on_a_compacton() -> None:
    sizes = (150, 300, 600)
    scheme = CompactScheme("wide", viscosity=0)
    rate = fitted_rate(sizes, [compacton_error(scheme, 3, size) for size in sizes])
    assert 1 < rate < 2.2


ENERGY_ORDERS: dict[Scheme, int] = {
    ConservativeScheme(order=2): 2,
    ConservativeScheme(order=4): 4,
    ConservativeScheme(order=6): 4,
    CompactScheme("wide"): 2,
    CompactScheme("nearest"): 2,
    CompactScheme("five_point"): 4,
    CentralScheme(order=2): 2,
    CentralScheme(order=4): 4,
    CentralScheme(order=6): 6,
}
"""Of the second difference that the energy of each scheme is taken with."""


WITH_ENERGY = GranularCompacton(2.5), Nesterenko(2.5, strength=1.3, grain_distance=0.8)


@pytest.mark.parametrize(
    ("scheme", "equation"),
    [(scheme, equation) for scheme in ENERGY_ORDERS for equation in WITH_ENERGY if scheme.suits(equation)],
)
def test_the_energy_is_that_of_the_wave(scheme: Scheme, equation: GranularCompacton | Nesterenko) -> None:
    """Int C (beta phi_x^2 - phi^2) / (n+1), phi = W^((n+1)/2); of the two-way equation minus this and Int v^2 / 2."""
    fine = Grid(2 * np.pi, 256)
    phi = (2 + 0.5 * np.cos(fine.x)) ** ((equation.n + 1) / 2)
    slope = np.fft.irfft(1j * fine.wavenumbers * np.fft.rfft(phi))
    if isinstance(equation, Nesterenko):
        bend, stiffness, moving = equation.dispersion, -equation.stiffness, 0.5 * np.pi
    else:
        bend, stiffness, moving = 1.0, 1.0, 0.0
    exact = moving + stiffness * fine.spacing * float((bend * slope**2 - phi**2).sum()) / (equation.n + 1)
    sizes, errors = (16, 32), []
    for size in sizes:
        grid = Grid(2 * np.pi, size)
        state = np.array([2 + 0.5 * np.cos(grid.x), np.sin(grid.x)])[: len(equation.variables)]
        errors.append(abs(scheme.discretize(equation, grid).invariants(state)["energy"] / exact - 1))
    assert errors[0] < 1e-2
    assert fitted_rate(sizes, errors) == pytest.approx(ENERGY_ORDERS[scheme], abs=0.1)
