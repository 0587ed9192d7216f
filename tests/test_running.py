from __future__ import annotations

import os
import signal
import threading
import time
from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from mol_compactons import (
    ConservativeScheme,
    GaussLegendre,
    GranularChain,
    InputError,
    IntegrationError,
    Lattice,
    Midpoint,
    PowerContact,
    Rosenbrock,
    Simulation,
    SolitaryWave,
    Symplectic,
    run,
)
from mol_compactons.analysis.drift import drift
from mol_compactons.integrators import CVODE, IDA, Integrator
from mol_compactons.integrators.base import no_report
from mol_compactons.runtime.signals import stopping_on_signals
from tests.systems import one_compacton


def test_a_run_in_memory_and_one_on_disk_are_the_same(tmp_path: Path) -> None:
    simulation = one_compacton()
    memory = run(simulation)
    with run(simulation, tmp_path / "result.nc") as disk:
        xr.testing.assert_equal(memory, disk.load())
        assert set(memory.attrs) == set(disk.attrs)


def test_a_result_is_a_scenario_and_repeats_itself_bit_for_bit(tmp_path: Path) -> None:
    with run(one_compacton(), tmp_path / "first.nc") as first:
        again = run(Simulation.from_json(first.attrs["simulation"]))
        xr.testing.assert_identical(again.drop_attrs(), first.load().drop_attrs())


@pytest.mark.parametrize("integrator", [IDA(), CVODE(), Rosenbrock(), Midpoint(step=0.05)])
def test_the_report_begins_at_the_beginning_rises_and_ends_at_the_end(integrator: IDA | CVODE | Rosenbrock | Midpoint) -> None:
    times: list[float] = []
    run(replace(one_compacton(), scheme=ConservativeScheme(), integrator=integrator), report=times.append)
    assert times == sorted(times)
    assert (times[0], times[-1]) == (0.0, 1.0)


def test_methods_of_fixed_steps_report_on_their_way() -> None:
    """`Midpoint` each step, `Symplectic` each output time and, on a long chain, some times between."""
    times: list[float] = []
    run(one_compacton(integrator=Midpoint(step=0.1), frames=2), report=times.append)
    assert times == pytest.approx(np.linspace(0, 1, 11))
    for size, between in ((60, False), (100_000, True)):
        times.clear()
        chain, wave = GranularChain(PowerContact(1.5)), SolitaryWave(1, 20)
        run(Simulation(chain, Lattice(size), [wave], t_end=4, frames=3, integrator=Symplectic(0.02)), report=times.append)
        assert times == sorted(times)
        assert {0, 2, 4} <= set(times)
        assert any(0 < t < 2 for t in times) == between


