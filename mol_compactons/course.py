"""A run on its way: the loop over its frames, its checkpoints, and its end, whatever that is."""

from __future__ import annotations

import contextlib
import logging
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import InputError, IntegrationError, require
from mol_compactons.integrators.base import CanBeClosed, Integration, Memory, RemembersItself, Report
from mol_compactons.results import checkpoint
from mol_compactons.results.checkpoint import Checkpoint
from mol_compactons.results.recorder import Recorder
from mol_compactons.results.schema import COMPLETE, cost_attributes, source
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.simulation import Simulation, divided
from mol_compactons.stop_rules import Watcher

if TYPE_CHECKING:
    import xarray as xr

CHECKPOINT_SECONDS = 10.0
"""How often a run into a file can be gone on from."""

ALIVE_SECONDS = 5.0
"""How often a run shows in its file that it goes on."""

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

Observe = Callable[[float, Array], None]
"""Called with an output time and a view of the state there."""


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
        numbers = numbers_of(self._system.invariants(state) | self._system.diagnostics(state))
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
            self._observe(t, view_of(state))

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
            if logger.isEnabledFor(logging.INFO):
                logger.info("%s: from t = %.6g on: %s", self._place, self._t, self._simulation.headline)
            report(self._t)
            watching = self._watching(report)
            for t in self._times[self._recorded :]:
                state = self._advance(float(t), watching)
                self.record(float(t), state)
                if self._recorded < self._simulation.frames:
                    self._stop_if(
                        self._t, [watcher.at_frame(self._t, view_of(state), self._so_far) for watcher in self._watchers]
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
            self._log_the_end(str(failure or status or self._interrupted), status == COMPLETE and not failure)
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
                logger.debug("%s: checkpoint at t = %.6g", self._path, t)
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
    def _interrupted(self) -> str:
        return f"interrupted at t = {self._t:.6g}"

    def _log_the_end(self, told: str, well: bool) -> None:
        level, steps = logging.INFO if well else logging.WARNING, self._integration.counters.steps
        logger.log(level, "%s: %s, %d steps, %.2f s", self._place, told, steps, self._seconds)

    @property
    def _place(self) -> str:
        """Where the frames go, for a log."""
        return "in memory" if self._path is None else str(self._path)

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
        attributes = cost_attributes(status or self._interrupted, self._integration.counters, self._seconds)
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


def view_of(state: Array) -> Array:
    """A state that others may look at and not change."""
    view = np.asarray(state).view()
    view.flags.writeable = False
    return view


def numbers_of(values: dict[str, float]) -> dict[str, float]:
    """What an equation, perhaps one of the user's own, gives along t, as numbers."""
    for name, value in values.items():
        require(np.ndim(value) == 0, f"{name} is an array of shape {np.shape(value)} along t; return one number for it.")
    return {name: float(value) for name, value in values.items()}
