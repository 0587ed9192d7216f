"""W -> r W, t -> r^(1-n) t maps runs to runs: nothing depends on the size of a wave or of the box, whatever the integrator."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from mol_compactons import (
    CVODE,
    IDA,
    Compacton,
    CompactScheme,
    ConservativeScheme,
    GaussLegendre,
    GranularChain,
    GranularCompacton,
    Grid,
    Impact,
    Lattice,
    Midpoint,
    Nesterenko,
    PowerContact,
    Rosenbrock,
    Samples,
    Simulation,
    SolitaryWave,
    Symplectic,
    run,
)
from mol_compactons.integrators.scales import BISECTIONS, component_scales, occupied_share, ripple_persistence, steepened
from mol_compactons.semidiscrete import SemiDiscretization
from tests.systems import relative_error

SPEEDS = (1e-6, 1e-3, 1e3, 1e6)


def wave(speed: float, integrator: Any, n: float, scheme: Any) -> Simulation:
    grid, start = Grid(40, 160), [Compacton(speed, 15)]
    return Simulation(GranularCompacton(n), grid, start, t_end=6 / speed, scheme=scheme, frames=3, integrator=integrator)


def error(simulation: Simulation) -> float:
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, simulation.t_end)
    first = simulation.equation.variables[0]
    return float(relative_error(run(simulation)[first].values[-1], exact[0]))


@pytest.mark.parametrize("n", [1.5, 3])
@pytest.mark.parametrize(
    ("integrator", "scheme"),
    [
        (IDA(rtol=1e-4), ConservativeScheme(4)),
        (IDA(rtol=1e-4, linear_solver="sparse"), CompactScheme("wide")),
        (CVODE(rtol=1e-4), ConservativeScheme(4)),
        (Rosenbrock(rtol=1e-3), ConservativeScheme(4)),
        (Rosenbrock(rtol=1e-3), CompactScheme("wide")),
    ],
)
def test_the_error_of_a_compacton_does_not_depend_on_its_speed(integrator: Any, scheme: Any, n: float) -> None:
    expected = error(wave(1, integrator, n, scheme))
    assert 1e-5 < expected < 0.1
    for speed in SPEEDS:
        assert error(wave(speed, integrator, n, scheme)) == pytest.approx(expected, rel=0.2)


@pytest.mark.parametrize("power", [-6, 6])
@pytest.mark.parametrize("method", [Midpoint, GaussLegendre])
def test_a_method_of_fixed_steps_is_scaled_with_its_step(method: type[Midpoint] | type[GaussLegendre], power: int) -> None:
    errors = [error(wave(c, method(step=0.1 / c), 2, ConservativeScheme(4))) for c in (1, 10.0**power)]
    assert errors[1] == pytest.approx(errors[0], rel=1e-5)


@pytest.mark.parametrize("integrator", [IDA(rtol=1e-5), CVODE(rtol=1e-5, method="Adams"), Rosenbrock(rtol=1e-4)])
@pytest.mark.parametrize("n", [1.5, 3])
def test_the_error_of_a_chain_does_not_depend_on_its_speed(integrator: Any, n: float) -> None:
    def chain(speed: float) -> Simulation:
        law, sites = PowerContact(n), Lattice(60)
        return Simulation(
            GranularChain(law), sites, [SolitaryWave(speed, 20)], t_end=10 / speed, frames=2, integrator=integrator
        )

    expected = error(chain(1))
    assert 1e-8 < expected < 1e-2
    for speed in SPEEDS:
        assert error(chain(speed)) == pytest.approx(expected, rel=0.2)


def test_a_chain_at_rest_and_one_that_is_struck_are_scaled_too() -> None:
    """One component is zero at first; its size follows from the other. The exact symmetry gives the same numbers."""
    chain = GranularChain(PowerContact(2), form="displacements", ends="free")
    bent = np.append(0.3 * np.sin(np.arange(30)), np.zeros(30))
    for start in (lambda r: Samples(r * bent), lambda r: Impact(r**1.5, grains=3)):
        results = []
        for r in (1.0, 1e4, 1e-4):
            t_end = 8 / r**0.5
            simulation = Simulation(chain, Lattice(30), [start(r)], t_end=t_end, frames=2, integrator=CVODE(rtol=1e-5))
            exact = run(
                Simulation(chain, Lattice(30), [start(r)], t_end=t_end, frames=2, integrator=Symplectic(t_end / 4000, 6))
            )
            results.append(relative_error(run(simulation).Q.values[-1], exact.Q.values[-1]))
        assert 1e-7 < results[0] < 1e-2
        assert results[1:] == pytest.approx(results[:1] * 2, rel=0.2)


@pytest.mark.parametrize("integrator", [IDA(rtol=1e-5), CVODE(rtol=1e-5), Rosenbrock(rtol=1e-4)])
def test_a_tolerance_means_the_same_in_a_longer_box(integrator: Any) -> None:
    """The time error: against the same grid at a tight tolerance."""
    errors = []
    for length in (30, 240):
        grid, start = Grid(length, 5 * length), [Compacton(1, 12)]
        pair = [
            run(Simulation(GranularCompacton(2), grid, start, 4, ConservativeScheme(4), 2, one)).W.values[-1]
            for one in (integrator, Rosenbrock(rtol=1e-9))
        ]
        errors.append(relative_error(pair[0], pair[1]))
    assert errors[0] / 2.5 < errors[1] < 1.25 * errors[0]


@given(st.floats(-9, 9), st.sampled_from([1.5, 2, 3]))
def test_scales_are_scaled(power: float, n: float) -> None:
    r = 10**power
    system = CompactScheme().discretize(Nesterenko(n), Grid(30, 60))
    rest = Compacton(1, 9).values(Nesterenko(n), Grid(30, 60)) * [[1.0], [0.0]]
    one = component_scales(system, rest)
    other = component_scales(system, rest * r)
    assert (one > 0).all()
    assert other == pytest.approx(one * [r, r ** ((n + 1) / 2)], rel=2 ** (2 * 0.5**BISECTIONS) - 1)


def test_the_share_of_the_grid_that_is_occupied() -> None:
    """The mean square of a cosine squared over its support is 3/8; an empty background counts for nothing."""
    wave = Compacton(1, 15).values(GranularCompacton(2), Grid(30, 3000))
    assert occupied_share(wave) == pytest.approx(3 / 8 * GranularCompacton(2).compacton(1).width / 30, rel=1e-4)
    assert occupied_share(np.ones((2, 9))) == 1
    assert occupied_share(np.zeros((2, 9))) == 1
    assert occupied_share(np.array([[0.0, 4, 0, 0], [1.0, 1, 0, 0]])) == 0.5


def persistence(system: SemiDiscretization, state: NDArray[np.float64]) -> float:
    return ripple_persistence(system, state, system.rate(0.0, state))


@given(power=st.integers(-6, 6), size=st.integers(60, 300), n=st.sampled_from([1.5, 2.0, 3.0]))
def test_ripples_last_as_long_for_a_wave_of_any_speed(power: int, size: int, n: float) -> None:
    """Damping in proportion to the speeds leaves the lifetime in the time of the wave."""
    found = []
    for speed in (1.0, 10.0**power):
        scheme = ConservativeScheme(4, grid_viscosity=0.03 * speed, viscosity_order=6)
        equation, grid = GranularCompacton(n), Grid(40, size)
        found.append(persistence(scheme.discretize(equation, grid), Compacton(speed, 20).values(equation, grid)))
    assert 0 < found[0] < 1
    assert found[1] == pytest.approx(found[0], rel=1e-6)


def test_ripples_last_without_damping_and_the_less_the_more_of_it() -> None:
    equation, grid = GranularCompacton(3), Grid(30, 200)
    state = Compacton(1, 10).values(equation, grid)
    schemes = [ConservativeScheme(4, grid_viscosity=nu, viscosity_order=6) for nu in (0, 1e-3, 1e-2, 1)]
    shares = [persistence(scheme.discretize(equation, grid), state) for scheme in schemes]
    assert shares[0] == 1
    assert shares == sorted(shares, reverse=True)
    assert shares[-1] < 0.02
    assert persistence(schemes[1].discretize(equation, grid), 0 * state) == 0


def test_an_oscillator_has_no_ripples() -> None:
    chain = Simulation(GranularChain(PowerContact(1.5)), Lattice(40), [SolitaryWave(1, 20)], t_end=1)
    assert persistence(chain.discretize(), chain.initial_state()) == 0


@given(rtol=st.floats(1e-12, 1e-3), power=st.floats(0, 2), factor=st.floats(0.01, 1))
def test_a_local_tolerance_falls_by_its_power(rtol: float, power: float, factor: float) -> None:
    assert steepened(1e-3, power) == 1e-3
    assert steepened(0.05, power) == 0.05
    assert steepened(rtol * factor, power) / steepened(rtol, power) == pytest.approx(factor ** (1 + power))
