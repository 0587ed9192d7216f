"""Taking a simulation through time into a recorder, from its beginning or from where an earlier run was."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import InputError, IntegrationError, require, shown
from mol_compactons.integrators.base import CanBeClosed, Integration, Memory, RemembersItself, Report, no_report
from mol_compactons.results import checkpoint
from mol_compactons.results.checkpoint import Checkpoint
from mol_compactons.results.places import check_target
from mol_compactons.results.recorder import MemoryRecorder, Recorder
from mol_compactons.results.schema import COMPLETE, FRAMES_BEFORE, Layout, cost_attributes, layout_of, source
from mol_compactons.runtime.signals import stopping_on_signals
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.simulation import Simulation, divided
from mol_compactons.stop_rules import StopRule, Watcher

if TYPE_CHECKING:
    import xarray as xr

    from mol_compactons.results.resuming import Earlier

CHECKPOINT_SECONDS = 10.0
"""How often a run into a file can be gone on from."""

ALIVE_SECONDS = 5.0
"""How often a run shows in its file that it goes on."""

Array = NDArray[np.float64]

Observe = Callable[[float, Array], None]
"""Called with an output time and a view of the state there."""


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
    with stopping_on_signals(report) as watch:
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
    watchers = [rule.begin(system, 0.0, _view(state)) for rule in stop]
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
        watcher.go_on(began.t, _view(began.memory["state"]))
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
    names = list(_numbers(system.invariants(state))), list(_numbers(system.diagnostics(state)))
    return layout_of(simulation, *names, system.magnitudes(state))


class _Stop(Exception):  # noqa: N818  # no error: a rule ends the run
    """The status of a run that a rule has ended."""


class Course:
    """A run on its way: what has been recorded, and what it needs to go on.

    Parameters
    ----------
    simulation, system : Simulation, SemiDiscretization
        What is run.
    path : Path or None
        Where to.
    integration : Integration
        It stands between two steps.
    recorder : Recorder
        It has the frames so far.
    watchers : sequence of Watcher
        What may end the run early.
    began : Checkpoint, optional
        Where it went on from.
    """

    def __init__(
        self,
        simulation: Simulation,
        system: SemiDiscretization,
        path: Path | None,
        integration: Integration,
        recorder: Recorder,
        watchers: Sequence[Watcher] = (),
        began: Checkpoint | None = None,
    ) -> None:
        self._simulation, self._path, self._integration, self.recorder = simulation, path, integration, recorder
        self._times = simulation.times
        self._system = system
        self._watchers = watchers
        self._observe: Observe | None = None
        self._recorded = began.frames if began else 0
        self._between = began.between.tolist() if began else []
        self._latest: Memory = began.memory if began else {}
        self._t = began.t if began else 0.0
        self._seconds_before = began.seconds if began else 0.0
        self._begins = began is None
        self._started = time.process_time()
        self._saved = self._shown = time.monotonic()
        self._checkpoints = 0

    def show_to(self, observe: Observe | None) -> None:
        """Let somebody look at the frames that come, the first included."""
        self._observe = observe

    def record(self, t: float, state: Array) -> None:
        """Take a frame."""
        self._take_numbers(t, state)
        self.recorder.append(state, np.array(self._between))
        self._recorded += 1
        self._between = []
        self._show(t, state)

    def _take_numbers(self, t: float, state: Array) -> None:
        """Take the numbers along t."""
        self._t, self._latest = t, {"t": np.array(t), "state": state}
        numbers = _numbers(self._system.invariants(state) | self._system.diagnostics(state))
        self._between.append([t, *(numbers[name] for name in self.recorder.layout.series)])

    def _advance(self, t: float, report: Report) -> Array:
        """The state at the next frame, with the numbers along t on the way to it."""
        before = float(self._times[self._recorded - 1])
        times = divided(before, t, self._simulation.series_per_frame)
        for part in times[len(self._between) : -1]:
            self._take_numbers(float(part), self._integration.advance(float(part), report))
        return self._integration.advance(t, report)

    def _show(self, t: float, state: Array) -> None:
        if self._observe:
            self._observe(t, _view(state))

    def _so_far(self) -> xr.Dataset:
        self.recorder.sync(self._t)
        return self.recorder.dataset()

    def _stop_if(self, t: float, reasons: Sequence[str]) -> None:
        said = [reason for reason in reasons if reason]
        if said:
            raise _Stop(f"stopped at t = {t:.6g}: {'; '.join(said)}")

    def go(self, report: Report, keep_checkpoints: bool) -> None:
        """Go on to the end, and close the recorder, whatever happens."""
        status, failure = "", None
        try:
            if self._begins:
                self._show(0.0, np.asarray(self._latest["state"]))
            report(self._t)
            watching = self._watching(report)
            for t in self._times[self._recorded :]:
                state = self._advance(float(t), watching)
                self.record(float(t), state)
                if self._recorded < self._simulation.frames:
                    self._stop_if(
                        self._t, [watcher.at_frame(self._t, _view(state), self._so_far) for watcher in self._watchers]
                    )
            status = COMPLETE
        except _Stop as stop:
            status = str(stop)
        except IntegrationError as error:
            status, failure = f"failed at t = {error.t:.6g}: {error}", error
        except MemoryError:
            failure = IntegrationError(NO_MEMORY, self._t)
            status = f"failed at t = {self._t:.6g}: {NO_MEMORY}"
        except Exception as error:  # of a part of the user's own, as observe
            status = f"failed at t = {self._t:.6g}: {type(error).__name__}: {error}"
            raise
        finally:
            failure = self._close(status, report, failure, keep_checkpoints)
        if failure:
            with contextlib.suppress(InputError):
                failure.dataset = self.recorder.dataset()
            raise failure

    def _watching(self, report: Report) -> Report:
        """A report that keeps checkpoints as the clock goes."""

        def watch(t: float) -> None:
            now = time.monotonic()
            if now - self._shown > ALIVE_SECONDS:
                self.recorder.alive()
                self._shown = now
            if self._path is not None and now - self._saved > CHECKPOINT_SECONDS:
                self._save(t)
            self._stop_if(t, [watcher.between(t) for watcher in self._watchers])
            report(t)

        return watch

    def _save(self, t: float) -> None:
        """Write a checkpoint, with all frames before it safe; a run goes on without one where it cannot be written.

        While another result still has the place of this one, so have its checkpoints.
        """
        assert self._path is not None
        self.recorder.sync(t)
        if self.recorder.frames and self.recorder.is_published:
            with contextlib.suppress(InputError):
                checkpoint.save(self._path, self._checkpoints, self._checkpoint())
                self._checkpoints += 1
        self._saved = time.monotonic()

    def _checkpoint(self) -> Checkpoint:
        own = self._integration.memory() if isinstance(self._integration, RemembersItself) else self._latest
        return Checkpoint(
            t=float(own["t"]),
            frames=self._recorded,
            memory=own,
            counters=self._integration.counters,
            seconds=self._seconds,
            simulation=self._simulation.to_json(),
            source=source(),
            between=np.array(self._between),
        )

    @property
    def _seconds(self) -> float:
        return self._seconds_before + time.process_time() - self._started

    def _close(
        self, status: str, report: Report, failure: IntegrationError | None, keep_checkpoints: bool
    ) -> IntegrationError | None:
        """End the recording; what went wrong first is returned."""
        done = status == COMPLETE
        if isinstance(self._integration, CanBeClosed):
            self._integration.close()
        attributes = cost_attributes(status or f"interrupted at t = {self._t:.6g}", self._integration.counters, self._seconds)
        # After a failure the integrator may stand in the middle of a step, which nothing can go on from.
        memory = self._checkpoint().to_bytes() if self._path is not None and not failure else b""
        try:
            if status.startswith("stopped"):
                self.recorder.sync(self._t)
                self.recorder.publish()
            if memory:
                self._save(self._t)
        except IntegrationError as error:
            failure = failure or error
        try:
            inside = self.recorder.close(attributes, memory, lambda: report(self._t) if done else None)
        except IntegrationError as error:
            return failure or error
        if self._path is not None and done and inside and not keep_checkpoints:
            checkpoint.discard(self._path)
        return failure


NO_MEMORY = "there was not enough memory; choose a smaller grid.size or fewer frames, or write into a file"
"""What is said where memory is short."""


def _view(state: Array) -> Array:
    """A state that others may look at and not change."""
    view = np.asarray(state).view()
    view.flags.writeable = False
    return view


def _numbers(values: dict[str, float]) -> dict[str, float]:
    """What an equation, perhaps one of the user's own, gives along t, as numbers."""
    for name, value in values.items():
        require(np.ndim(value) == 0, f"{name} is an array of shape {np.shape(value)} along t; return one number for it.")
    return {name: float(value) for name, value in values.items()}
