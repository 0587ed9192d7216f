"""Several threads at work on one semi-discretisation, or one simulation, get what one gets, to the last bit."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest

from mol_compactons import (
    CVODE,
    IDA,
    CentralScheme,
    Compacton,
    CompactScheme,
    ConservativeScheme,
    CustomEquation,
    FourierScheme,
    GaussLegendre,
    GranularChain,
    GranularCompacton,
    Grid,
    Lattice,
    Midpoint,
    NearestNeighbours,
    Nesterenko,
    PadeScheme,
    PowerContact,
    RosenauHyman,
    Rosenbrock,
    Simulation,
    Symplectic,
    run,
)
from mol_compactons.chain.law import ContactLaw
from mol_compactons.integrators import Integrator
from mol_compactons.open_set import loaded
from mol_compactons.schemes import Scheme
from mol_compactons.semidiscrete import SemiDiscretization
from tests.systems import Array

THREADS = 4
SIZE = 40


@dataclass(frozen=True)
class CubicContact(ContactLaw):
    """A law without a compiled form."""

    def force(self, stress: Array, factor: Array) -> Array:
        return factor * stress**3

    def stiffness(self, stress: Array, factor: Array) -> Array:
        return 3 * factor * stress**2

    def energy(self, stress: Array, factor: Array) -> Array:
        return factor * stress**4 / 4


FORMULA = CustomEquation(flux="u**3 + u*d2(u**2)")
DRIVEN = CustomEquation(flux="u**3 + u*d2(u**2)", source="0.1*sin(t)*u - 0.2*d1(u)")

SYSTEMS: dict[str, tuple[Scheme, Any]] = {
    "compact": (CompactScheme(viscosity=1e-3), GranularCompacton(3)),
    "compact, two-way": (CompactScheme("five_point"), Nesterenko(n=1.5)),
    "compact, of a formula": (CompactScheme(), FORMULA),
    "compact, with a source": (CompactScheme(), DRIVEN),
    "conservative": (ConservativeScheme(6, viscosity=1e-3), GranularCompacton(1.5)),
    "conservative, K(2, 2)": (ConservativeScheme(4), RosenauHyman(2, 2)),
    "Pade": (PadeScheme("pade_8"), RosenauHyman(3, 3)),
    "central": (CentralScheme(4), DRIVEN),
    "Fourier": (FourierScheme(), GranularCompacton(2)),
    "chain in stresses": (NearestNeighbours(), GranularChain(PowerContact(1.5))),
    "chain in displacements": (NearestNeighbours(), GranularChain(PowerContact(2), form="displacements", ends="fixed")),
    "chain of a law of one's own": (NearestNeighbours(), GranularChain(CubicContact())),
}


def system_of(name: str) -> SemiDiscretization:
    scheme, equation = SYSTEMS[name]
    return scheme.discretize(equation, Lattice(SIZE) if isinstance(equation, GranularChain) else Grid(20, SIZE))


@pytest.fixture
def _restless() -> Iterator[None]:
    """Threads take turns as often as they can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