@pytest.mark.parametrize("integrator", [IDA(), CVODE(), Rosenbrock()])
def test_methods_that_choose_their_steps_report_as_the_clock_goes(
    integrator: IDA | CVODE | Rosenbrock, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While it stands, the output times and no others; where it moves on at each look, every second step or so."""
    simulation = replace(one_compacton(), scheme=ConservativeScheme(), integrator=integrator)
    times: list[float] = []
    monkeypatch.setattr(time, "monotonic", lambda: 100.0)
    run(simulation, report=times.append)
    assert set(times) <= {0.0, 0.5, 1.0}
    times.clear()
    clock = count()
    monkeypatch.setattr(time, "monotonic", lambda: 0.15 * next(clock))
    steps = run(simulation, report=times.append).attrs["solver_steps"]
    assert len(set(times)) > steps / 4 > 3
    assert times == sorted(times)


@pytest.mark.parametrize("integrator", [IDA(), CVODE(linear_solver="sparse"), Rosenbrock(), Midpoint(step=0.1)])
def test_a_run_leaves_what_is_printed_and_the_open_files_as_they_were(
    integrator: Integrator, capfd: pytest.CaptureFixture[str]
) -> None:
    simulation = replace(one_compacton(), scheme=ConservativeScheme(), integrator=integrator)
    run(simulation)
    before = os.fstat(1), os.fstat(2), len(list(Path("/proc/self/fd").iterdir()))
    run(simulation)
    assert (os.fstat(1), os.fstat(2), len(list(Path("/proc/self/fd").iterdir()))) == before
    capfd.readouterr()
    os.write(2, b"heard")
    assert capfd.readouterr() == ("", "heard")


def test_the_first_frame_is_the_exact_wave_and_all_frames_have_their_times() -> None:
    simulation = one_compacton(t_end=0.7, frames=8)
    dataset = run(simulation)
    assert np.array_equal(dataset.W.values[0], simulation.initial_state()[0])
    assert np.array_equal(dataset.t.values, np.arange(8) / 10)
    assert np.array_equal(dataset.x.values, simulation.grid.coordinates)
    assert np.abs(dataset.W.values[-1] - dataset.W.values[0]).max() > 0.1


def test_what_is_conserved_is_counted_at_every_frame() -> None:
    """The numbers along t are those of the frames that stand beside them."""
    simulation = one_compacton(t_end=1, frames=5)
    dataset, system = run(simulation), simulation.discretize()
    for index in range(5):
        expected = system.invariants(dataset.W.values[index][None])
        assert set(expected) == {"mass", "momentum", "energy"}
        for name, value in expected.items():
            assert float(dataset[name][index]) == value


@pytest.mark.parametrize("integrator", [IDA(rtol=1e-6), Rosenbrock(rtol=1e-7), Midpoint(step=2e-3), GaussLegendre(step=0.02)])
def test_the_wave_has_moved_by_its_speed_times_the_time(integrator: Integrator) -> None:
    simulation = replace(one_compacton(size=300, t_end=2, viscosity=1e-4), integrator=integrator)
    final = run(simulation).W.values[-1]
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, 2)[0]
    assert np.linalg.norm(final - simulation.initial_state()[0]) > 0.5 * np.linalg.norm(exact)
    assert np.linalg.norm(final - exact) < 0.02 * np.linalg.norm(exact)


def test_a_failed_run_brings_the_frames_that_it_has() -> None:
    simulation = one_compacton(t_end=2, frames=21, integrator=IDA(max_steps=10))
    with pytest.raises(IntegrationError, match=r"raise integrator\.max_steps") as failure:
        run(simulation)
    assert failure.value.dataset.attrs["status"] == f"failed at t = {failure.value.t:.6g}: {failure.value}"
    assert failure.value.dataset.sizes["t"] >= 1
    assert np.array_equal(failure.value.dataset.W.values[0], simulation.initial_state()[0])


def test_another_thread_leaves_the_signals_alone() -> None:
    """As in a notebook or a server: handlers can be set in the main thread alone."""
    handlers: list[object] = []
    results: list[xr.Dataset] = []

    def work() -> None:
        with stopping_on_signals(no_report) as watch:
            handlers.extend([watch, signal.getsignal(signal.SIGTERM)])
        results.append(run(one_compacton()))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert handlers == [no_report, signal.getsignal(signal.SIGTERM)]
    xr.testing.assert_equal(results[0], run(one_compacton()))


def test_an_interrupted_run_in_memory_raises_what_interrupted_it() -> None:
    def interrupt(t: float) -> None:
        if t > 0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(one_compacton(), report=interrupt)


def test_the_cost_is_that_of_the_integrator() -> None:
    simulation = one_compacton(integrator=Midpoint(step=0.01))
    attributes = run(simulation).attrs
    assert attributes["solver_steps"] == 100
    assert attributes["status"] == "complete"
    assert attributes["cpu_seconds"] >= 0
    loose, tight = (run(one_compacton(integrator=IDA(rtol=rtol))).attrs["solver_steps"] for rtol in (1e-4, 1e-8))
    assert tight > 2 * loose


def test_two_runs_at_once_do_not_disturb_each_other() -> None:
    """Kernels have scratch arrays: each run has its own."""
    simulation = one_compacton(t_end=0.5, integrator=Rosenbrock())
    alone = run(simulation).W.values
    together: list[np.ndarray] = []

    def work(one: Simulation) -> None:
        together.append(run(one).W.values)

    threads = [threading.Thread(target=work, args=(simulation,)) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(alone, values) for values in together)
    assert len(together) == 2


@pytest.mark.parametrize("integrator", [Rosenbrock(), IDA()], ids=repr)
def test_numbers_more_often_than_fields_are_those_of_more_frames(integrator: Rosenbrock | IDA) -> None:
    """The fields are the same to the last bit, and the series that of a run with as many frames."""
    simulation = one_compacton(frames=4, integrator=integrator)
    often, many = run(replace(simulation, series_per_frame=5)), run(replace(simulation, frames=16))
    assert np.array_equal(often.W, run(simulation).W)
    assert often.t_series.values == pytest.approx(many.t.values, abs=1e-14)
    assert np.ptp(many.energy.values) > 1e-6
    for name in ("mass", "momentum", "energy"):
        assert often[f"{name}_series"].values == pytest.approx(many[name].values, abs=1e-9)
        assert often[f"{name}_series"].attrs["role"] == "conserved series"
    change, known = drift(often), drift(many)
    assert change.sizes["t"] == 16
    assert change.energy.values == pytest.approx(known.energy.values, abs=1e-9)
    part = drift(often.isel(t=slice(1, 3)))
    assert (part.sizes["t"], float(part.energy[0])) == (6, 0.0)


def test_how_often_numbers_are_recorded_is_refused_beyond_reason() -> None:
    for wrong in (0, 10**7):
        with pytest.raises(InputError, match="series_per_frame = "):
            replace(one_compacton(), series_per_frame=wrong)
