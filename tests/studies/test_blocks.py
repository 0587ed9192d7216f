from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
import xarray as xr

from mol_compactons import (
    CustomEquation,
    Equation,
    Formula,
    GaussLegendre,
    Grid,
    InputError,
    Lattice,
    Processes,
    Simulation,
    Wave,
    open_sweep,
    run,
    sweep,
)
from mol_compactons.studies.blocks import Block, carry_out_all, units_of
from mol_compactons.studies.members import Task
from mol_compactons.studies.opening import open_member
from mol_compactons.studies.plan import product
from mol_compactons.studies.store import rows_of
from mol_compactons.studies.sweep import TABLE
from tests.studies.sweeps import BAD_SIZE, deadly, peak, small

SPEEDS = [0.5, 0.6, 0.7, 0.8, 0.9]
COSTS = ["seconds", "cpu_seconds"]


def tasks(folder: Path, sizes: list[int], **changes: object) -> list[Task]:
    members = product(
        small(), {"grid.size": sizes, "initial.0.speed": SPEEDS, **{name: [value] for name, value in changes.items()}}
    )
    return [
        Task(one.name, one.label, [list(one.index)], {}, one.tree, str(folder / f"{one.name}.nc"), tracked=False)
        for one in members
    ]


def test_a_sweep_says_the_same_in_blocks_and_one_by_one(tmp_path: Path) -> None:
    varied: dict[str, list[Any]] = {"grid.size": [60, BAD_SIZE, 80], "initial.0.speed": SPEEDS}
    alone = sweep(small(), varied, tmp_path / "alone", quantities={"peak": peak})
    together = sweep(small(), varied, tmp_path / "together", quantities={"peak": peak}, per_file=4)
    xr.testing.assert_identical(*(one.drop_vars(COSTS).drop_attrs() for one in (alone, together)))
    files = sorted(path.name for path in (tmp_path / "together" / "members").iterdir())
    assert len(files) == 4, "for each grid one block of four and one member by itself"
    assert sum(name.startswith("block_") for name in files) == 2
    with xr.open_dataset(tmp_path / "together" / TABLE) as stored:
        assert (stored["status"] == "failed").sum() == len(SPEEDS)


def test_a_member_of_a_block_is_the_run_itself(tmp_path: Path) -> None:
    table = sweep(small(), {"initial.0.speed": SPEEDS}, tmp_path / "s", per_file=50)
    assert [path.name[:6] for path in (tmp_path / "s" / "members").iterdir()] == ["block_"]
    for name in table["name"].values:
        member = open_member(tmp_path / "s", str(name))
        own = run(Simulation.from_json(member.attrs["simulation"]))
        xr.testing.assert_equal(member, own)
        changing = ("history", "cpu_seconds")
        assert {k: v for k, v in member.attrs.items() if k not in changing} == {
            k: v for k, v in own.attrs.items() if k not in changing
        }
        assert all(member[one].attrs == own[one].attrs for one in own.variables)
    with pytest.raises(InputError, match="no result of a member 'nothing'"):
        open_member(tmp_path / "s", "nothing")


def test_a_block_opens_in_plain_xarray(tmp_path: Path) -> None:
    sweep(small(), {"initial.0.speed": SPEEDS}, tmp_path / "s", per_file=50)
    (path,) = (tmp_path / "s" / "members").iterdir()
    with xr.open_dataset(path) as block:
        assert block.W.dims == ("member", "t", "x")
        heights = block.W.max(["t", "x"]).values
        assert (np.diff(heights) > 0).all(), "faster compactons are higher"
        assert json.loads(str(block["attributes"].values[0]))["status"] == "complete"


@pytest.mark.parametrize("per_file", [1, 2, 50])
def test_open_sweep_reads_blocks_as_it_reads_files(tmp_path: Path, per_file: int) -> None:
    varied = {"initial.0.speed": SPEEDS, "initial.0.center": [5.0, 7.5, 10.0]}
    sweep(small(), varied, tmp_path / "s", tracked=False, per_file=per_file)
    members = open_sweep(tmp_path / "s")
    assert isinstance(members, xr.Dataset)
    assert members.W.dims == ("speed", "center", "t", "x")
    for speed, center in ((0.5, 5.0), (0.9, 7.5), (0.7, 10.0)):
        own = open_member(tmp_path / "s", members["name"].sel(speed=speed, center=center).item())
        np.testing.assert_array_equal(members.W.sel(speed=speed, center=center).values, own.W.values)
        np.testing.assert_array_equal(members.mass.sel(speed=speed, center=center).values, own.mass.values)


@pytest.mark.slow
def test_a_block_that_loses_its_process_again_and_again_is_run_one_by_one(tmp_path: Path) -> None:
    """One member of two kills its process whenever it runs: it alone fails."""
    varied, quantities = {"initial.0.speed": [0.5, 0.9]}, {"deadly": deadly}
    table = sweep(small(), varied, tmp_path / "s", engine=Processes(2), quantities=quantities, tracked=False, per_file=2)
    assert table["status"].values.tolist() == ["complete", "failed"]
    assert "killed 4 times" in table["reason"].values[1]
    assert float(table["deadly"][0]) == pytest.approx(1, abs=0.01)
    assert (tmp_path / "s" / "members" / f"{table['name'].values[0]}.nc").is_file()


