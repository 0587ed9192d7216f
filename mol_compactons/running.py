"""Taking a simulation through time into a recorder, from its beginning or from where an earlier run was."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.course import Course, Observe, numbers_of, view_of
from mol_compactons.errors import InputError, require, shown
from mol_compactons.integrators.base import Report, no_report
from mol_compactons.progress import TIME, show_nobody, showing_progress
from mol_compactons.results import checkpoint
from mol_compactons.results.places import check_target
from mol_compactons.results.recorder import MemoryRecorder, Recorder
from mol_compactons.results.schema import FRAMES_BEFORE, Layout, layout_of, source
from mol_compactons.runtime.signals import stopping_on_signals
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.simulation import Simulation
from mol_compactons.stop_rules import StopRule

if TYPE_CHECKING:
    import xarray as xr

    from mol_compactons.results.resuming import Earlier

Array = NDArray[np.float64]


def run(
    simulation: Simulation,
    path: str | Path | None = None,
    *,
    overwrite: bool = False,
    resume: bool = False,
    keep_checkpoints: bool = False,
    stop: Sequence[StopRule] = (),
    observe: Observe | None = None,
    report: Report = no_report,
    progress: bool | None = None,
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
        Whether a file that exists may be replaced. It stays until the first new frames are safe.
    resume : bool
        Whether to go on from the file, if there is one: from its last checkpoint, or from its last frame. A file that is
        complete goes on to the `t_end` that is asked for, with frames as dense; if nothing is left to do, nothing is done.
        With an integrator of ``exact_restart`` the result is that of an uninterrupted run, bit for bit, otherwise to the
        tolerance.
    keep_checkpoints : bool
        Whether the checkpoints beside the file stay when the run is complete.
    stop : sequence of StopRule
        Rules that end the run before its last time; the status says which did.
    observe : callable, optional
        Called at each output time, the first included, with t and a view of the state, shape (components, size), which it
        must not change.
    report : callable, optional
        Called now and then with the time reached.
    progress : bool, optional
        Whether to show how far it is; by default what the variable ``MOL_COMPACTONS_PROGRESS`` says, and without it only in a
        notebook or an interactive interpreter, so that scripts are silent.

    Returns
    -------
    xarray.Dataset
        The components (t, x), the conserved quantities (t), also (t_series) where the simulation wants them more often, and in
        its attributes the simulation, the status and the cost.

    Raises
    ------
    InputError
        If the file cannot be written, the integrator cannot take the system, or the run cannot go on from the file; nothing
        is written then.
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
    _check_arguments(simulation, stop, observe)
    require(not resume or path is not None, "resume goes on from a file; give its path.")
    require(not (resume and overwrite), "A run either goes on from its file or replaces it; give resume or overwrite.")
    target = None if path is None else _place(Path(path), overwrite or resume)
    with showing_progress(simulation.t_end, TIME, progress) as show:
        if resume and target is not None and target.exists():
            from mol_compactons.results.resuming import look_for_earlier

            earlier = look_for_earlier(target, simulation)
            if earlier.is_enough:
                if earlier.keeps_itself and not keep_checkpoints:  # a kill may have come before this
                    checkpoint.discard(target)
                return earlier.dataset
            course = _going_on(earlier, target, stop)
        else:
            course = _from_the_start(simulation, target, _recording(target, overwrite), stop)
        course.show_to(observe)

        def say(t: float) -> None:
            show(t)
            report(t)

        with stopping_on_signals(report if show is show_nobody else say) as watch:
            course.go(watch, keep_checkpoints)
    return course.recorder.dataset()


def _recording(path: Path | None, overwrite: bool) -> Callable[[Layout], Recorder]:
    """What makes the recorder of a run, in memory or into a file."""
    if path is None:
        return MemoryRecorder
    from mol_compactons.results.netcdf import NetCDFRecorder

    return partial(NetCDFRecorder, path=path, overwrite=overwrite)


def recorded(simulation: Simulation) -> MemoryRecorder:
    """Integrate a simulation into memory, for those who make many: no Dataset is made before one is asked for.

    Parameters
    ----------
    simulation : Simulation
        What to run.

    Raises
    ------
    InputError, IntegrationError
        As `run`.
    """
    course = _from_the_start(simulation, None, MemoryRecorder, ())
    with stopping_on_signals(no_report) as watch:
        course.go(watch, keep_checkpoints=False)
    recorder = course.recorder
    assert isinstance(recorder, MemoryRecorder)
    return recorder


def _place(path: Path, may_exist: bool) -> Path:
    """Where a path is, whatever the working folder will be; raises `InputError` where no result can be written there."""
    check_target(path, may_exist)
    return path.absolute()


def _check_arguments(simulation: Simulation, stop: Sequence[StopRule], observe: Observe | None) -> None:
    require(isinstance(simulation, Simulation), f"{shown(simulation)} is no Simulation; give one.")
    rules = isinstance(stop, Sequence) and all(isinstance(rule, StopRule) for rule in stop)
    require(rules, f"stop = {shown(stop)} must be a list of rules, as [BlowUp()].")
    require(observe is None or callable(observe), f"observe = {shown(observe)} must be a function of t and the state.")


def _from_the_start(
    simulation: Simulation, path: Path | None, recording: Callable[[Layout], Recorder], stop: Sequence[StopRule]
) -> Course:
    system = simulation.discretize()
    state = simulation.initial_state()
    integration = simulation.integrator.start(system, state, simulation.t_end)
    layout = _layout(simulation, system, state)
    watchers = [rule.begin(system, 0.0, view_of(state)) for rule in stop]
    course = Course(simulation, system, path, integration, recording(layout), watchers)
    course.record(0.0, state)
    return course


def _going_on(earlier: Earlier, path: Path, stop: Sequence[StopRule]) -> Course:
    from mol_compactons.results.netcdf import NetCDFRecorder
    from mol_compactons.results.resuming import from_last_frame

    simulation = earlier.simulation
    system, integrator = simulation.discretize(), simulation.integrator
    began = earlier.checkpoint or from_last_frame(earlier)
    if earlier.checkpoint:
        integration = integrator.resume(system, began.memory, simulation.t_end)
    else:
        integration = integrator.restart(system, began.t, began.memory["state"], simulation.t_end)
    integration.counters = began.counters
    layout = _layout(simulation, system, simulation.initial_state())
    watchers = [rule.begin(system, 0.0, simulation.initial_state()) for rule in stop]
    for watcher in watchers:
        watcher.go_on(began.t, view_of(began.memory["state"]))
    now = datetime.now(UTC).isoformat(timespec="seconds")
    if earlier.frames_before:
        layout.attributes[FRAMES_BEFORE] = ", ".join(map(str, earlier.frames_before))
    layout.attributes["history"] = f"{earlier.history}\n{now}: went on from t = {began.t:.6g} by {source().split(' (')[0]}"
    recorder = NetCDFRecorder(layout, path, overwrite=True)
    if earlier.checkpoint and earlier.keeps_itself:
        # What is taken over has it no more.
        with contextlib.suppress(InputError):
            checkpoint.save(path, 0, began)
    with earlier.dataset as dataset:
        recorder.take_over(dataset, began.frames)
    return Course(simulation, system, path, integration, recorder, watchers, began)


def _layout(simulation: Simulation, system: SemiDiscretization, state: Array) -> Layout:
    names = list(numbers_of(system.invariants(state))), list(numbers_of(system.diagnostics(state)))
    return layout_of(simulation, *names, system.magnitudes(state))
