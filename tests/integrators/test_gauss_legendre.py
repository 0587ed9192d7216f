"""Gauss-Legendre collocation: its order, what it keeps, its derivative, and what it says where it cannot."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest

from mol_compactons import (
    Compacton,
    CompactScheme,
    ConservativeScheme,
    FourierScheme,
    GaussLegendre,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    IntegrationError,
    Lattice,
    PadeScheme,
    PowerContact,
    RosenauHyman,
    Samples,
    Simulation,
    SolitaryWave,
    run,
)
from mol_compactons.analysis.drift import drift
from mol_compactons.integrators.gauss_legendre import Stages, tableau
from mol_compactons.integrators.linear.newton import newton_matrix
from mol_compactons.semidiscrete import SemiDiscretization
from tests.systems import Array, difference_jacobian, fitted_order, one_compacton, random_state, relative_error

Order = Literal[4, 6]
ORDERS: tuple[Order, ...] = (4, 6)


def ring(mass: Array | None = None) -> SemiDiscretization:
    """M y' = K y on 20 cells with K the skew central difference: Fourier modes turn."""

    def rhs(t: float, state: Array, out: Array) -> None:
        out[:] = np.roll(state, -1, axis=1) - np.roll(state, 1, axis=1)

    def jacobian(t: float, state: Array, out: Array) -> None:
        out[:] = 0
        out[0, 0, 2], out[0, 0, 0] = 1, -1

    return SemiDiscretization(
        size=20, components=1, reach=1, rhs=rhs, jacobian=jacobian, invariants=lambda state: {}, mass=mass
    )


MASS = np.array([1 / 6, 2 / 3, 1 / 6])


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("mass", [None, MASS])
def test_the_error_on_turning_modes_falls_with_its_order(order: Order, mass: Array | None) -> None:
    system, state, steps, errors = ring(mass), random_state(5, 1, 20), [10, 20, 40], []
    theta = 2 * np.pi * np.fft.rfftfreq(20)
    weight = 1.0 if mass is None else (2 + np.cos(theta)) / 3
    exact = np.fft.irfft(np.exp(2j * np.sin(theta) / weight * 5) * np.fft.rfft(state), n=20)
    for count in steps:
        errors.append(relative_error(GaussLegendre(5 / count, order).start(system, state, 5.0).advance(5.0), exact))
    assert fitted_order(steps, errors) == pytest.approx(order, abs=0.3)


@pytest.mark.parametrize("order", ORDERS)
def test_the_error_on_a_smooth_wave_falls_with_its_order(order: Order) -> None:
    """Against the same semi-discretisation of W = sqrt(2 + cos x), n = 3, so coarse that the steps resolve its ripples."""
    grid = Grid(2 * np.pi, 10)
    system, state = ConservativeScheme(4).discretize(GranularCompacton(3), grid), np.sqrt(2 + np.cos(grid.coordinates))[None]
    exact = GaussLegendre(1 / 640, 6).start(system, state, 1.0).advance(1.0)
    assert relative_error(exact, state) > 0.1
    steps = [40, 80, 160]
    errors = [relative_error(GaussLegendre(1 / k, order).start(system, state, 1.0).advance(1.0), exact) for k in steps]
    assert fitted_order(steps, errors) == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize("order", ORDERS)
def test_explicit_time_is_taken_at_the_nodes(order: Order) -> None:
    """y' = (k + 1) t^k is exact up to the degree 2 s - 1, and not beyond."""
    for power in range(order + 1):

        def rhs(t: float, state: Array, out: Array, power: int = power) -> None:
            out[:] = (power + 1) * t**power

        system = SemiDiscretization(size=5, components=1, reach=1, rhs=rhs, invariants=lambda state: {}, explicit_time=True)
        reached = GaussLegendre(0.5, order).start(system, np.zeros((1, 5)), 1.0).advance(1.0)
        assert (abs(reached - 1).max() < 1e-14) == (power < order)


