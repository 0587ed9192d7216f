from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    CVODE,
    IDA,
    Compacton,
    ConservativeScheme,
    FourierScheme,
    GranularCompacton,
    Grid,
    InputError,
    Midpoint,
    PeriodicWave,
    Simulation,
    run,
)
from mol_compactons.analysis.drift import drift
from mol_compactons.equations import RosenauHyman
from tests.systems import random_state, right_hand_side


@given(st.sampled_from([1.5, 2.0, 3.0]) | st.floats(1.1, 7), st.booleans(), st.sampled_from([24, 25]), st.integers(0, 10**6))
def test_momentum_is_conserved_to_round_off(n: float, dealias: bool, size: int, seed: int) -> None:
    system = FourierScheme(dealias).discretize(GranularCompacton(n), Grid(length=10, size=size))
    state = random_state(seed, 1, size)
    rate = right_hand_side(system, state)
    assert abs(float((state * rate).sum())) <= 1e-12 * float(np.abs(state * rate).sum())


@given(st.sampled_from([1.5, 2, 3, 4.2]), st.booleans(), st.integers(0, 10**6))
def test_the_product_with_the_jacobian_is_the_derivative(n: float, dealias: bool, seed: int) -> None:
    system = FourierScheme(dealias, viscosity=1e-4, viscosity_order=6).discretize(GranularCompacton(n), Grid(10, 24))
    state, vector = 3 + random_state(seed, 1, 24) * 0.3, random_state(seed + 1, 1, 24)
    product, step = np.empty_like(state), 1e-6
    assert system.jacobian_vector is not None
    system.jacobian_vector(0.0, state, vector, product)
    ahead, behind = right_hand_side(system, state + step * vector), right_hand_side(system, state - step * vector)
    assert np.allclose(product, (ahead - behind) / (2 * step), atol=1e-6 * np.abs(product).max())


def test_the_energy_is_that_of_the_wave_to_round_off() -> None:
    """Int (phi_x^2 - phi^2) / (n+1), phi = W^((n+1)/2)."""
    n, grid = 2.5, Grid(2 * np.pi, 64)
    state = (2 + 0.5 * np.cos(grid.x))[None]
    phi, slope = state[0] ** ((n + 1) / 2), -(n + 1) / 2 * state[0] ** ((n - 1) / 2) * 0.5 * np.sin(grid.x)
    for dealias in (False, True):
        found = FourierScheme(dealias).discretize(GranularCompacton(n), grid).invariants(state)["energy"]
        assert found == pytest.approx(grid.spacing * float((slope**2 - phi**2).sum()) / (n + 1), rel=1e-12)


def test_on_a_smooth_wave_the_error_falls_exponentially() -> None:
    errors = []
    for size in (16, 32, 64):
        grid = Grid(length=2 * np.pi, size=size)
        wave = np.sqrt(1 + 0.5 * np.cos(grid.x))
        system = FourierScheme(dealias=False).discretize(GranularCompacton(3), grid)
        errors.append(float(np.abs(right_hand_side(system, wave[None])[0] - 0.25 * np.sin(grid.x) / wave).max()))
    assert errors[1] < 1e-3 * errors[0]
    assert errors[2] < 1e-3 * errors[1]


def test_the_smooth_wave_travels() -> None:
    simulation = Simulation(
        equation=GranularCompacton(3),
        grid=Grid(length=2 * np.pi, size=32),
        scheme=FourierScheme(),
        initial=[PeriodicWave(speed=1, crest=float(np.sqrt(1.5)))],
        t_end=1,
        frames=2,
        integrator=CVODE(rtol=1e-6, linear_solver="krylov"),
    )
    dataset = run(simulation)
    exact = np.sqrt(1 + 0.5 * np.cos(simulation.grid.coordinates - 1))
    assert np.abs(dataset.W.values[-1] - exact).max() < 1e-5
    assert float(abs(drift(dataset).momentum).max()) < 1e-6


@pytest.mark.parametrize("dealias", [True, False])
def test_the_smooth_wave_travels_to_nine_digits_with_the_composed_midpoint_rule(dealias: bool) -> None:
    simulation = Simulation(
        equation=GranularCompacton(3),
        grid=Grid(length=2 * np.pi, size=64),
        scheme=FourierScheme(dealias=dealias),
        initial=[PeriodicWave(speed=1, crest=float(np.sqrt(1.5)))],
        t_end=1,
        frames=2,
        integrator=Midpoint(step=0.01, order=4),
    )
    dataset = run(simulation)
    exact = np.sqrt(1 + 0.5 * np.cos(simulation.grid.coordinates - 1))
    assert np.abs(dataset.W.values[-1] - exact).max() < 1e-9
    assert float(abs(drift(dataset).momentum).max()) < 1e-13


def test_it_agrees_with_the_conservative_scheme_on_a_compacton() -> None:
    def final(scheme: FourierScheme | ConservativeScheme, integrator: CVODE) -> Any:
        simulation = Simulation(
            equation=GranularCompacton(2),
            grid=Grid(length=30, size=200),
            scheme=scheme,
            initial=[Compacton(speed=1, center=10)],
            t_end=2,
            frames=2,
            integrator=integrator,
        )
        return run(simulation).W.values[-1]

    spectral = final(FourierScheme(viscosity=1e-5), CVODE(rtol=1e-3, linear_solver="krylov"))
    assert np.abs(spectral - final(ConservativeScheme(6), CVODE(rtol=1e-4))).max() < 2e-3


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"viscosity": -1}, "viscosity = -1 must not be negative"),
        ({"viscosity_order": 3}, "viscosity_order = 3 must be an even number"),
        ({"dealias": "yes"}, "must be true or false"),
    ],
)
def test_bad_settings_are_named(fields: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        FourierScheme(**fields)


@pytest.mark.parametrize("integrator", [IDA(), CVODE(), CVODE(linear_solver="sparse")])
def test_integrators_that_need_a_band_are_refused(integrator: IDA | CVODE) -> None:
    system = FourierScheme().discretize(GranularCompacton(2), Grid(length=30, size=50))
    with pytest.raises(InputError, match="needs a banded Jacobian, which this scheme has not"):
        integrator.check_system(system)


def test_krylov_is_for_it_alone() -> None:
    system = ConservativeScheme().discretize(GranularCompacton(2), Grid(length=30, size=50))
    with pytest.raises(InputError, match="'krylov' is for schemes without a banded Jacobian"):
        CVODE(linear_solver="krylov").check_system(system)
    with pytest.raises(InputError, match="GranularCompacton without a source on a Grid, not for RosenauHyman"):
        FourierScheme().discretize(RosenauHyman(2, 2), Grid(10, 20))
