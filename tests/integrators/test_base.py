from __future__ import annotations

import inspect
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import InputError
from mol_compactons.integrators import (
    CVODE,
    IDA,
    Counters,
    GaussLegendre,
    Integration,
    Integrator,
    Midpoint,
    Report,
    Rosenbrock,
    Symplectic,
)
from mol_compactons.integrators.base import no_report, steps_between
from mol_compactons.semidiscrete import SemiDiscretization
from tests.systems import Array

OWN: tuple[type[Integrator], ...] = (CVODE, GaussLegendre, IDA, Midpoint, Rosenbrock, Symplectic)


@pytest.mark.parametrize("cls", OWN)
@given(tolerance=st.floats(1e-9, 1e-2))
def test_the_tolerance_that_is_set_is_the_one_that_is_had(cls: type[Integrator], tolerance: float) -> None:
    default = cls()
    changed = default.with_tolerance(tolerance)
    assert changed.own_tolerance == tolerance
    assert type(changed) is cls
    assert changed.with_tolerance(default.own_tolerance) == default


@pytest.mark.parametrize("cls", OWN)
def test_a_looser_tolerance_is_a_valid_one(cls: type[Integrator]) -> None:
    """A study loosens the tolerance by this factor to see what it does."""
    assert cls.coarsening > 1
    loose = cls().with_tolerance(cls().own_tolerance * cls.coarsening)
    assert loose.own_tolerance > cls().own_tolerance


@pytest.mark.parametrize("integrator", [CVODE(rtol=1e-3), IDA(rtol=1e-3)])
def test_what_takes_its_place_has_its_tolerance(integrator: Integrator) -> None:
    alternatives = integrator.alternatives()
    assert {other.own_tolerance for other in alternatives} == {1e-3}
    assert {type(other) for other in alternatives} == {CVODE, IDA}


@pytest.mark.parametrize("cls", [GaussLegendre, Midpoint, Symplectic])
@given(interval=st.floats(1e-3, 1e3), parts=st.floats(0.01, 1000))
def test_a_fixed_step_is_cut_to_fit_between_frames(cls: type[Integrator], interval: float, parts: float) -> None:
    """The step that is taken is no longer than the one asked for, divides the interval, and is taken as it is."""
    taken = cls().with_tolerance(interval / parts).taken(interval)
    assert taken <= max(interval / parts, interval / 1000) * (1 + 1e-8)
    count = interval / taken
    assert count == pytest.approx(round(count), abs=1e-6)
    assert round(count) - 1 < parts * (1 + 1e-8)
    assert cls().with_tolerance(taken).taken(interval) == taken


def test_a_tolerance_is_taken_as_it_is() -> None:
    assert [cls().with_tolerance(1e-4).taken(0.3) for cls in (CVODE, IDA, Rosenbrock)] == [1e-4] * 3


def test_no_time_needs_no_step_and_round_off_no_more() -> None:
    assert [steps_between(1.0, end, 0.1) for end in (1.0, 1.05, 1.1, 1.1 + 1e-12, 1.2, 2.0)] == [0, 1, 1, 1, 2, 10]


@dataclass(frozen=True)
class Euler(Integrator):
    """The least that an integrator is: y + h f, whose accuracy is a relative tolerance that it does not keep."""

    rtol: float = 0.1

    def start(self, system: SemiDiscretization, state: Array, t_end: float) -> EulerIntegration:
        return EulerIntegration(system, state)


class EulerIntegration:
    def __init__(self, system: SemiDiscretization, state: Array) -> None:
        self.counters = Counters()
        self._system, self._state, self._t = system, state, 0.0

    def advance(self, t: float, report: Report = no_report) -> Array:
        self._state = self._state + (t - self._t) * self._system.rate(self._t, self._state)
        self._t = t
        self.counters.steps += 1
        report(t)
        return self._state


def decay() -> SemiDiscretization:
    """y' = -y on five cells."""

    def rhs(t: float, state: Array, out: Array) -> None:
        out[:] = -state

    return SemiDiscretization(size=5, components=1, reach=1, rhs=rhs, invariants=lambda state: {})


def test_an_integrator_of_ones_own_needs_to_say_how_it_starts_and_no_more() -> None:
    times: list[float] = []
    integration: Integration = Euler().start(decay(), np.ones((1, 5)), 1.0)
    assert integration.advance(0.25, times.append)[0] == pytest.approx(np.full(5, 0.75))
    assert integration.advance(0.5, times.append)[0] == pytest.approx(np.full(5, 0.75**2))
    assert (times, integration.counters.steps) == ([0.25, 0.5], 2)
    assert Euler().with_tolerance(0.01) == Euler(0.01)
    assert Euler().alternatives() == ()
    Euler().check_system(decay())
    with pytest.raises(TypeError, match="abstract"):
        Integrator()  # type: ignore[abstract]


@pytest.mark.parametrize("cls", [CVODE, GaussLegendre, IDA, Midpoint, Rosenbrock])
def test_each_reaches_the_exact_decay_within_its_tolerance(cls: type[Integrator]) -> None:
    integrator = cls().with_tolerance({Midpoint: 1e-3, GaussLegendre: 0.1}.get(cls, 1e-6))
    integration = integrator.start(decay(), np.ones((1, 5)), 2.0)
    for t in (0.5, 2.0):
        assert integration.advance(t)[0] == pytest.approx(np.full(5, np.exp(-t)), rel=2e-4)
    assert integration.counters.steps > 5
    assert integration.counters.evaluations >= integration.counters.steps


def test_counters_begin_at_nothing_and_are_each_runs_own() -> None:
    first, second = Counters(), Counters()
    first.steps += 3
    assert second == Counters(0, 0, 0, 0, 0, "")
    assert list(inspect.signature(Counters).parameters) == [
        "steps",
        "evaluations",
        "jacobians",
        "failures",
        "warnings",
        "first_warning",
    ]


def test_a_tolerance_out_of_range_is_refused_by_the_method_that_gets_it() -> None:
    with pytest.raises(InputError, match="must lie between"):
        IDA().with_tolerance(1.0)
    with pytest.raises(InputError, match="must be positive"):
        Symplectic().with_tolerance(-1.0)