@pytest.mark.parametrize("order", ORDERS)
def test_the_tableau_is_that_of_collocation(order: int) -> None:
    """A integrates powers below s from 0 to c_i, b up to 2 s - 1, and b_i a_ij + b_j a_ji = b_i b_j makes it symplectic."""
    table, stages = tableau(order), order // 2
    weights = table.update @ table.matrix
    for power in range(stages):
        assert table.matrix @ table.nodes**power == pytest.approx(table.nodes ** (power + 1) / (power + 1), abs=1e-15)
        assert table.ahead @ table.nodes ** (power + 1) == pytest.approx((1 + table.nodes) ** (power + 1) - 1, abs=1e-13)
    for power in range(2 * stages):
        assert weights @ table.nodes**power == pytest.approx(1 / (power + 1), abs=1e-15)
    product = weights[:, None] * table.matrix
    assert np.abs(product + product.T - np.outer(weights, weights)).max() < 1e-15
    if order == 4:
        assert table.nodes == pytest.approx([0.5 - 3**0.5 / 6, 0.5 + 3**0.5 / 6], abs=1e-15)
        assert table.matrix.ravel() == pytest.approx([1 / 4, 1 / 4 - 3**0.5 / 6, 1 / 4 + 3**0.5 / 6, 1 / 4], abs=1e-15)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_mass_and_momentum_of_the_conservative_scheme_are_kept_to_round_off(order: Order, n: float) -> None:
    simulation = replace(
        one_compacton(n=n, length=40, size=160, viscosity=0, t_end=4),
        scheme=ConservativeScheme(4),
        integrator=GaussLegendre(0.05, order),
    )
    dataset = run(simulation)
    assert relative_error(dataset.W.values[-1], dataset.W.values[0]) > 0.5
    changes = drift(dataset)
    assert float(abs(changes.mass).max()) < 1e-13
    assert float(abs(changes.momentum).max()) < 1e-13
    assert float(abs(changes.energy).max()) > 1e-12


@pytest.mark.parametrize("order", ORDERS)
def test_it_is_symmetric_a_step_there_and_back_is_none(order: Order) -> None:
    """Back in time is the mirror image in space of a wave: W(-x, -t) obeys the same equation."""
    simulation = replace(one_compacton(n=2, size=100, viscosity=0), scheme=ConservativeScheme(4))
    system, state = simulation.discretize(), simulation.initial_state()
    there = GaussLegendre(0.1, order).start(system, state, 1.0).advance(1.0)
    mirrored = np.ascontiguousarray(there[:, ::-1])
    back = GaussLegendre(0.1, order).start(system, mirrored, 1.0).advance(1.0)[:, ::-1]
    assert relative_error(there, state) > 0.2
    assert relative_error(back, state) < 1e-12


SYSTEMS: dict[str, tuple[Any, Any, Any, Any]] = {
    "conservative": (GranularCompacton(2), Grid(20, 30), Compacton(1, 8), ConservativeScheme(4)),
    "mass matrix": (GranularCompacton(3), Grid(10, 24), Compacton(1, 4), CompactScheme("wide", viscosity=0)),
    "K(2, 2)": (RosenauHyman(2, 2, absolute=True), Grid(16, 24), Compacton(1, 8), PadeScheme("pade_8")),
    "chain": (GranularChain(PowerContact(2)), Lattice(16), SolitaryWave(1, 8), None),
}


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", SYSTEMS)
def test_the_tangents_are_the_derivative_of_the_map(name: str, order: Order) -> None:
    equation, grid, wave, scheme = SYSTEMS[name]
    simulation = Simulation(equation, grid, [wave], 1.0, scheme)
    system, state, method = simulation.discretize(), simulation.initial_state(), GaussLegendre(0.1, order)
    directions = np.random.default_rng(1).normal(size=(3, *state.shape))
    moved, pushed = method.start(system, state, 0.3).advance_with_tangents(0.3, directions)
    assert np.array_equal(moved, method.start(system, state, 0.3).advance(0.3))
    for direction, push in zip(directions, pushed, strict=True):
        small = 1e-6 * direction
        ahead, behind = (method.start(system, state + sign * small, 0.3).advance(0.3) for sign in (1, -1))
        assert relative_error((ahead - behind) / 2e-6, push) < 1e-4
        assert relative_error(push, direction) > 0.01


def test_many_tangents_are_pushed_in_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    equation, grid, wave, scheme = SYSTEMS["conservative"]
    simulation = Simulation(equation, grid, [wave], 1.0, scheme)
    system, state, units = simulation.discretize(), simulation.initial_state(), np.eye(30)[:, None]
    whole = GaussLegendre(0.1).start(system, state, 0.2).advance_with_tangents(0.2, units)[1]
    monkeypatch.setattr("mol_compactons.integrators.gauss_legendre.TANGENTS_AT_ONCE", 7)
    assert GaussLegendre(0.1).start(system, state, 0.2).advance_with_tangents(0.2, units)[1] == pytest.approx(whole, abs=1e-14)