def at_once(calls: list[Callable[[], Any]]) -> list[Any]:
    """What calls return that are made in as many threads; the first failure is raised."""
    results: list[Any] = [None] * len(calls)
    barrier = threading.Barrier(len(calls))

    def work(index: int) -> None:
        barrier.wait()
        try:
            results[index] = calls[index]()
        except Exception as error:
            results[index] = error

    threads = [threading.Thread(target=work, args=(index,)) for index in range(len(calls))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for result in results:
        if isinstance(result, Exception):
            raise result
    return results


def test_no_scheme_and_no_integrator_is_left_out_here() -> None:
    for base, those in ((Scheme, [scheme for scheme, _ in SYSTEMS.values()]), (Integrator, [one for _, one in RUNS])):
        own = {cls for cls in loaded(base).values() if cls.__module__.startswith("mol_compactons.")}
        assert own == {type(one) for one in those}


def everything(system: SemiDiscretization, t: float, state: Array) -> list[Array]:
    """What a semi-discretisation computes at a state."""
    rate, jacobian = system.rate(t, state), np.empty_like(system.mass_diagonals)
    system.jacobian(t, state, jacobian)
    found = [rate, jacobian, np.array([*system.invariants(state).values(), *system.diagnostics(state).values()])]
    if system.jacobian_vector is not None:
        product = np.empty_like(state)
        system.jacobian_vector(t, state, np.roll(state, 3, axis=1), product)
        found.append(product)
    if system.split_steps is not None:
        moved = state.copy()
        system.split_steps(moved, 0.01, 2, np.array([1.0]), np.array([0.5, 0.5]))
        found.append(moved)
    return found


@pytest.mark.usefixtures("_restless")
@pytest.mark.parametrize("name", SYSTEMS)
def test_a_semi_discretisation_may_be_shared(name: str) -> None:
    system = system_of(name)
    states = [1.5 + np.random.default_rng(seed).uniform(-1, 1, (system.components, SIZE)) for seed in range(THREADS)]
    expected = [everything(system, 0.3 * index, state) for index, state in enumerate(states)]

    def wrong(index: int) -> int:
        found = [everything(system, 0.3 * index, states[index]) for _ in range(150)]
        return sum(not np.array_equal(a, b) for one in found for a, b in zip(one, expected[index], strict=True))

    assert at_once([lambda index=index: wrong(index) for index in range(THREADS)]) == [0] * THREADS  # type: ignore[misc]


RUNS: tuple[tuple[str, Integrator], ...] = (
    ("compact", IDA()),
    ("compact, with a source", IDA(linear_solver="sparse")),
    ("conservative", CVODE()),
    ("conservative, K(2, 2)", CVODE(linear_solver="sparse")),
    ("Fourier", CVODE(linear_solver="krylov")),
    ("chain in stresses", CVODE(method="Adams")),
    ("compact, two-way", Rosenbrock()),
    ("compact, of a formula", Midpoint(step=0.05)),
    ("Fourier", Midpoint(step=0.1)),
    ("Pade", GaussLegendre(step=0.1)),
    ("chain in displacements", Symplectic()),
)


@cache
def wave(components: int, height: float) -> Array:
    """A smooth wave on a background, the other component at rest."""
    x = np.arange(SIZE) * 2 * np.pi / SIZE
    return np.array([height * (1.2 + np.cos(x)), 0 * x])[:components]


@pytest.mark.usefixtures("_restless")
@pytest.mark.parametrize("rounds", [1, pytest.param(50, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("name", "integrator"), RUNS, ids=lambda one: one if isinstance(one, str) else type(one).__name__)
def test_integrations_may_share_a_semi_discretisation(name: str, integrator: Integrator, rounds: int) -> None:
    system = system_of(name)

    def final(height: float) -> Array:
        integration = integrator.start(system, wave(system.components, height), 0.2)
        integration.advance(0.1)
        return np.asarray(integration.advance(0.2))

    heights = [0.5 + 0.1 * index for index in range(THREADS)]
    expected = [final(height) for height in heights]
    for _ in range(rounds):
        found = at_once([lambda height=height: final(height) for height in heights])  # type: ignore[misc]
        assert [np.array_equal(one, other) for one, other in zip(found, expected, strict=True)] == [True] * THREADS


@pytest.mark.usefixtures("_restless")
def test_a_simulation_may_be_run_in_several_threads() -> None:
    grid, waves = Grid(30, 90), [Compacton(1, 10)]
    simulation = Simulation(GranularCompacton(3), grid, waves, t_end=0.4, frames=3, scheme=CompactScheme(), integrator=IDA())
    expected = run(simulation)
    for found in at_once([lambda: run(simulation)] * THREADS):
        assert found.drop_attrs().identical(expected.drop_attrs())
        assert found.attrs["solver_warnings"] == expected.attrs["solver_warnings"]
