from __future__ import annotations

import pytest
import xarray as xr

from mol_compactons import IntegrationError, run, track
from mol_compactons.analysis import summary
from mol_compactons.analysis.summary import waves_of
from mol_compactons.integrators import IDA
from tests.systems import one_compacton


def test_a_result_in_one_line() -> None:
    dataset = run(one_compacton(t_end=0.5, frames=6))
    assert summary.contents(dataset) == "W(t, x), 6 frames on 150 points to t = 0.5, complete"
    assert summary.contents(dataset.isel(t=slice(0, 0))) == "W(t, x), 0 frames on 150 points to t = 0, complete"


def test_what_was_kept_is_the_largest_drift_of_each_up_or_down() -> None:
    role = {"role": "conserved"}
    series = {
        "mass": ("t", [2.0, 2.5, 2.0], role),
        "momentum": ("t", [2.0, 0.5, 2.0], role),
        "energy": ("t", [-1.0, -1.5, -0.25], role),
        "moment": ("t", [0.0, -4.0, 3.0], role | {"magnitude": 8.0}),
        "area": ("t", [1.0, 1.0, 1.0], role),
    }
    dataset = xr.Dataset(series, {"t": [0.0, 1.0, 2.0]}, {"format": 2})
    assert summary.kept(dataset) == (
        "kept mass to 2.5e-01, momentum to 7.5e-01, energy to 7.5e-01, "
        "moment to 5.0e-01 of the sum of the sizes of its parts, area to 0.0e+00"
    )
    assert summary.kept(dataset.drop_vars(list(series))) == "nothing is conserved"
    assert summary.kept(dataset.isel(t=slice(0, 0))) == "kept nothing: there is no frame"


def test_what_it_cost() -> None:
    counts = {"steps": 5, "evaluations": 11, "jacobians": 2, "failures": 1, "warnings": 0}
    attributes = {f"solver_{name}": count for name, count in counts.items()} | {"cpu_seconds": 1.234}
    line = "cost 5 steps, 11 evaluations, 2 jacobians, 1 failures, 0 warnings; 1.23 s of CPU time"
    assert summary.cost(xr.Dataset(attrs=attributes)) == line
    loud = attributes | {"solver_warnings": 3, "solver_first_warning": "careful"}
    assert summary.cost(xr.Dataset(attrs=loud)).endswith("3 warnings; 1.23 s of CPU time; first warning: careful")
    assert summary.cost(xr.Dataset()) == "cost unknown: the run has not ended"


def test_the_lines_of_a_run_that_failed_can_be_said_too() -> None:
    with pytest.raises(IntegrationError) as failure:
        run(one_compacton(t_end=2, frames=21, integrator=IDA(max_steps=10)))
    dataset = failure.value.dataset
    assert ", failed at t = " in summary.contents(dataset)
    assert summary.kept(dataset).startswith("kept mass to ")
    assert summary.cost(dataset).startswith(f"cost {dataset.attrs['solver_steps']} steps")


def test_a_wave_is_told_as_it_was_when_it_was_last_clear_of_others() -> None:
    tracks = track(run(one_compacton(t_end=1, frames=11)))
    (wave,) = waves_of(tracks)
    assert wave["wave"] == 0
    assert wave["speed"] == pytest.approx(1, abs=0.05)
    flying = tracks.isel(wave=0).dropna("t", subset=["speed"])
    assert wave["t"] == float(flying.t[-1])
    assert wave["position"] == float(flying.position[-1])
