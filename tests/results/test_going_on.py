"""Runs that go on more than once, from less than they might have, or are asked for again."""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mol_compactons import (
    IDA,
    BlowUp,
    Compacton,
    CustomEquation,
    DriftBound,
    Grid,
    InputError,
    IntegrationError,
    Midpoint,
    Rosenbrock,
    Simulation,
    Uniform,
    WallClock,
    course,
    open_result,
    run,
)
from mol_compactons.results import checkpoint, netcdf
from mol_compactons.results.reading import field_names
from mol_compactons.stop_rules import StopRule
from tests.results.test_resuming import EXACT, WAVE, names, same


def ending_after(t: float, error: type[BaseException] = KeyboardInterrupt) -> Callable[[float, Any], None]:
    """An observer that ends a run."""

    def observe(now: float, _: object) -> None:
        if now > t - 1e-9:
            raise error("enough")

    return observe


def cut_off(simulation: Simulation, path: Path, t: float, resume: bool = True) -> None:
    with pytest.raises(KeyboardInterrupt):
        run(simulation, path, resume=resume, observe=ending_after(t))


@pytest.mark.parametrize("simulation", [*EXACT, replace(WAVE, integrator=IDA())], ids=names)
def test_a_run_that_began_anew_at_a_frame_is_cut_off_again_and_goes_beyond_its_end(
    simulation: Simulation, tmp_path: Path
) -> None:
    """From a checkpoint made after a start at a frame, methods of exact restart go on bit for bit, too."""
    path, other = tmp_path / "a.nc", tmp_path / "b.nc"
    for one in (path, other):
        cut_off(simulation, one, 0.4, resume=False)
        checkpoint.discard(one)
    cut_off(simulation, path, 0.6)
    cut_off(simulation, path, 0.8)
    longer = replace(simulation, t_end=2 * simulation.t_end)
    with run(simulation, path, resume=True) as twice, run(simulation, other, resume=True) as once:
        whole = run(simulation)
        assert twice.attrs["status"] == "complete"
        for name in field_names(whole):
            np.testing.assert_allclose(twice[name], whole[name], atol=1e-4 * float(abs(whole[name]).max()))
        assert same(twice, once) or not simulation.integrator.exact_restart
    with run(longer, path, resume=True) as extended:
        assert extended.attrs["status"] == "complete"
        assert extended.sizes["t"] == 2 * simulation.frames - 1