def test_the_same_call_runs_what_a_removed_block_held(tmp_path: Path) -> None:
    varied = {"initial.0.speed": SPEEDS}
    first = sweep(small(), varied, tmp_path / "s", per_file=3)
    before = (tmp_path / "s" / "rows.jsonl").read_text(encoding="utf-8").count("\n")
    removed = tmp_path / "s" / "members" / next(iter(rows_of(tmp_path / "s").values()))["file"]
    removed.unlink()
    again = sweep(small(), varied, tmp_path / "s", per_file=3)
    xr.testing.assert_identical(*(one.drop_vars(COSTS).drop_attrs() for one in (first, again)))
    assert (tmp_path / "s" / "rows.jsonl").read_text(encoding="utf-8").count("\n") == before + 3


def test_large_members_and_frequent_series_have_files_of_their_own(tmp_path: Path) -> None:
    assert [len(unit.tasks) for unit in units_of(tasks(tmp_path, [60]), 50, tmp_path) if isinstance(unit, Block)] == [5]
    assert not any(isinstance(one, Block) for one in units_of(tasks(tmp_path, [60], series_per_frame=2), 50, tmp_path))
    large = list(units_of(tasks(tmp_path, [10**6], frames=40), 50, tmp_path))
    assert len(large) == 5
    both = [unit for unit in units_of(tasks(tmp_path, [60, 80]), 50, tmp_path) if isinstance(unit, Block)]
    assert [len({task.tree["grid"]["size"] for task in unit.tasks}) for unit in both] == [1, 1]


def test_a_block_that_cannot_be_written_is_a_reason_of_its_members(tmp_path: Path) -> None:
    (block,) = units_of(tasks(tmp_path, [60]), 50, tmp_path / "nowhere")
    rows = carry_out_all(block)
    assert {row["status"] for row in rows} == {"failed"}
    assert all("cannot be written" in row["reason"] for row in rows)


def test_other_integrators_and_failures_have_their_place(tmp_path: Path) -> None:
    table = sweep(
        small(),
        {"integrator": [GaussLegendre(step=0.1), "Rosenbrock(rtol=1e-4)", "Rosenbrock(rtol=-1)"]},
        tmp_path / "s",
        per_file=5,
        tracked=False,
    )
    assert table["status"].values.tolist() == ["complete", "complete", "failed"]
    assert "rtol" in table["reason"].values[2]
    with pytest.raises(InputError, match="per_file = 0"):
        sweep(small(), {"grid.size": [60]}, tmp_path / "t", per_file=0)


def test_members_with_other_variables_have_files_of_their_own(tmp_path: Path) -> None:
    """Another name of the field, a source that makes the mass no conserved quantity: each is what run makes of it."""
    flux = "3*u**2 + d2(u)"
    equations = [
        CustomEquation(flux=flux),
        CustomEquation(flux=flux, source="-0.5*u"),
        CustomEquation(flux=flux.replace("u", "W"), variable="W"),
        "CustomEquation(nothing=1)",
        None,
    ]
    start = Simulation(
        equation=equations[0],  # type: ignore[arg-type]
        grid=Grid(20, 60),
        initial=[Formula("exp(-(x - 8)**2)")],
        t_end=0.02,
        frames=3,
    )
    table = sweep(start, {"equation": equations}, tmp_path / "s", tracked=False, per_file=9)
    assert table["status"].values.tolist() == ["complete"] * 3 + ["failed"] * 2
    files = set()
    for name in table["name"].values[:3]:
        member = open_member(tmp_path / "s", str(name))
        own = run(Simulation.from_json(member.attrs["simulation"]))
        assert set(member.data_vars) == set(own.data_vars)
        assert all(member[one].attrs == own[one].attrs for one in own.variables)
        files.add(rows_of(tmp_path / "s")[str(name)]["file"])
    assert len(files) == 3
    assert isinstance(open_sweep(tmp_path / "s"), xr.DataTree)


def test_a_class_that_is_defined_anew_is_the_new_one(tmp_path: Path) -> None:
    heights = []
    for amplitude in (1.0, 3.0):

        @dataclass(frozen=True)
        class Bump(Wave):
            """A bump of a height that its class has."""

            width: float = 1.0
            height: ClassVar[float] = amplitude

            def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> Any:
                return self.height * np.exp(-((grid.coordinates - 8) ** 2) / self.width)[None]

        start = replace(small(), initial=[Bump()])
        sweep(start, {"grid.left": [0.0], "t_end": [0.01, 0.02]}, tmp_path / f"{amplitude:g}", tracked=False, per_file=4)
        rows = rows_of(tmp_path / f"{amplitude:g}").values()
        heights += [float(open_member(tmp_path / f"{amplitude:g}", row["name"]).W[0].max()) for row in rows]
    assert heights == pytest.approx([1, 1, 3, 3], rel=0.05)


def test_what_an_earlier_attempt_left_goes_when_the_member_is_in_a_block(tmp_path: Path) -> None:
    sweep(small(), {"initial.0.speed": SPEEDS}, tmp_path / "s", tracked=False)
    rows = tmp_path / "s" / "rows.jsonl"
    rows.write_text("", encoding="utf-8")
    sweep(small(), {"initial.0.speed": SPEEDS}, tmp_path / "s", tracked=False, per_file=5)
    assert [path.name[:6] for path in (tmp_path / "s" / "members").iterdir()] == ["block_"]
