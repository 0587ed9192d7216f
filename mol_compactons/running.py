"""Taking a simulation through time into a recorder."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import IntegrationError, require
from mol_compactons.integrators.base import Report, no_report
from mol_compactons.results.recorder import MemoryRecorder, Recorder
from mol_compactons.results.schema import cost_attributes, layout_of
from mol_compactons.simulation import Simulation

if TYPE_CHECKING:
    import xarray as xr


def run(
    simulation: Simulation,
    path: str | Path | None = None,
    *,
    overwrite: bool = False,
    report: Report = no_report,
) -> xr.Dataset:
    """Integrate a simulation and return its frames as a labelled Dataset.

    Parameters
    ----------
    simulation : Simulation
        What to run.
    path : str or Path, optional
        A NetCDF file. Frames stream into it while the run goes on, and the Dataset returned reads from it lazily. Without
        a path the frames stay in memory.
    overwrite : bool
        Whether a file that exists may be replaced.
    report : callable, optional
        Called now and then with the time reached.

    Returns
    -------
    xarray.Dataset
        The components (t, x), the conserved quantities (t), and in its attributes the simulation, the status and the
        cost.

    Raises
    ------
    InputError
        If the file cannot be written, or the integrator cannot take the system; nothing is written then.
    IntegrationError
        If the integrator gives up. The frames up to there are in the file, or in the error's attribute `dataset`.

    Examples
    --------
    >>> from mol_compactons import Compacton, GranularCompacton, Grid
    >>> waves = [Compacton(speed=1, center=5.5)]
    >>> simulation = Simulation(GranularCompacton(n=3), Grid(length=30, size=120), waves, t_end=1, frames=3)
    >>> dataset = run(simulation)
    >>> dataset.W.dims, dataset.sizes["x"], dataset.attrs["status"]
    (('t', 'x'), 120, 'complete')
    """
    from mol_compactons.results.netcdf import NetCDFRecorder

    system = simulation.discretize()
    state = simulation.initial_state()
    integration = simulation.integrator.start(system, state, simulation.t_end)
    names = list(_numbers(system.invariants(state))), list(_numbers(system.diagnostics(state)))
    layout = layout_of(simulation, *names, system.magnitudes(state))
    recorder: Recorder = MemoryRecorder(layout) if path is None else NetCDFRecorder(layout, Path(path), overwrite)

    def record(t: float, state: NDArray[np.float64]) -> None:
        recorder.append(t, state, _numbers(system.invariants(state) | system.diagnostics(state)))

    started = time.process_time()
    status, failure = "interrupted at t = 0", None
    try:
        record(0.0, state)
        with stopping_on_signals(report) as watch:
            watch(0.0)
            for t in simulation.times[1:]:
                state = integration.advance(t, watch)
                record(t, state)
                status = f"interrupted at t = {t:.6g}"
        status = "complete"
    except IntegrationError as error:
        status, failure = f"failed at t = {error.t:.6g}: {error}", error
    finally:
        recorder.close(cost_attributes(status, integration.counters, time.process_time() - started))
    if failure:
        raise IntegrationError(str(failure), failure.t, recorder.dataset())
    return recorder.dataset()


def _numbers(values: dict[str, float]) -> dict[str, float]:
    """What an equation, perhaps one of the user's own, gives along t, as numbers."""
    for name, value in values.items():
        require(np.ndim(value) == 0, f"{name} is an array of shape {np.shape(value)} along t; return one number for it.")
    return {name: float(value) for name, value in values.items()}


@contextmanager
def stopping_on_signals(report: Report) -> Iterator[Report]:
    """A report that raises KeyboardInterrupt after SIGINT or SIGTERM, between two steps and never inside the solver."""
    if threading.current_thread() is not threading.main_thread():
        yield report
        return
    caught: list[int] = []
    before = {number: signal.signal(number, lambda n, _: caught.append(n)) for number in (signal.SIGINT, signal.SIGTERM)}

    def watch(t: float) -> None:
        report(t)
        if caught:
            raise KeyboardInterrupt

    try:
        yield watch
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
