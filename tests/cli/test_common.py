from __future__ import annotations

import argparse
from pathlib import Path

import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from mol_compactons import InputError, IntegrationError, run
from mol_compactons.cli import common, scenarios
from mol_compactons.integrators import IDA
from tests.systems import one_compacton

names = st.text("abcdefg._0123", min_size=1, max_size=10)


@given(st.dictionaries(names, st.text(max_size=10), max_size=4))
def test_what_stands_before_the_first_equals_sign_is_the_field(changes: dict[str, str]) -> None:
    assert common.assignments([f"{field}={value}" for field, value in changes.items()]) == changes


def test_a_field_without_a_value_or_with_two_is_refused() -> None:
    assert common.assignments([" grid.size =1200", "title=a=b"]) == {"grid.size": "1200", "title": "a=b"}
    with pytest.raises(InputError, match=r"'grid\.size' lacks a value; write FIELD=VALUE"):
        common.assignments(["grid.size"])
    with pytest.raises(InputError, match=r"grid\.size is given twice; give it once"):
        common.assignments(["grid.size=1", "grid.size =2"])


def test_options_make_a_simulation() -> None:
    parser = argparse.ArgumentParser()
    common.add_scenario(parser)
    options = parser.parse_args(["single_compacton", "--set", "grid.size=150", "--set", "initial.0.speed=1/2"])
    simulation = common.simulation_of(options)
    assert simulation.grid.size == 150
    assert "speed=0.5" in repr(simulation.initial[0])
    assert simulation.title == scenarios.load("single_compacton").title


def test_a_module_is_imported_where_it_is_asked_for_or_named(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setattr(common, "import_module", asked.append)
    parser = argparse.ArgumentParser()
    common.add_scenario(parser)
    options = parser.parse_args(["single_compacton", "--import", "one", "--set", "equation=other:Thing(n=3)"])
    with pytest.raises(InputError, match="other:Thing is not loaded"):
        common.simulation_of(options)
    assert asked == ["one", "other"]


def test_a_result_in_one_line() -> None:
    dataset = run(one_compacton(t_end=0.5, frames=6))
    assert common.contents(dataset) == "W(t, x), 6 frames on 150 points to t = 0.5, complete"
    assert common.contents(dataset.isel(t=slice(0, 0))) == "W(t, x), 0 frames on 150 points to t = 0, complete"


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
    assert common.kept(dataset) == (
        "kept mass to 2.5e-01, momentum to 7.5e-01, energy to 7.5e-01, "
        "moment to 5.0e-01 of the sum of the sizes of its parts, area to 0.0e+00"
    )
    assert common.kept(dataset.drop_vars(list(series))) == "nothing is conserved"
    assert common.kept(dataset.isel(t=slice(0, 0))) == "kept nothing: there is no frame"


def test_what_it_cost() -> None:
    counts = {"steps": 5, "evaluations": 11, "jacobians": 2, "failures": 1, "warnings": 0}
    attributes = {f"solver_{name}": count for name, count in counts.items()} | {"cpu_seconds": 1.234}
    line = "cost 5 steps, 11 evaluations, 2 jacobians, 1 failures, 0 warnings; 1.23 s of CPU time"
    assert common.cost(xr.Dataset(attrs=attributes)) == line
    loud = attributes | {"solver_warnings": 3, "solver_first_warning": "careful"}
    assert common.cost(xr.Dataset(attrs=loud)).endswith("3 warnings; 1.23 s of CPU time; first warning: careful")
    assert common.cost(xr.Dataset()) == "cost unknown: the run has not ended"


def test_the_lines_of_a_run_that_failed_can_be_said_too() -> None:
    with pytest.raises(IntegrationError) as failure:
        run(one_compacton(t_end=2, frames=21, integrator=IDA(max_steps=10)))
    dataset = failure.value.dataset
    assert ", failed at t = " in common.contents(dataset)
    assert common.kept(dataset).startswith("kept mass to ")
    assert common.cost(dataset).startswith(f"cost {dataset.attrs['solver_steps']} steps")


def test_a_picture_is_written_and_said(capsys: pytest.CaptureFixture[str]) -> None:
    common.save(Figure(figsize=(1, 1)), Path("empty.PNG"))
    assert capsys.readouterr().out == "wrote empty.PNG\n"
    assert Path("empty.PNG").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(InputError, match=r"empty\.xyz has no picture format; end its name in .*pdf.*png"):
        common.save(Figure(), Path("empty.xyz"))
