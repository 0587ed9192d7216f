from dataclasses import replace
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import pytest

from mol_compactons import FourierScheme, GranularCompacton, Grid, InputError, IntegrationError, Midpoint, run
from mol_compactons.analysis.drift import drift
from mol_compactons.semidiscrete import SemiDiscretization
from tests.systems import Array, fitted_order, one_compacton, relative_error


def test_second_order_in_the_step() -> None:
    frames = [run(one_compacton(t_end=1, integrator=Midpoint(step=step))).W.values[-1] for step in (0.02, 0.01, 0.005, 0.0025)]
    differences = [np.abs(a - b).max() for a, b in pairwise(frames)]
    assert differences[0] / differences[1] == pytest.approx(4, rel=0.15)
    assert differences[1] / differences[2] == pytest.approx(4, rel=0.05)


@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_runs_for_every_exponent(n: float) -> None:
    simulation = one_compacton(n=n, length=40, size=300, t_end=2, integrator=Midpoint())
    dataset = run(simulation)
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, 2)[0]
    assert np.linalg.norm(dataset.W.values[-1] - exact) < 0.02 * np.linalg.norm(exact)
    assert dataset.attrs["solver_steps"] == 200


def rotation() -> SemiDiscretization:
    """y' = K y with K the skew central difference on a ring: it conserves sum y^2."""
    base = one_compacton(size=20).discretize()

    def rhs(t: float, state: Array, out: Array) -> None:
        out[:] = np.roll(state, -1, axis=1) - np.roll(state, 1, axis=1)

    def jacobian(t: float, state: Array, out: Array) -> None:
        out[:] = 0
        out[0, 0, base.reach + 1], out[0, 0, base.reach - 1] = 1, -1

    return replace(base, rhs=rhs, jacobian=jacobian, mass=None)


def test_a_quadratic_invariant_is_kept_to_round_off() -> None:
    state = np.random.default_rng(5).normal(size=(1, 20))
    integration = Midpoint(step=0.3).start(rotation(), state, 30.0)
    moved = integration.advance(30.0)
    assert float((moved**2).sum()) == pytest.approx(float((state**2).sum()), rel=1e-13)
    assert np.abs(moved - state).max() > 0.1
    assert integration.counters.steps == 100


@pytest.mark.parametrize(("order", "points"), [(2, 1), (2, 2), (4, 1), (6, 1), (6, 3)])
def test_the_composed_rule_has_its_order(order: Literal[2, 4, 6], points: int) -> None:
    """On the ring rotation every Fourier mode turns at the rate 2 sin(theta)."""
    state = np.random.default_rng(5).normal(size=(1, 20))
    turned = np.exp(2j * np.sin(2 * np.pi * np.fft.rfftfreq(20)) * 5.0) * np.fft.rfft(state)
    exact = np.fft.irfft(turned, n=20)
    steps, errors = [20, 40, 80], []
    for count in steps:
        rule = Midpoint(step=5 / count, order=order, points=points, tolerance=1e-15)
        errors.append(relative_error(rule.start(rotation(), state, 5.0).advance(5.0), exact))
    assert fitted_order(steps, errors) == pytest.approx(order, abs=0.2)


def test_two_gauss_points_keep_the_energy_of_the_cubic_equation() -> None:
    """The averaged vector field is exact for the cubic f of n = 3, and the compact scheme is Hamiltonian without viscosity."""
    simulation = one_compacton(n=3, size=120, viscosity=0, t_end=2, integrator=Midpoint(step=0.05, points=2))
    kept = drift(run(simulation))
    assert float(abs(kept.energy).max()) < 1e-13
    assert float(abs(kept.mass).max()) < 1e-13
    plain = drift(run(replace(simulation, integrator=Midpoint(step=0.05))))
    assert float(abs(plain.energy).max()) > 1e-9


def test_an_interval_that_is_no_multiple_is_cut_into_equal_steps() -> None:
    integration = Midpoint(step=0.3).start(rotation(), np.ones((1, 20)), 1.0)
    integration.advance(1.0)
    assert integration.counters.steps == 4


def test_a_step_that_does_not_converge_says_so() -> None:
    with pytest.raises(IntegrationError, match=r"choose a smaller integrator\.step") as failure:
        run(one_compacton(n=2, size=300, second_difference="nearest", viscosity=0, t_end=50, integrator=Midpoint(step=10)))
    assert failure.value.dataset is not None


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"step": 0}, "step = 0"),
        ({"step": -1}, "step = -1"),
        ({"tolerance": 1}, "tolerance = 1"),
        ({"order": 3}, "order = 3 must be one of 2, 4, 6"),
        ({"points": 9}, "points = 9 must lie between 1, the midpoint, and 8"),
    ],
)
def test_bad_settings_are_named(fields: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Midpoint(**fields)


def test_a_matrix_that_is_known_by_its_products_is_taken_in_the_middle_of_the_step() -> None:
    grid = Grid(2 * np.pi, 24)
    system = FourierScheme(dealias=False).discretize(GranularCompacton(3), grid)
    asked: list[float] = []

    def product(t: float, state: Array, vector: Array, out: Array) -> None:
        asked.append(t)
        assert system.jacobian_vector is not None
        system.jacobian_vector(t, state, vector, out)

    state = (2 + 0.3 * np.cos(grid.x))[None]
    Midpoint(step=0.01).start(replace(system, jacobian_vector=product), state, 0.03).advance(0.03)
    assert sorted(set(np.round(asked, 12))) == [0.005, 0.015, 0.025]


def test_a_step_of_many_iterations_asks_for_a_new_matrix() -> None:
    """The Jacobian is said to be zero, so that each iteration divides the error by the same factor."""
    seen = set()
    for rate in np.geomspace(1e-4, 0.02, 20):
        integration = Midpoint(step=1.0).start(decaying(float(rate)), np.ones((1, 4)), 2.0)
        integration.advance(1.0)
        before, iterations = integration.counters.jacobians, integration.counters.evaluations
        integration.advance(2.0)
        seen.add(iterations)
        assert integration.counters.jacobians - before == (iterations > 5)
    assert {5, 6} <= seen


def decaying(rate: float) -> SemiDiscretization:
    """y' = -rate y, with a Jacobian that is wrong."""

    def rhs(t: float, state: Array, out: Array) -> None:
        out[:] = -rate * state

    def jacobian(t: float, state: Array, out: Array) -> None:
        out[:] = 0

    return SemiDiscretization(size=4, components=1, reach=1, rhs=rhs, jacobian=jacobian, invariants=lambda state: {})
