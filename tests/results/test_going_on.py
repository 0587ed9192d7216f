"""Runs that go on more than once, from less than they might have, or are asked for again."""

from __future__ import annotations

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
    Midpoint,
    Rosenbrock,
    Simulation,
    Uniform,
    WallClock,
    open_result,
    run,
)
from mol_compactons.results import checkpoint
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
        for name in ("W", "R"):
            if name in whole:
                scale = float(abs(whole[name]).max())
                np.testing.assert_allclose(twice[name], whole[name], atol=1e-4 * scale)
        assert simulation.integrator.exact_restart == same(twice, once) or not simulation.integrator.exact_restart
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


def test_a_result_with_fewer_points_than_its_run_cannot_go_on(tmp_path: Path) -> None:
    with run(WAVE) as whole:
        whole.isel(x=slice(None, None, 2)).to_netcdf(tmp_path / "thin.nc")
    with pytest.raises(InputError, match="holds 38 of the 75 points of its run"):
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
