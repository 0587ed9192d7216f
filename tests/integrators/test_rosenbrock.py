from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mol_compactons import (
    CVODE,
    IDA,
    Compacton,
    ConservativeScheme,
    FourierScheme,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    IntegrationError,
    Lattice,
    NearestNeighbours,
    PeriodicWave,
    PowerContact,
    Rosenbrock,
    Simulation,
    run,
)
from mol_compactons.analysis.drift import drift
from mol_compactons.integrators.rosenbrock import GAMMA, INTERPOLATION, SLOPES, STAGES, STATES, RosenbrockIntegration
from tests.systems import Array, fitted_order, one_compacton, relative_error


def fixed_steps(count: int, t_end: float = 0.5) -> tuple[Array, Array]:
    """The exact smooth wave by equal steps: the end, and the interpolant in the middle of the last step."""
    equation, wave, grid = GranularCompacton(3), PeriodicWave(speed=1, crest=1.1), Grid(2 * np.pi, 16)
    system = ConservativeScheme(order=2).discretize(equation, grid)
    integration = RosenbrockIntegration(Rosenbrock(rtol=0.1, atol=1e6), system, wave.values(equation, grid))
    for _ in range(count):
        integration._step = t_end / count
        integration._take_step()
    return integration._state.copy(), integration._interpolated(t_end - 0.5 * t_end / count)


def test_fifth_order_with_an_interpolant_of_the_fourth() -> None:
    counts = [5, 10, 20]
    exact, _ = fixed_steps(800)
    errors = [float(np.abs(fixed_steps(count)[0] - exact).max()) for count in counts]
    assert fitted_order(counts, errors) == pytest.approx(5, abs=0.5)
    between = []
    for count in counts:
        middle = 0.5 - 0.25 / count
        steps = 2 * count - 1
        reference, _ = fixed_steps(20 * steps, t_end=middle)
        between.append(float(np.abs(fixed_steps(count)[1] - reference).max()))
    assert fitted_order(counts, between) > 3.6


def test_the_coefficients_are_consistent() -> None:
    """Stiffly accurate: the last stages only add; the interpolant of a constant is the constant; gamma from the stability."""
    assert np.array_equal(STATES[7, :5], STATES[5, :5])
    assert STATES[7, 5:7].tolist() == [1, 1]
    assert SLOPES.shape == STATES.shape == (STAGES, STAGES)
    assert INTERPOLATION.shape == (3, STAGES)
    assert 0.2 < GAMMA < 0.25


@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_it_agrees_with_sundials(n: float) -> None:
    simulation = one_compacton(n=n, length=40, size=200, t_end=3, frames=7, integrator=Rosenbrock(rtol=1e-6))
    ours = run(simulation)
    reference = run(replace(simulation, integrator=IDA(rtol=1e-6)))
    assert np.abs(ours.W - reference.W).max() < 1e-6
    assert float(abs(drift(ours).mass).max()) < 1e-11
    assert ours.attrs["solver_steps"] < reference.attrs["solver_steps"] / 10


def test_it_takes_two_components_and_no_mass_matrix() -> None:
    chain = Simulation(
        equation=GranularChain(PowerContact(2, linear=0.1)),
        grid=Lattice(40),
        scheme=NearestNeighbours(),
        initial=[Compacton(1, 20)],
        t_end=5,
        frames=3,
        integrator=Rosenbrock(rtol=1e-6),
    )
    other = replace(chain, integrator=CVODE(rtol=1e-9, max_order=5))
    assert np.abs(run(chain).R[-1] - run(other).R[-1]).max() < 1e-7


def test_more_frames_change_nothing() -> None:
    few, many = (run(one_compacton(t_end=1, frames=frames, integrator=Rosenbrock())) for frames in (3, 21))
    assert relative_error(many.W.sel(t=1).values, few.W.sel(t=1).values) < 1e-13
    assert few.attrs["solver_steps"] == many.attrs["solver_steps"]


def test_it_says_when_it_gives_up() -> None:
    with pytest.raises(IntegrationError, match=r"within max_steps steps; raise integrator\.max_steps"):
        run(one_compacton(integrator=Rosenbrock(max_steps=3)))
    with pytest.raises(IntegrationError, match="its step became too small"):
        run(one_compacton(size=600, second_difference="nearest", viscosity=0, t_end=2, integrator=Rosenbrock(rtol=1e-5)))


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"rtol": 0}, "rtol = 0 must lie between"),
        ({"atol": -1}, "atol = -1.0 must be positive"),
        ({"max_step": 0}, "max_step = 0.0 must be positive"),
        ({"max_steps": 0}, "max_steps = 0 must be at least 1"),
    ],
)
def test_bad_settings_are_named(fields: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Rosenbrock(**fields)


def test_it_needs_a_band() -> None:
    system = FourierScheme().discretize(GranularCompacton(2), Grid(30, 50))
    with pytest.raises(InputError, match="Rosenbrock needs a banded Jacobian"):
        Rosenbrock().check_system(system)