def test_an_extension_may_be_asked_for_any_number_of_times(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    simulation = replace(WAVE, integrator=Rosenbrock())
    run(simulation, path).close()
    longer = replace(simulation, t_end=2)
    cut_off(longer, path, 1.4)
    cut_off(longer, path, 1.6)
    with run(longer, path, resume=True) as done:
        assert (done.sizes["t"], float(done.t[-1])) == (11, 2.0)
    before = path.stat()
    for again in (longer, simulation, replace(longer, frames=11)):
        with run(again, path, resume=True) as nothing:
            assert nothing.sizes["t"] == 11
    assert path.stat().st_mtime_ns == before.st_mtime_ns
    with run(replace(longer, t_end=3), path, resume=True) as farther:
        assert farther.sizes["t"] == 16
    with run(longer, path, resume=True) as nothing, open_result(path) as stored:
        assert nothing.sizes["t"] == 16
        xr.testing.assert_equal(stored, nothing)
    with pytest.raises(InputError, match="frames = 7 differs"):
        run(replace(simulation, frames=7), path, resume=True)


@pytest.mark.parametrize("rule", [DriftBound(bound=1e-4, quantity="momentum"), BlowUp(factor=1.5)])
def test_what_was_at_first_stays_so_for_the_rules_of_a_run_that_goes_on(rule: StopRule, tmp_path: Path) -> None:
    """The second run is stopped at its first frame, by the change since t = 0."""
    growing = CustomEquation("0*u", source="u")
    waves = Simulation(growing, Grid(1, 16), [Uniform(1)], t_end=2, frames=41, integrator=Rosenbrock())
    simulation = waves if isinstance(rule, BlowUp) else replace(WAVE, t_end=4, frames=41, integrator=Rosenbrock())
    path = tmp_path / "a.nc"
    with run(simulation, path, stop=[rule]) as stopped:
        assert stopped.attrs["status"].startswith("stopped")
        frames = stopped.sizes["t"]
    with run(simulation, path, resume=True, stop=[rule]) as again:
        assert again.attrs["status"].startswith("stopped")
        assert again.sizes["t"] == frames + 1


def test_a_rule_that_ends_a_run_before_its_second_frame_leaves_the_new_result(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    old = replace(WAVE, integrator=Midpoint(step=1e-3))
    new = replace(old, initial=[Compacton(0.5, 9)], t_end=1e4, frames=2)
    run(old, path).close()
    with run(new, path, overwrite=True, stop=[WallClock(0.2)]) as stopped, open_result(path) as stored:
        assert stopped.attrs["status"].startswith("stopped at t = ")
        assert stored.attrs["simulation"] == new.to_json()
    first = float(stopped.attrs["status"].split()[4].rstrip(":"))
    with run(new, path, resume=True, stop=[WallClock(0.2)]) as again:
        assert float(again.attrs["status"].split()[4].rstrip(":")) > first > 0


@pytest.mark.parametrize("change", ["rolled", "reversed", "transposed"])
def test_a_result_whose_points_stand_elsewhere_cannot_go_on(change: str, tmp_path: Path) -> None:
    with run(replace(WAVE, frames=75)) as whole:
        changed = {
            "rolled": whole.roll(x=7, roll_coords=True),
            "reversed": whole.isel(x=slice(None, None, -1)),
            "transposed": whole.transpose("x", "t"),
        }[change]
        changed.to_netcdf(tmp_path / "changed.nc")
    with pytest.raises(InputError, match="is not as its run wrote it"):
        run(replace(WAVE, frames=75, t_end=2), tmp_path / "changed.nc", resume=True)


def test_a_checkpoint_of_frames_at_other_times_is_left_aside(tmp_path: Path) -> None:
    path, other = tmp_path / "a.nc", tmp_path / "b.nc"
    simulation = replace(WAVE, integrator=Rosenbrock(), frames=21)
    cut_off(simulation, path, 0.1, resume=False)
    coarse = replace(simulation, frames=2, t_end=0.8)
    run(coarse, other, keep_checkpoints=True).close()
    found = checkpoint.last(other)
    assert found is not None
    checkpoint.discard(path)
    checkpoint.save(path, 0, replace(found, frames=1))
    with run(simulation, path, resume=True) as done:
        np.testing.assert_allclose(done.W, run(simulation).W, atol=1e-4)


def test_a_run_that_is_to_replace_another_takes_nothing_from_it_before_it_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The old one goes on bit for bit, whatever became of the new one."""
    monkeypatch.setattr(course, "CHECKPOINT_SECONDS", 0.0)
    path, old = tmp_path / "a.nc", replace(WAVE, integrator=Midpoint(step=0.003))
    cut_off(old, path, 0.6, resume=False)
    before = checkpoint.last(path)
    with pytest.raises(KeyboardInterrupt):
        run(replace(old, frames=2, t_end=50), path, overwrite=True, observe=ending_after(0.0))
    after = checkpoint.last(path)
    assert before is not None
    assert after is not None
    assert (after.t, after.frames) == (before.t, before.frames)
    with run(old, path, resume=True) as done:
        assert same(done, run(old))


def test_an_extension_that_is_killed_at_once_still_goes_on_bit_for_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, simulation = tmp_path / "a.nc", replace(WAVE, integrator=Rosenbrock())
    run(simulation, path).close()
    longer = replace(simulation, t_end=2)

    def killed(own: Any, *_: object) -> None:
        own.recorder._file.close()
        raise KeyboardInterrupt

    monkeypatch.setattr(course.Course, "go", killed)
    with pytest.raises(KeyboardInterrupt):
        run(longer, path, resume=True)
    monkeypatch.undo()
    with run(longer, path, resume=True) as done:
        assert same(done, run(replace(longer, frames=11)))


def test_two_runs_that_are_to_replace_one_file_are_not_both_let(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    run(WAVE, path).close()

    def second(t: float, _: object) -> None:
        asked: list[dict[str, Any]] = [{"overwrite": True}, {"resume": True}]
        for settings in asked:
            with pytest.raises(InputError, match="Another run is"):
                run(replace(WAVE, t_end=2), path, **settings)

    with run(replace(WAVE, integrator=Rosenbrock()), path, overwrite=True, observe=second) as done:
        assert done.attrs["status"] == "complete"


def test_a_file_that_another_program_wrote_while_it_was_to_be_replaced_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    path.write_bytes(b"old")

    def write(t: float, _: object) -> None:
        path.write_bytes(b"precious")

    with pytest.raises(IntegrationError, match=r"Another program changed .*a\.nc; the frames so far were saved as"):
        run(WAVE, path, overwrite=True, observe=write)
    assert path.read_bytes() == b"precious"
    (rescued,) = tmp_path.glob("a.rescued-*.nc")
    with open_result(rescued) as kept:
        assert kept.sizes["t"] >= 2


def test_an_interrupt_while_the_file_is_compressed_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    path, simulation = tmp_path / "a.nc", replace(WAVE, integrator=Rosenbrock())
    monkeypatch.setattr(netcdf, "_compress", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(simulation, path)
    monkeypatch.undo()
    with open_result(path) as kept:
        assert (kept.attrs["status"], kept.sizes["t"]) == ("complete", simulation.frames)
    longer = replace(simulation, t_end=2)
    with run(longer, path, resume=True) as done:
        assert same(done, run(replace(longer, frames=11)))


def test_an_observer_that_fails_at_the_first_frame_leaves_nothing_claimed(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    with pytest.raises(ValueError, match="enough") as failure:
        run(WAVE, path, observe=ending_after(0.0, ValueError))
    with run(WAVE, path, overwrite=True) as done:  # while the traceback lives
        assert done.attrs["status"] == "complete"
    assert failure.tb is not None
    assert {one.name for one in tmp_path.iterdir()} == {"a.nc"}


def test_an_observer_sees_each_output_time_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(course, "CHECKPOINT_SECONDS", 0.0)
    path, simulation, seen = tmp_path / "a.nc", replace(WAVE, integrator=Midpoint(step=0.003), frames=3), []
    cut_off(simulation, path, 0.0, resume=False)
    run(simulation, path, resume=True, observe=lambda t, _: seen.append(t)).close()
    assert seen == [0.5, 1.0]


def test_states_that_others_see_cannot_be_changed() -> None:
    class Zeroing(DriftBound):
        def begin(self, system: Any, t: float, state: Any) -> Any:
            state[:] = 0.0

    with pytest.raises(ValueError, match="read-only"):
        run(WAVE, stop=[Zeroing()])


def test_a_process_that_is_forked_from_a_run_does_not_hold_its_file(tmp_path: Path) -> None:
    path, context = tmp_path / "a.nc", multiprocessing.get_context("fork")
    helpers: list[multiprocessing.process.BaseProcess] = []

    def fork(t: float, _: object) -> None:
        if not helpers:
            helpers.append(context.Process(target=time.sleep, args=(60,), daemon=True))
            helpers[0].start()
        if t > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(WAVE, path, observe=fork)
    assert helpers[0].is_alive()
    with run(WAVE, path, resume=True) as done:
        assert done.attrs["status"] == "complete"
    helpers[0].kill()


def test_the_working_folder_may_change_on_the_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    with run(WAVE, "a.nc", observe=lambda t, _: os.chdir(tmp_path / "elsewhere")) as done:
        assert done.attrs["status"] == "complete"
    assert (tmp_path / "a.nc").is_file()


def test_who_may_read_a_file_may_read_the_one_that_replaces_it(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    run(WAVE, path).close()
    path.chmod(0o600)
    run(replace(WAVE, t_end=2), path, resume=True).close()
    assert path.stat().st_mode & 0o777 == 0o600
    run(WAVE, path, overwrite=True).close()
    assert path.stat().st_mode & 0o777 == 0o600


def test_a_pipe_is_no_file_to_go_on_from(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.nc")
    with pytest.raises(InputError, match="is not an ordinary file"):
        run(WAVE, tmp_path / "a.nc", resume=True)


def test_a_result_with_fewer_points_than_its_run_cannot_go_on(tmp_path: Path) -> None:
    with run(WAVE) as whole:
        whole.isel(x=slice(None, None, 2)).to_netcdf(tmp_path / "thin.nc")
    with pytest.raises(InputError, match="its points are other than the 75 of the run"):
        run(replace(WAVE, t_end=2), tmp_path / "thin.nc", resume=True)


def test_an_error_of_an_observer_is_kept_as_what_it_is(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="enough"):
        run(WAVE, tmp_path / "a.nc", observe=ending_after(0.4, ValueError))
    with open_result(tmp_path / "a.nc") as kept:
        assert kept.attrs["status"] == "failed at t = 0.4: ValueError: enough"
        assert kept.sizes["t"] == 3
    with run(WAVE, tmp_path / "a.nc", resume=True) as done:
        assert done.attrs["status"] == "complete"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"stop": BlowUp()}, "must be a list of rules"),
        ({"stop": "BlowUp"}, "must be a list of rules"),
        ({"stop": [BlowUp]}, "must be a list of rules"),
        ({"observe": 3}, "observe = 3 must be a function"),
        ({"simulation": "two_bright"}, "'two_bright' is no Simulation"),
        ({"path": "a.nc", "resume": True, "overwrite": True}, "give resume or overwrite"),
    ],
)
def test_arguments_that_make_no_sense_are_one_sentence(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        run(**{"simulation": WAVE, **arguments})
