from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mol_compactons import ConservativeScheme, GranularCompacton, Grid
from mol_compactons.integrators import CVODE, IDA
from tests.systems import Array, one_compacton, relative_error

EQUATION, RING = GranularCompacton(3), Grid(2 * np.pi, 40)
SYSTEM = ConservativeScheme(order=4).discretize(EQUATION, RING)


def wave(t: float) -> Array:
    """An exact one of n = 3."""
    return np.asarray(np.sqrt(2 + np.cos(RING.coordinates - 2 * t))[None])


@pytest.mark.parametrize("integrator", [IDA(rtol=1e-7), CVODE(rtol=1e-7), IDA(rtol=1e-7, linear_solver="sparse")], ids=repr)
def test_it_may_begin_at_any_time(integrator: IDA | CVODE) -> None:
    """From what another one remembered: the clock and the wave go on."""
    start = wave(0)
    first = integrator.start(SYSTEM, start, 3)
    first.advance(1.0)
    second = integrator.resume(SYSTEM, first.memory(), 3)
    times: list[float] = []
    end = second.advance(2.0, times.append)
    assert times[-1] == 2.0
    assert min(times) > 1
    assert relative_error(end, integrator.start(SYSTEM, start, 3).advance(2.0)) < 1e-5
    assert relative_error(end, start) > 0.01


def test_between_two_output_times_it_remembers_its_last_step() -> None:
    integration = IDA().start(SYSTEM, wave(0), 1)
    seen: list[tuple[float, float]] = []

    def look(t: float) -> None:
        memory = integration.memory()
        seen.append((t, float(memory["t"])))
        exact = wave(float(memory["t"]))
        assert relative_error(memory["state"], exact) < 1e-3

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("mol_compactons.integrators.sundials_integration.REPORT_INTERVAL", 1e-4)
        integration.advance(1.0, look)
    assert len(seen) > 3
    assert all(0 <= remembered <= t for t, remembered in seen)
    assert seen[-2][1] > 0
    assert float(integration.memory()["t"]) == 1.0


def test_the_steps_do_not_depend_on_where_the_run_is_to_end() -> None:
    simulation = replace(one_compacton(), scheme=ConservativeScheme(4, grid_viscosity=0.03))
    for integrator in (IDA(), CVODE()):
        states = [
            integrator.start(simulation.discretize(), simulation.initial_state(), t_end).advance(0.1) for t_end in (0.2, 50.0)
        ]
        assert np.array_equal(states[0], states[1])
