from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    CVODE,
    Compacton,
    CompactScheme,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    Lattice,
    NearestNeighbours,
    Ripple,
    Simulation,
    Uniform,
    run,
)
from mol_compactons.invariants import drift
from tests.systems import analytic_jacobian, difference_jacobian, random_state, right_hand_side


@given(st.sampled_from([1.5, 2, 3]), st.sampled_from([0.0, 0.4]), st.integers(0, 1000))
def test_rates_conserve_mass_momentum_and_energy(n: float, linear: float, seed: int) -> None:
    system = NearestNeighbours().discretize(GranularChain(n, 1.3, linear), Lattice(size=12))
    state = random_state(seed, 2, 12)
    state[1] -= state[1].mean()
    rate = right_hand_side(system, state)
    step = 1e-6
    ahead, behind = system.invariants(state + step * rate), system.invariants(state - step * rate)
    for name in ("mass", "momentum", "energy"):
        assert abs(ahead[name] - behind[name]) / step < 1e-6 * (1 + abs(ahead["energy"])), name


@given(st.sampled_from([2, 3]), st.integers(0, 100))
def test_jacobian_is_the_derivative(n: float, seed: int) -> None:
    system = NearestNeighbours().discretize(GranularChain(n, linear=0.3), Lattice(size=9))
    state = random_state(seed, 2, 9)
    assert np.allclose(analytic_jacobian(system, state), difference_jacobian(system, state), atol=1e-7)


def test_a_small_ripple_oscillates_with_the_sine_of_the_lattice() -> None:
    """At the shortest wave, where Nesterenko's equation has long been unstable: omega = 2 sqrt(F')."""
    equation = GranularChain(n=1.5)
    frequency = np.sqrt(equation.frequency_squared(np.pi, 1.0))
    simulation = Simulation(
        equation=equation,
        grid=Lattice(size=16),
        scheme=NearestNeighbours(),
        initial=[Uniform(1), Ripple(1e-5, 8)],
        t_end=2 * np.pi / frequency,
        frames=3,
        integrator=CVODE(rtol=1e-9, atol=1e-14, max_order=5),
    )
    ripples = [np.fft.rfft(frame)[8].real for frame in run(simulation).R.values]
    assert frequency == pytest.approx(2 * np.sqrt(1.5))
    assert ripples[1] == pytest.approx(-ripples[0], rel=1e-3)
    assert ripples[2] == pytest.approx(ripples[0], rel=1e-3)


@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_a_pulse_between_two_sites_conserves_everything_too(n: float) -> None:
    simulation = Simulation(
        equation=GranularChain(n),
        grid=Lattice(size=60),
        scheme=NearestNeighbours(),
        initial=[Compacton(speed=1, center=10.3)],
        t_end=20,
        frames=5,
        integrator=CVODE(rtol=1e-9, max_order=5, linear_solver="sparse"),
    )
    changes = drift(run(simulation))
    assert float(abs(changes.mass).max()) < 1e-10
    assert float(abs(changes.energy).max()) < 1e-5


def test_rates_that_do_not_add_up_are_refused() -> None:
    with pytest.raises(InputError, match="The rates R_t add up to 5, but on a ring they must add up to 0"):
        GranularChain(2).check_state(np.array([np.ones(5), np.ones(5)]))


def test_the_corrected_velocity_moves_the_pulse_to_the_right() -> None:
    simulation = Simulation(
        equation=GranularChain(n=1.5),
        grid=Lattice(size=60),
        scheme=NearestNeighbours(),
        initial=[Compacton(speed=1, center=20)],
        t_end=20,
        frames=3,
        integrator=CVODE(rtol=1e-8, max_order=5),
    )
    dataset = run(simulation)
    assert dataset.R.dims == ("t", "k")
    assert abs(int(np.argmax(dataset.R.values[-1])) - 40) <= 2
    assert float(dataset.energy[-1] / dataset.energy[0]) == pytest.approx(1, abs=1e-6)


def test_schemes_and_equations_that_do_not_go_together_are_named() -> None:
    with pytest.raises(InputError, match="CompactScheme is for equations on a Grid, not for GranularChain on a Lattice"):
        CompactScheme().discretize(GranularChain(2), Lattice(20))
    with pytest.raises(InputError, match="NearestNeighbours is for a GranularChain on a Lattice, not for GranularCompacton"):
        NearestNeighbours().discretize(GranularCompacton(2), Grid(10, 20))
    with pytest.raises(InputError, match="n = 1 must be larger than 1"):
        GranularChain(1)
    with pytest.raises(InputError, match="between 5 and"):
        Lattice(3)
