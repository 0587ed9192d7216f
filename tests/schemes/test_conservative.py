from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

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
    Midpoint,
    Nesterenko,
    RosenauHyman,
    Simulation,
    run,
)
from mol_compactons.analysis.drift import drift
from tests.systems import (
    analytic_jacobian,
    difference_jacobian,
    fitted_order,
    random_state,
    relative_error,
    right_hand_side,
)

SLOW = pytest.mark.slow

Order = Literal[2, 4, 6]
orders = st.sampled_from([2, 4, 6])
exponents = st.sampled_from([1.5, 2.0, 3.0]) | st.floats(1.1, 7)
seeds = st.integers(0, 10**6)


@given(exponents, orders, seeds, st.sampled_from([1e-6, 1e-2, 1.0, 30.0]))
def test_mass_and_momentum_are_conserved_to_round_off(n: float, order: Order, seed: int, scale: float) -> None:
    system = ConservativeScheme(order).discretize(GranularCompacton(n), Grid(length=10, size=24))
    state = scale * random_state(seed, 1, 24)
    state[0, ::7] = 0
    state[0, 1::7] = state[0, 2::7][:4] * (1 + 1e-5)
    rate = right_hand_side(system, state)
    assert abs(float((state * rate).sum())) <= 1e-14 * float(np.abs(state * rate).sum())
    assert abs(float(rate.sum())) <= 1e-14 * float(np.abs(rate).sum())


@given(exponents, orders, seeds, st.sampled_from([4, 6]))
def test_jacobian_is_the_derivative(n: float, order: Order, seed: int, power: Literal[4, 6]) -> None:
    scheme = ConservativeScheme(order, viscosity=1e-3, viscosity_order=power)
    system = scheme.discretize(GranularCompacton(n), Grid(length=10, size=17))
    state = random_state(seed, 1, 17)
    state += 0.2 * np.sign(state)
    matrix = analytic_jacobian(system, state)
    assert np.allclose(matrix, difference_jacobian(system, state), atol=1e-7 * np.abs(matrix).max())
    assert np.abs(matrix.sum(axis=0)).max() < 1e-12 * np.abs(matrix).max()


@given(exponents, orders, seeds, st.integers(0, 23))
def test_symmetries(n: float, order: Order, seed: int, shift: int) -> None:
    system = ConservativeScheme(order).discretize(GranularCompacton(n), Grid(length=10, size=24))
    state = random_state(seed, 1, 24)
    rate = right_hand_side(system, state)
    scale = np.abs(rate).max()
    assert np.allclose(right_hand_side(system, -state), -rate, atol=1e-13 * scale)
    assert np.allclose(right_hand_side(system, np.roll(state, shift)), np.roll(rate, shift), atol=1e-13 * scale)
    assert np.allclose(right_hand_side(system, 2 * state), 2**n * rate, atol=1e-12 * 2**n * scale)


@pytest.mark.parametrize("order", [2, 4, 6])
@pytest.mark.parametrize("n", [1.5, 2, 3, 4.3])
def test_order_on_smooth_states(order: Order, n: float) -> None:
    """f against -F_x, both exact for W = 2 + cos x / 2: W^n + psi (psi W)_xx in closed form by Fourier at high resolution."""
    fine = Grid(length=2 * np.pi, size=128)
    wave = 2 + 0.5 * np.cos(fine.x)
    phi = wave ** ((n + 1) / 2)
    flux = wave ** ((n - 1) / 2) * (phi + np.fft.irfft(-(fine.wavenumbers**2) * np.fft.rfft(phi)))
    exact = -np.fft.irfft(1j * fine.wavenumbers * np.fft.rfft(flux))
    sizes, errors = [32, 64, 128], []
    for size in sizes:
        grid = Grid(length=2 * np.pi, size=size)
        system = ConservativeScheme(order).discretize(GranularCompacton(n), grid)
        rate = right_hand_side(system, (2 + 0.5 * np.cos(grid.x))[None])[0]
        errors.append(float(np.abs(rate - exact[:: 128 // size]).max()))
    assert fitted_order(sizes, errors) == pytest.approx(order, abs=0.2)


def one_wave(n: float, length: float, order: Order, integrator: CVODE | Midpoint) -> Simulation:
    return Simulation(
        equation=GranularCompacton(n),
        grid=Grid(length=length, size=300),
        scheme=ConservativeScheme(order),
        initial=[Compacton(speed=1, center=10)],
        t_end=14,
        frames=3,
        integrator=integrator,
    )


@pytest.mark.parametrize(
    ("n", "length", "order", "bound"),
    [(2, 30, 4, 8e-5), (1.5, 40, 4, 8e-5), pytest.param(3, 30, 6, 2e-3, marks=SLOW), pytest.param(3, 30, 4, 3e-3, marks=SLOW)],
)
def test_one_compacton_without_any_viscosity(n: float, length: float, order: Order, bound: float) -> None:
    """t = 14, N = 300: the error, mass to round-off with the analytic Jacobian, Q to the tolerance of the integrator."""
    simulation = one_wave(n, length, order, CVODE(rtol=1e-4, linear_solver="sparse"))
    dataset = run(simulation)
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, 14)[0]
    assert relative_error(dataset.W.values[-1], exact) < bound
    changes = drift(dataset)
    assert float(abs(changes.mass).max()) < 1e-12
    assert float(abs(changes.momentum).max()) < 1e-5


def test_with_the_midpoint_rule_momentum_is_kept_in_time_too() -> None:
    changes = drift(run(replace(one_wave(3, 30, 6, Midpoint(step=0.02)), t_end=4)))
    assert float(abs(changes.momentum).max()) < 1e-12
    assert float(abs(changes.mass).max()) < 1e-12


def test_viscosity_in_grid_units_adds_to_the_absolute_one() -> None:
    grid = Grid(length=10, size=20)
    equation = GranularCompacton(3)
    state = random_state(1, 1, 20)
    both = ConservativeScheme(4, viscosity=1e-3, grid_viscosity=0.1).discretize(equation, grid)
    same = ConservativeScheme(4, viscosity=1e-3 + 0.1 * grid.spacing**3).discretize(equation, grid)
    assert np.allclose(right_hand_side(both, state), right_hand_side(same, state), rtol=1e-12)
    none = ConservativeScheme(4).discretize(equation, grid)
    lost = float((state * (right_hand_side(both, state) - right_hand_side(none, state))).sum())
    assert lost < 0
    assert both.damping > none.damping == 0


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"order": 3}, "must be one of 2, 4, 6"),
        ({"viscosity": -1}, "scheme.viscosity = -1 must not be negative"),
        ({"grid_viscosity": -1}, "scheme.grid_viscosity = -1 must not be negative"),
    ],
)
def test_bad_settings_are_named(fields: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        ConservativeScheme(**fields)


def test_other_equations_and_small_grids_are_refused() -> None:
    with pytest.raises(InputError, match="RosenauHyman without a source on a Grid, not for Nesterenko"):
        ConservativeScheme().discretize(Nesterenko(2), Grid(10, 20))
    with pytest.raises(InputError, match=r"not K\(3, 2\) in the classical form"):
        ConservativeScheme().discretize(RosenauHyman(3, 2), Grid(10, 20))
    with pytest.raises(InputError, match="order 6 couples 13 neighbours; choose at least 13 points"):
        ConservativeScheme(6).discretize(GranularCompacton(2), Grid(10, 12))
