from __future__ import annotations

import random
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mol_compactons import InputError, Rosenbrock, Simulation, run
from mol_compactons.studies.engine import Cluster, Engine, Here, Processes
from mol_compactons.studies.plan import listed, product
from mol_compactons.studies.store import rows_of
from mol_compactons.studies.sweep import TABLE, Progress, sweep
from tests.studies.sweeps import BAD_SIZE, FATAL, broken, noted, peak, small
from tests.studies.test_engine import address as address

MEMBERS, FAILING = 64, 6
COSTS = ["seconds", "cpu_seconds"]


def plan_of_64(folder: Path) -> object:
    """64 members with 64 grids, of which six are too small."""
    sizes = [BAD_SIZE if number % 11 == 3 else 40 + number for number in range(MEMBERS)]
    changes = [{"grid.size": size, "title": f"number {number}"} for number, size in enumerate(sizes)]
    return listed(small(), changes)


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """The table of the same members, one after the other in this process, none killed."""
    folder = tmp_path_factory.mktemp("here")
    return sweep(plan_of_64(folder), folder=folder / "sweep", quantities={"peak": peak}, tracked=False)  # type: ignore[arg-type]


@pytest.mark.parametrize("where", ["processes", "cluster"])
def test_64_members_of_which_6_fail_and_one_loses_its_process(
    where: str, expected: xr.Dataset, tmp_path: Path, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NOTES", str(tmp_path))
    if where == "processes":
        engine: Engine = Processes(2)
        (tmp_path / FATAL).touch()
    else:
        engine = Cluster(request.getfixturevalue("address"))
    table = sweep(plan_of_64(tmp_path), folder=tmp_path / "sweep", engine=engine, quantities={"peak": peak}, tracked=False)  # type: ignore[arg-type]
    xr.testing.assert_identical(*(one.drop_vars(COSTS).drop_attrs() for one in (table, expected)))
    assert Counter(table["status"].values.tolist()) == {"complete": MEMBERS - FAILING, "failed": FAILING}
    assert all("choose at least 9 points" in reason for reason in table["reason"].values if reason)
    if where == "processes":
        assert not (tmp_path / FATAL).exists()
        times = Counter(line.split("-")[0] for line in noted(tmp_path))
        assert times.pop("61") == 2
        assert set(times.values()) == {1}


def test_members_are_the_runs_themselves(tmp_path: Path) -> None:
    result = sweep(small(), {"grid.size": [60, 80]}, tmp_path / "sweep")
    for size in (60, 80):
        name = result["name"].sel(size=size).item()
        with xr.open_dataset(tmp_path / "sweep" / "members" / f"{name}.nc") as member:
            np.testing.assert_array_equal(member.W.values, run(small(size)).W.values)
            assert Simulation.from_json(member.attrs["simulation"]) == small(size)
    with xr.open_dataset(tmp_path / "sweep" / TABLE) as stored:
        xr.testing.assert_equal(stored.load(), result)
    assert result["height_before"].dims == ("size", "wave")


def test_the_same_call_does_what_is_missing_or_failed_and_no_more(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NOTES", str(tmp_path))
    seen: list[Progress] = []
    varied: dict[str, list[Any]] = {"grid.size": [50, 52, BAD_SIZE], "integrator": [Rosenbrock(), Rosenbrock(rtol=1e-5)]}

    def again() -> xr.Dataset:
        seen.clear()
        return sweep(small(), varied, tmp_path / "sweep", quantities={"peak": peak}, tell=seen.append)

    first = again()
    assert [one.done for one in seen] == [0, 1, 2, 3, 4, 5, 6]
    assert (seen[-1].failed, seen[-1].total) == (2, 6)
    second = again()
    assert [one.done for one in seen] == [4, 5, 6]
    assert len(noted(tmp_path)) == 4
    xr.testing.assert_identical(first.drop_vars(COSTS).drop_attrs(), second.drop_vars(COSTS).drop_attrs())
    next((tmp_path / "sweep" / "members").glob("*.nc")).unlink()
    again()
    assert len(noted(tmp_path)) == 5


def test_members_that_come_to_one_simulation_run_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NOTES", str(tmp_path))
    result = sweep(small(), {"grid.size": [60, "60"], "t_end": [0.2]}, tmp_path / "sweep", quantities={"peak": peak})
    assert len(noted(tmp_path)) == 1
    assert result["peak"].values[0, 0] == result["peak"].values[1, 0] > 1


def test_a_quantity_that_cannot_be_read_is_a_reason(tmp_path: Path) -> None:
    result = sweep(small(), {"grid.size": [60]}, tmp_path / "sweep", quantities={"broken": broken}, tracked=False)
    assert result["status"].item() == "failed"
    assert "The quantity broken cannot be read from the result (AttributeError" in result["reason"].item()


def test_what_cannot_be_swept_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="Give a plan, or a simulation and what is varied"):
        sweep(small(), None, tmp_path / "sweep")
    with pytest.raises(InputError, match="Give a plan, or a simulation and what is varied"):
        sweep(product(small(), {"t_end": [1]}), {"t_end": [1]}, tmp_path / "sweep")
    sweep(small(), {"grid.size": [60]}, tmp_path / "sweep", tracked=False)
    with pytest.raises(InputError, match="holds another study"):
        sweep(small(), {"grid.size": [80]}, tmp_path / "sweep", tracked=False)


STUDY = """
import sys
from pathlib import Path
from mol_compactons.studies.engine import Processes
from mol_compactons.studies.sweep import sweep
from tests.studies.sweeps import small
if __name__ == "__main__":
    sweep(small(), {"grid.size": range(60, 80), "t_end": [2]}, Path(sys.argv[1]), engine=Processes(2), tracked=False)
"""


@pytest.mark.parametrize("kills", [1, pytest.param(10, marks=pytest.mark.slow)])
def test_a_study_that_is_killed_goes_on_and_loses_at_most_what_was_on_its_way(kills: int, tmp_path: Path) -> None:
    command, folder = [sys.executable, "-c", STUDY, str(tmp_path / "sweep")], tmp_path / "sweep"
    source = random.Random(kills)
    for _ in range(kills):
        before = rows_of(folder)
        with subprocess.Popen(command) as study:
            wanted = len(before) + source.randint(0, 2)
            delay = source.uniform(0, 0.3)
            while study.poll() is None and len(rows_of(folder)) < wanted:
                time.sleep(0.02)
            time.sleep(delay)
            study.kill()
        assert all(rows_of(folder)[name] == row for name, row in before.items())
    subprocess.run(command, check=True)
    lines = (folder / "rows.jsonl").read_text(encoding="utf-8").splitlines()
    assert len(rows_of(folder)) == len(lines) == 20
    assert {row["status"] for row in rows_of(folder).values()} == {"complete"}
    whole = sweep(small(), {"grid.size": range(60, 80), "t_end": [2]}, tmp_path / "serial", engine=Here(), tracked=False)
    with xr.open_dataset(folder / TABLE) as stored:
        xr.testing.assert_equal(stored.drop_vars(COSTS).load(), whole.drop_vars(COSTS))


def test_a_signal_ends_a_sweep_in_order(tmp_path: Path) -> None:
    folder = tmp_path / "sweep"
    with subprocess.Popen([sys.executable, "-c", STUDY, str(folder)], stderr=subprocess.DEVNULL) as study:
        while study.poll() is None and not rows_of(folder):
            time.sleep(0.02)
        study.send_signal(signal.SIGTERM)
        assert study.wait(timeout=60) != 0
    assert 1 <= len(rows_of(folder)) < 20


def test_the_script_of_the_page_runs_as_it_stands(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "sweeps.md").read_text(encoding="utf-8")
    (tmp_path / "script.py").write_text(page.split("```python\n")[1].split("```")[0], encoding="utf-8")
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "grid_viscosity" in done.stdout
    assert "<xarray.DataArray 'W' (speed: 3, grid_viscosity: 2)>" in done.stdout
