from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    CVODE,
    Compacton,
    ConservativeScheme,
    GranularCompacton,
    Grid,
    InputError,
    RosenauHyman,
    Simulation,
    run,
)
from mol_compactons.analysis.drift import drift
from mol_compactons.schemes.rosenau_hyman import RosenauHymanKernel, is_conservative
from mol_compactons.schemes.viscosity import Damping
from tests.systems import analytic_jacobian, difference_jacobian, fitted_order, random_state, relative_error, right_hand_side

Order = Literal[2, 4, 6]
orders = st.sampled_from([2, 4, 6])
seeds = st.integers(0, 10**6)
powers = st.sampled_from(
    [
        RosenauHyman(2, 2),
        RosenauHyman(3, 3),
        RosenauHyman(3, 1),
        RosenauHyman(1.5, 2.5, absolute=True),
        RosenauHyman(4, 2, absolute=True),
    ]
)


@given(powers, orders, seeds)
def test_k_m_n_keeps_mass_and_energy_to_round_off(equation: RosenauHyman, order: Order, seed: int) -> None:
    system = ConservativeScheme(order).discretize(equation, Grid(length=10, size=24))
    state = random_state(seed, 1, 24)
    state[0, ::7] = 0
    state[0, 1::7] = state[0, 2::7][:4] * (1 + 1e-5)
    rate, slope = right_hand_side(system, state), equation.dispersive_flux.g(state)
    assert abs(float(rate.sum())) <= 1e-14 * float(np.abs(rate).sum())
    assert abs(float((slope * rate).sum())) <= 1e-13 * float(np.abs(slope * rate).sum())


@given(powers, orders, seeds)
def test_the_jacobian_of_k_m_n_is_the_derivative(equation: RosenauHyman, order: Order, seed: int) -> None:
    system = ConservativeScheme(order, viscosity=1e-3).discretize(equation, Grid(length=10, size=17))
    state = random_state(seed, 1, 17)
    state += 0.2 * np.sign(state)
    matrix = analytic_jacobian(system, state)
    assert np.allclose(matrix, difference_jacobian(system, state), atol=1e-6 * np.abs(matrix).max())


@pytest.mark.parametrize("order", [2, 4, 6])
@pytest.mark.parametrize("equation", [RosenauHyman(2, 2), RosenauHyman(3, 1), RosenauHyman(1.5, 2.5, absolute=True)])
def test_the_order_for_k_m_n_on_smooth_states(order: Order, equation: RosenauHyman) -> None:
    def exact(x: np.ndarray) -> np.ndarray:
        k = np.fft.rfftfreq(512, 1 / 512)
        fine = 2 + 0.25 * np.cos(2 * np.pi * np.arange(512) / 512)
        total = 1j * k * np.fft.rfft(fine**equation.m) + (1j * k) ** 3 * np.fft.rfft(fine**equation.n)
        return -np.fft.irfft(total, n=512)[:: 512 // x.size]

    sizes, errors = [32, 64], []
    for size in sizes:
        grid = Grid(length=2 * np.pi, size=size)
        rate = right_hand_side(ConservativeScheme(order).discretize(equation, grid), (2 + 0.25 * np.cos(grid.x))[None])
        errors.append(float(np.abs(rate[0] - exact(grid.x)).max()))
    assert fitted_order(sizes, errors) == pytest.approx(order, abs=0.2)


def test_a_compacton_of_k_2_2_needs_no_mass_matrix_and_no_viscosity() -> None:
    simulation = Simulation(
        equation=RosenauHyman(2, 2),
        grid=Grid(length=40, size=400),
        scheme=ConservativeScheme(order=4),
        initial=[Compacton(speed=1, center=12)],
        t_end=5,
        frames=6,
        integrator=CVODE(rtol=1e-5, linear_solver="sparse"),
    )
    dataset = run(simulation)
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, 5)[0]
    assert relative_error(dataset.u.values[-1], exact) < 2e-3
    assert float(abs(drift(dataset).mass).max()) < 1e-12
    assert float(abs(drift(dataset).energy).max()) < 1e-5


@given(powers, seeds, st.integers(0, 23))
def test_symmetries(equation: RosenauHyman, seed: int, shift: int) -> None:
    """A shift along the ring; the mirror image -u where the powers are odd; and s u, s^m t where m = n."""
    system = ConservativeScheme(4).discretize(equation, Grid(length=10, size=24))
    state = random_state(seed, 1, 24)
    rate = right_hand_side(system, state)
    scale = np.abs(rate).max()
    assert np.allclose(right_hand_side(system, np.roll(state, shift)), np.roll(rate, shift), atol=1e-12 * scale)
    if equation.is_odd:
        assert np.allclose(right_hand_side(system, -state), -rate, atol=1e-12 * scale)
    if equation.m == equation.n:
        stretched = 2**equation.m
        assert np.allclose(right_hand_side(system, 2 * state), stretched * rate, atol=1e-11 * stretched * scale)


def test_a_uniform_state_stays() -> None:
    system = ConservativeScheme(6).discretize(RosenauHyman(3, 3), Grid(length=10, size=24))
    assert np.abs(right_hand_side(system, np.full((1, 24), 1.7))).max() < 1e-12
    assert np.abs(right_hand_side(system, 1.7 + random_state(1, 1, 24))).max() > 1


@pytest.mark.parametrize(
    ("equation", "conservative"),
    [
        (RosenauHyman(2, 2), True),
        (RosenauHyman(3, 1), True),
        (RosenauHyman(3, 2), False),
        (RosenauHyman(2, 1), False),
        (RosenauHyman(3, 2, absolute=True), True),
        (GranularCompacton(2), False),
    ],
)
def test_which_equations_it_keeps_the_energy_of(equation: RosenauHyman | GranularCompacton, conservative: bool) -> None:
    assert is_conservative(equation) == conservative


def test_where_the_flux_is_no_function_of_the_power_the_kernel_is_refused() -> None:
    with pytest.raises(InputError, match=r"not K\(2, 1\) in the classical form; choose"):
        RosenauHymanKernel(RosenauHyman(2, 1), 24, 0.5, (1.0,), Damping(ConservativeScheme(2), 0.5))
