from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mol_compactons import IDA, InputError, IntegrationError, Rosenbrock, run
from mol_compactons.course import Course, numbers_of, view_of
from mol_compactons.results.recorder import MemoryRecorder
from mol_compactons.results.schema import COMPLETE, layout_of
from mol_compactons.running import recorded
from tests.systems import one_compacton

SIMULATION = one_compacton(size=60, t_end=0.5, frames=6, integrator=Rosenbrock())


def begun() -> Course:
    """A course that has its first frame, made by hand."""
    system, state = SIMULATION.discretize(), SIMULATION.initial_state()
    integration = SIMULATION.integrator.start(system, state, SIMULATION.t_end)
    recorder = MemoryRecorder(layout_of(SIMULATION, list(system.invariants(state)), [], system.magnitudes(state)))
    course = Course(SIMULATION, system, None, integration, recorder)
    course.record(0.0, state)
    return course


def test_a_course_goes_to_its_end_as_run_does() -> None:
    course, seen = begun(), []
    course.show_to(lambda t, state: seen.append(t))
    course.go(lambda t: None, keep_checkpoints=False)
    dataset, expected = course.recorder.dataset(), run(SIMULATION)
    np.testing.assert_array_equal(dataset.W.values, expected.W.values)
    np.testing.assert_array_equal(dataset.energy.values, expected.energy.values)
    assert dataset.attrs["status"] == COMPLETE
    assert seen == pytest.approx(SIMULATION.times)


def test_an_interruption_leaves_the_frames_and_says_where_it_was() -> None:
    course = begun()

    def watch(t: float) -> None:
        if t > 0.25:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        course.go(watch, keep_checkpoints=False)
    dataset = course.recorder.dataset()
    assert dataset.attrs["status"].startswith("interrupted at t = 0.")
    assert 1 < dataset.sizes["t"] < 6


def test_a_failure_carries_the_frames_so_far(monkeypatch: pytest.MonkeyPatch) -> None:
    course = begun()
    advance = course._integration.advance

    def fails(t: float, report: Any) -> Any:
        if t > 0.25:
            raise IntegrationError("as a test", t)
        return advance(t, report)

    monkeypatch.setattr(course._integration, "advance", fails)
    with pytest.raises(IntegrationError) as failure:
        course.go(lambda t: None, keep_checkpoints=False)
    assert failure.value.dataset is not None
    assert failure.value.dataset.sizes["t"] == 3


def test_what_is_recorded_without_a_dataset_is_the_same() -> None:
    recorder, expected = recorded(SIMULATION), run(SIMULATION)
    np.testing.assert_array_equal(recorder.states[:, 0], expected.W.values)
    np.testing.assert_array_equal(recorder.numbers[:, 0], expected.t.values)
    assert recorder.attributes["solver_steps"] == expected.attrs["solver_steps"]
    assert recorder.attributes["status"] == COMPLETE


def test_others_may_look_and_not_touch(tmp_path: Path) -> None:
    state = np.zeros(3)
    with pytest.raises(ValueError, match="read-only"):
        view_of(state)[0] = 1
    assert state.flags.writeable
    assert numbers_of({"mass": np.float64(1)}) == {"mass": 1.0}
    with pytest.raises(InputError, match="mass is an array of shape"):
        numbers_of({"mass": np.zeros(2)})  # type: ignore[dict-item]


def test_the_log_tells_of_beginnings_checkpoints_and_ends(
    caplog: pytest.LogCaptureFixture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mol_compactons.course.CHECKPOINT_SECONDS", 0.0)
    simulation = one_compacton(t_end=0.3, frames=4, integrator=Rosenbrock())
    with caplog.at_level("DEBUG", "mol_compactons"):
        run(simulation, tmp_path / "a.nc").close()
        with pytest.raises(IntegrationError):
            run(one_compacton(t_end=2, frames=21, integrator=IDA(max_steps=10)))
    told = [(record.levelname, record.getMessage().replace(str(tmp_path), "HERE")) for record in caplog.records]
    assert told[0] == ("INFO", f"HERE/a.nc: from t = 0 on: {simulation.headline}")
    assert any(level == "DEBUG" and "a.nc: checkpoint at t = 0." in line for level, line in told)
    assert any(level == "INFO" and line.startswith("HERE/a.nc: complete, ") for level, line in told)
    assert any(level == "WARNING" and line.startswith("in memory: ") and "max_steps" in line for level, line in told)


def test_nothing_is_logged_where_nobody_asks(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(IntegrationError):
        run(one_compacton(t_end=2, frames=21, integrator=IDA(max_steps=10)))
    assert capfd.readouterr().err == ""
