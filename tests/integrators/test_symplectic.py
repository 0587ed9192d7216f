from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import pytest

from mol_compactons import (
    CVODE,
    Compacton,
    CompactScheme,
    GranularChain,
    GranularCompacton,
    Grid,
    Impact,
    InputError,
    IntegrationError,
    Lattice,
    PowerContact,
    SolitaryWave,
    Symplectic,
    run,
)
from mol_compactons.analysis.drift import drift
from mol_compactons.integrators.symplectic import METHODS
from tests.chain.chains import ring, system_of
from tests.systems import Array, fitted_order, random_state


@pytest.mark.parametrize("n", [1.5, 3])
def test_cvode_and_the_splitting_agree(n: float) -> None:
    adams = CVODE(rtol=1e-10, atol=1e-12, method="Adams")
    pulse = [Compacton(speed=1, center=20)]
    final = run(ring(n, initial=pulse, integrator=adams)).R.values[-1]
    assert np.abs(final - run(ring(n, initial=pulse, integrator=Symplectic(step=0.02))).R.values[-1]).max() < 1e-7


@pytest.mark.parametrize("order", [2, 4, 6])
def test_the_splitting_has_its_order(order: Literal[2, 4, 6]) -> None:
    reference = run(ring(integrator=Symplectic(step=0.005, order=6), t_end=4)).R.values[-1]
    counts = [80, 160] if order < 6 else [16, 32]
    errors = [
        float(np.abs(run(ring(integrator=Symplectic(step=4 / count, order=order), t_end=4)).R.values[-1] - reference).max())
        for count in counts
    ]
    assert fitted_order(counts, errors) == pytest.approx(order, abs=0.4)


@pytest.mark.parametrize(
    "chain", [GranularChain(PowerContact(3)), GranularChain(PowerContact(1.5, kind="one_sided"), compression=1)]
)
def test_the_energy_error_stays_bounded_for_long(chain: GranularChain) -> None:
    """Over t = 10^4 the energy error of the last tenth is no larger than twice that of the first, or 1e-9."""
    wave = SolitaryWave(speed=1.6, center=10)
    simulation = ring(equation=chain, initial=[wave], t_end=10_000, frames=2001, integrator=Symplectic(step=0.05))
    errors = np.abs(drift(run(simulation)).energy)
    assert float(errors.max()) < 1e-5
    assert float(errors[-200:].max()) < 2 * float(errors[:200].max()) + 1e-9


def test_the_energy_error_of_a_hertz_chain_without_compression_wanders() -> None:
    """Ripples cross zero, where the force is not smooth: the error is no longer periodic, but wanders."""
    simulation = ring(1.5, t_end=10_000, frames=2001, integrator=Symplectic(step=0.02))
    errors = drift(run(simulation)).energy.values
    assert np.abs(errors).max() < 3e-5


def test_the_energy_error_of_a_hundred_collisions() -> None:
    """For n = 3 it is bounded too; for n = 3/2, where the force is not smooth at zero, it wanders, and falls with the step."""

    def worst(n: float, step: float) -> float:
        pulses = [Compacton(speed=1, center=10), Compacton(speed=0.6, center=30)]
        simulation = ring(n, initial=pulses, t_end=2000, frames=401, integrator=Symplectic(step=step))
        return float(np.abs(drift(run(simulation)).energy).max())

    assert worst(3, 0.05) < 1e-5
    coarse, fine = worst(1.5, 0.1), worst(1.5, 0.02)
    assert fine < 1e-5
    assert fine < 0.2 * coarse


def test_verlet_keeps_its_order_where_contacts_open() -> None:
    """A blow on a Hertz chain that parts: Verlet falls with the square of the step, and the fourth order with 5/2 at least."""

    def chain(order: Literal[2, 4, 6], step: float) -> Array:
        simulation = ring(
            equation=GranularChain(PowerContact(1.5, kind="one_sided"), form="displacements", ends="free"),
            grid=Lattice(12),
            initial=[Impact(velocity=1)],
            t_end=20,
            integrator=Symplectic(step=step, order=order),
        )
        return np.asarray(run(simulation).Q.values[-1])

    reference = chain(6, 1 / 1600)
    counts = [20, 40, 80, 160]
    verlet = [float(np.abs(chain(2, 1 / count) - reference).max()) for count in counts]
    fourth = [float(np.abs(chain(4, 1 / count) - reference).max()) for count in counts]
    assert fitted_order(counts, verlet) == pytest.approx(2, abs=0.2)
    assert fitted_order(counts, fourth) > 2.2
    assert fourth[-1] < 0.1 * verlet[-1]


def test_a_step_that_is_too_long_says_so() -> None:
    with pytest.raises(IntegrationError, match=r"integrator\.step = 5 is too long for the stiffness"):
        run(ring(initial=[Compacton(speed=3, center=20)], t_end=500, integrator=Symplectic(step=5)))


@pytest.mark.parametrize("order", list(METHODS))
def test_the_methods_are_symmetric_and_advance_by_one_step(order: int) -> None:
    kicks, drifts = METHODS[order]
    assert float(kicks.sum()) == pytest.approx(1, abs=1e-14)
    assert float(drifts.sum()) == pytest.approx(1, abs=1e-14)
    assert np.array_equal(kicks, kicks[::-1])
    assert np.array_equal(drifts, drifts[::-1])
    assert kicks.size == drifts.size + 1
    assert drifts.size == {2: 1, 4: 6, 6: 11}[order]


@pytest.mark.parametrize("order", [2, 4, 6])
def test_backwards_in_time_it_comes_home(order: Literal[2, 4, 6]) -> None:
    """A symmetric method with the rates reversed goes back the way that it came, to round-off."""
    system, state = system_of(GranularChain(PowerContact(3))), random_state(4, 2, 12)
    state[1] -= state[1].mean()
    there = Symplectic(0.05, order).start(system, state, 5.0).advance(5.0)
    assert np.abs(there - state).max() > 0.5
    turned = there * np.array([[1.0], [-1.0]])
    back = Symplectic(0.05, order).start(system, turned, 5.0).advance(5.0)
    assert np.abs(back * np.array([[1.0], [-1.0]]) - state).max() < 1e-9


def test_an_interval_that_is_no_multiple_is_cut_into_equal_steps() -> None:
    system, state = system_of(GranularChain(PowerContact(3))), np.zeros((2, 12))
    integration = Symplectic(step=0.3).start(system, state, 1.0)
    integration.advance(1.0)
    assert integration.counters.steps == 4
    integration.advance(1.6)
    assert integration.counters.steps == 6
    integration.advance(1.6)
    assert integration.counters.steps == 6


@pytest.mark.parametrize(
    ("attempt", "words"),
    [
        (lambda: Symplectic(step=0), "step = 0 must be positive"),
        (lambda: Symplectic(order=3), "order = 3 must be one of 2, 4, 6"),  # type: ignore[arg-type]
        (
            lambda: Symplectic().check_system(CompactScheme().discretize(GranularCompacton(2), Grid(10, 20))),
            "Symplectic is for a GranularChain",
        ),
    ],
)
def test_bad_input_is_named(attempt: Callable[[], Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        attempt()
