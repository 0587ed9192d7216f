"""Orbits that close up to a shift: linear systems whose monodromy matrix is known, and waves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from mol_compactons import (
    Compacton,
    ConservativeScheme,
    FourierScheme,
    GranularCompacton,
    Grid,
    InputError,
    PadeScheme,
    RosenauHyman,
    Simulation,
)
from mol_compactons.analysis.orbits import Period, advance, advance_with_derivative, check_system, close
from mol_compactons.semidiscrete import SemiDiscretization
from tests.systems import Array, random_state, relative_error


def advection(size: int, speed: float, decay: float = 0.0) -> SemiDiscretization:
    """y_j' = -(speed / 2) (y_(j+1) - y_(j-1)) - decay y_j, h = 1."""

    def rhs(t: float, state: Array, out: Array) -> None:
        out[:] = -speed / 2 * (np.roll(state, -1, axis=1) - np.roll(state, 1, axis=1)) - decay * state

    def jacobian(t: float, state: Array, out: Array) -> None:
        out[:] = 0
        out[0, 0, 2], out[0, 0, 0], out[0, 0, 1] = -speed / 2, speed / 2, -decay

    return SemiDiscretization(size=size, components=1, reach=1, rhs=rhs, jacobian=jacobian, invariants=lambda state: {})


def turning(size: int) -> SemiDiscretization:
    """q' = p (1 + q^2 + p^2)^a in each cell, and p' alike: every orbit is a circle, its frequency 1 + its square."""

    def rhs(t: float, state: Array, out: Array) -> None:
        rate = 1 + state[0] ** 2 + state[1] ** 2
        out[0], out[1] = rate * state[1], -rate * state[0]

    return SemiDiscretization(size=size, components=2, reach=0, rhs=rhs, invariants=lambda state: {})


def gauss(order: int) -> Callable[[complex], complex]:
    """The factor of one step of Gauss-Legendre collocation on y' = z y: the diagonal Pade approximant of exp."""
    return (
        (lambda z: (1 + z / 2 + z * z / 12) / (1 - z / 2 + z * z / 12))
        if order == 4
        else (lambda z: (1 + z / 2 + z * z / 10 + z**3 / 120) / (1 - z / 2 + z * z / 10 - z**3 / 120))
    )


@pytest.mark.parametrize("order", [4, 6])
@pytest.mark.parametrize("shift", [0, 1, -2])
def test_the_monodromy_matrix_of_a_linear_system_is_the_one_known(order: Any, shift: int) -> None:
    """Every Fourier mode is an eigenvector, with the Pade approximant's power times the shift as its multiplier."""
    size, period = 12, Period(1.7, shift, 3, order)
    theta = 2 * np.pi * np.fft.fftfreq(size)
    state = np.random.default_rng(0).normal(size=(1, size))
    after, matrix = advance_with_derivative(advection(size, 0.8, 0.1), state, period)
    rates = (-0.8j * np.sin(theta) - 0.1) * 1.7 / 3
    multipliers = np.array([gauss(order)(z) ** 3 for z in rates]) * np.exp(1j * theta * shift)
    modes = np.exp(1j * np.outer(np.arange(size), theta))
    assert np.abs(matrix @ modes - modes * multipliers).max() < 1e-13
    assert matrix @ state[0] == pytest.approx(after[0], abs=1e-13)
    assert np.array_equal(advance(advection(size, 0.8, 0.1), state, period), after)


def test_an_orbit_of_a_linear_system_is_found_in_one_correction() -> None:
    """With a decay the only one is none at all, and what does not decay is a constant."""
    guess = 1 + 0.3 * np.cos(2 * np.pi * np.arange(12) / 12)[None]
    found = close(advection(12, 0.8), guess, Period(1.0, 1))
    assert found.state == pytest.approx(np.ones((1, 12)), abs=1e-9)
    assert found.correction == pytest.approx(0.3 / 1.3, rel=1e-6)
    assert found.residual < 1e-13


def test_the_orbit_of_a_family_that_is_nearest_is_taken() -> None:
    """Of circles with the frequency 1 + r^2 that of the period 2 pi / 1.25 has r = 1/2, wherever it begins."""
    guess = np.array([[0.52 * np.cos(0.3)], [0.52 * np.sin(0.3)]]) * np.ones((1, 3))
    found = close(turning(3), guess, Period(2 * np.pi / 1.25, 0, 200, 6))
    assert np.hypot(*found.state) == pytest.approx(np.full(3, 0.5), abs=1e-6)
    assert np.arctan2(found.state[1], found.state[0]) == pytest.approx(np.full(3, 0.3), abs=0.1)
    # The derivative of the turn: the phase moves with the radius, by 2 r T in each turn.
    shear = found.monodromy[np.ix_([0, 3], [0, 3])]
    assert np.linalg.det(shear) == pytest.approx(1, abs=1e-9)
    assert np.trace(shear) == pytest.approx(2, abs=1e-6)
    assert np.linalg.norm(shear - np.eye(2), 2) == pytest.approx(2 * 0.5 * 2 * np.pi / 1.25 * 0.5, rel=1e-3)


WAVES: list[tuple[Any, Any, Any]] = [
    (GranularCompacton(2), Grid(20, 80), ConservativeScheme(2)),
    (GranularCompacton(3), Grid(10, 60), ConservativeScheme(4)),
    (RosenauHyman(2, 2, absolute=True), Grid(16, 64), PadeScheme("de_frutos")),
]