def test_the_equations_of_the_stages_have_their_jacobian_and_the_solver_solves_them() -> None:
    equation, grid, wave, scheme = SYSTEMS["mass matrix"]
    simulation = Simulation(equation, grid, [wave], 1.0, scheme)
    stages = Stages(simulation.discretize(), tableau(4))
    stages.at(0.0, simulation.initial_state(), 0.1)
    guess = 0.1 * random_state(2, 2, 24)
    matrix = difference_jacobian(stages.ring, guess)
    dense = np.kron(np.eye(2), np.zeros((24, 24)))
    for column in range(48):
        unit = np.zeros(48)
        unit[column] = 1
        out = np.empty((2, 24))
        stages.ring.apply_mass(unit.reshape(2, 24), out)
        dense[:, column] = out.ravel()
    order = stages.ring.order
    expected = dense[np.ix_(order, order)] - 0.1 * matrix
    solver = newton_matrix(stages.ring)
    assert solver.factor(0.0, guess, 0.1)
    residual = random_state(4, 2, 24)
    found = solver.solve(0.0, guess, residual)
    assert expected @ stages.ring.fold(found) == pytest.approx(stages.ring.fold(residual), abs=1e-6)


def test_a_scheme_without_a_band_is_solved_with_by_gmres() -> None:
    """W = sqrt(2 + cos(x - 2 t)) is exact for n = 3."""
    grid = Grid(2 * np.pi, 16)
    start = Samples(np.sqrt(2 + np.cos(grid.coordinates)))
    simulation = Simulation(GranularCompacton(3), grid, [start], 1, FourierScheme(), 2, GaussLegendre(0.01))
    final = run(simulation).W.values[-1]
    assert relative_error(final, np.sqrt(2 + np.cos(grid.coordinates - 2))) < 1e-5
    coarse = run(replace(simulation, integrator=GaussLegendre(0.02))).W.values[-1]
    assert 1e-12 < relative_error(coarse, final) < 1e-3


def test_an_interval_that_is_no_multiple_is_cut_into_equal_steps() -> None:
    times: list[float] = []
    integration = GaussLegendre(0.3).start(ring(), np.ones((1, 20)), 1.0)
    integration.advance(1.0, times.append)
    assert integration.counters.steps == 4
    assert times == pytest.approx([0.25, 0.5, 0.75, 1.0])
    assert integration.advance(1.0) == pytest.approx(np.ones((1, 20)))
    assert integration.counters.steps == 4


def test_the_matrix_is_kept_from_step_to_step() -> None:
    integration = GaussLegendre(0.1).start(ring(), random_state(1, 1, 20), 2.0)
    for t in (0.7, 1.3, 2.0):
        integration.advance(t)
    assert integration.counters.steps == 20
    assert integration.counters.jacobians == 1
    assert integration.counters.evaluations >= 2 * 20


def test_a_step_that_does_not_converge_says_so_and_brings_what_there_is() -> None:
    simulation = one_compacton(n=2, size=300, second_difference="nearest", viscosity=0, t_end=50, frames=2)
    with pytest.raises(IntegrationError, match=r"did not converge at t = .*; choose a smaller integrator\.step") as failure:
        run(replace(simulation, integrator=GaussLegendre(50)))
    assert failure.value.dataset is not None
    assert failure.value.dataset.attrs["status"].startswith("failed at t = ")


def test_it_stands_in_json_and_repeats_itself() -> None:
    simulation = replace(one_compacton(size=60, t_end=0.5), integrator=GaussLegendre(0.1, 6))
    again = Simulation.from_json(simulation.to_json())
    assert again == simulation
    assert np.array_equal(run(again).W.values, run(simulation).W.values)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"step": 0}, "step = 0 must be positive"),
        ({"step": -1}, "step = -1 must be positive"),
        ({"order": 5}, "order = 5 must be one of 4, 6"),
    ],
)
def test_bad_settings_are_named(fields: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        GaussLegendre(**fields)


def test_a_step_of_many_iterations_asks_for_a_new_matrix() -> None:
    """The Jacobian is said to be zero, so that each iteration divides the error by the same factor."""
    seen = set()
    for rate in np.geomspace(1e-3, 0.1, 20):
        integration = GaussLegendre(step=1.0).start(decaying(float(rate)), np.ones((1, 4)), 2.0)
        integration.advance(1.0)
        before, iterations = integration.counters.jacobians, integration.counters.evaluations // 2
        integration.advance(2.0)
        seen.add(iterations)
        assert integration.counters.jacobians - before == (iterations > 8)
    assert {8, 9} <= seen


def decaying(rate: float) -> SemiDiscretization:
    """y' = -rate y, with a Jacobian that is wrong."""

    def rhs(t: float, state: Array, out: Array) -> None:
        out[:] = -rate * state

    def jacobian(t: float, state: Array, out: Array) -> None:
        out[:] = 0

    return SemiDiscretization(size=4, components=1, reach=1, rhs=rhs, jacobian=jacobian, invariants=lambda state: {})