@pytest.mark.parametrize(("equation", "grid", "scheme"), WAVES)
def test_a_compacton_on_the_grid_repeats_itself_and_is_near_the_exact_one(equation: Any, grid: Grid, scheme: Any) -> None:
    simulation = Simulation(equation, grid, [Compacton(1, grid.length / 2)], 1.0, scheme)
    system, guess, period = simulation.discretize(), simulation.initial_state(), Period(grid.spacing)
    found = close(system, guess, period)
    assert found.residual < 1e-12 > found.uncertainty * 1e-3
    missed = np.abs(advance(system, found.state, period) - found.state).max() / np.abs(guess).max()
    assert missed == pytest.approx(found.residual, rel=0.5, abs=1e-14)
    before = np.abs(advance(system, guess, period) - guess).max() / np.abs(guess).max()
    assert before > 1e4 * missed
    assert 1e-6 < found.correction < 0.1
    assert found.correction == pytest.approx(np.abs(found.state - guess).max() / np.abs(guess).max())
    rate = system.rate(0.0, found.state).ravel()
    # The direction of the orbit itself is carried along, up to the error of the steps.
    assert relative_error(found.monodromy @ rate, rate) < 1e-2


def test_after_many_cells_it_has_travelled_as_far() -> None:
    equation, grid, scheme = WAVES[0]
    simulation = Simulation(equation, grid, [Compacton(1, 10)], 1.0, scheme)
    system, period = simulation.discretize(), Period(grid.spacing)
    found = close(system, simulation.initial_state(), period)
    after = period.integrator.start(system, found.state, 5.0).advance(5.0)
    assert relative_error(after, found.state) > 0.5
    assert relative_error(np.roll(after, -20, axis=1), found.state) < 1e-10


def test_what_is_no_orbit_is_said() -> None:
    equation, grid, scheme = WAVES[0]
    system = scheme.discretize(equation, grid)
    with pytest.raises(InputError, match=r"No orbit was found near the guess: it misses itself by .* of its size; choose"):
        close(system, 0.1 * random_state(1, 1, 80), Period(grid.spacing))
    with pytest.raises(InputError, match="A state of zeros is no guess of an orbit"):
        close(system, np.zeros((1, 80)), Period(grid.spacing))


@pytest.mark.parametrize(("missed", "closed"), [(0.7e-9, True), (1.5e-9, False)])
def test_an_orbit_closes_to_a_thousand_millionth_of_its_size(missed: float, closed: bool) -> None:
    """A state of the size 3 that drifts as a whole, which no correction mends."""

    def rhs(t: float, state: Array, out: Array) -> None:
        out[:] = 3 * missed

    drifting = SemiDiscretization(size=4, components=1, reach=0, rhs=rhs, invariants=lambda state: {})
    state = np.array([[3.0, 1.0, -2.0, 0.5]])
    if closed:
        assert close(drifting, state, Period(1.0, 0, 2)).residual == pytest.approx(missed, rel=1e-5)
    else:
        with pytest.raises(InputError, match=r"it misses itself by 1\.5e-09 of its size"):
            close(drifting, state, Period(1.0, 0, 2))


def test_of_two_unequal_waves_the_nearest_orbit_is_one_of_two_equal_ones() -> None:
    equation, grid, scheme = WAVES[0]
    two = Simulation(equation, grid, [Compacton(1, 5), Compacton(0.8, 15)], 1.0, scheme)
    found = close(two.discretize(), two.initial_state(), Period(grid.spacing))
    heights = found.state[0, :40].max(), found.state[0, 40:].max()
    assert heights[0] == pytest.approx(heights[1], rel=1e-9)


def test_a_step_that_does_not_converge_is_said() -> None:
    equation, grid, scheme = WAVES[0]
    one = Simulation(equation, grid, [Compacton(1, 10)], 1.0, scheme)
    with pytest.raises(InputError, match="No orbit was found near the guess: Newton's method"):
        close(one.discretize(), one.initial_state(), Period(200.0, steps=1))


def test_systems_that_have_no_such_map_are_refused() -> None:
    fourier = FourierScheme().discretize(GranularCompacton(2), Grid(10, 20))
    with pytest.raises(InputError, match="An orbit needs a banded Jacobian"):
        check_system(fourier)
    wave = advection(5000, 1)
    with pytest.raises(InputError, match="5000 unknowns is too large; choose a grid of at most 4000 cells"):
        check_system(wave)
    driven = SemiDiscretization(
        size=5, components=1, reach=1, rhs=lambda t, state, out: None, invariants=lambda state: {}, explicit_time=True
    )
    with pytest.raises(InputError, match="depends on t"):
        check_system(driven)
    check_system(advection(12, 1))


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"time": 0}, "time = 0 must be positive"),
        ({"time": 1, "steps": 0}, "steps = 0 must lie between 1"),
        ({"time": 1, "order": 2}, "order = 2 must be one of 4, 6"),
    ],
)
def test_bad_periods_are_named(fields: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Period(**fields)


def test_a_period_has_its_steps_and_twice_as_many() -> None:
    period = Period(2.0, 1, 8, 6)
    assert (period.integrator.step, period.integrator.order) == (0.25, 6)
    assert period.halved == Period(2.0, 1, 16, 6)
