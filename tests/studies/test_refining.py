from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import InputError, open_sweep, refine
from mol_compactons.studies.criterion import Criterion
from mol_compactons.studies.engine import Here, Lost
from mol_compactons.studies.refining import MOST_VALUES, UNFINISHED, _divided, _parts_of
from mol_compactons.studies.store import rows_of
from mol_compactons.studies.sweep import TABLE
from tests.studies.sweeps import small


def final_height(dataset: xr.Dataset) -> float:
    return float(dataset.W[-1].max())


def test_it_finds_the_smallest_grid_that_is_allowed(tmp_path: Path) -> None:
    """A grid of fewer than nine points is refused."""
    table = refine(small(), "grid.size", [3, 60], tmp_path / "r", tracked=False)
    sizes, outcomes = table["size"].values, table["outcome"].values.tolist()
    assert sizes.dtype.kind == "i"
    change = outcomes.index("complete")
    assert set(outcomes[:change]) == {"failed"}
    assert set(outcomes[change:]) == {"complete"}
    assert sizes[change] - sizes[change - 1] == 1
    assert "at least 2 are needed" in table["reason"].values[change - 1] or "points" in table["reason"].values[change - 1]


def test_it_finds_the_speed_at_which_a_compacton_has_a_height(tmp_path: Path) -> None:
    """For n = 3 the height is sqrt(2 c), which is 1.2 at c = 0.72; the grid has a point in the crest."""
    arguments = {"outcome": "peak > 1.2", "accuracy": 0.001, "quantities": {"peak": final_height}, "tracked": False}
    table = refine(small(300), "initial.0.speed", [0.1, 2.0], tmp_path / "r", **arguments)  # type: ignore[arg-type]
    outcomes, speeds = table["outcome"].values, table["speed"].values
    change = outcomes.tolist().index("yes")
    assert speeds[change - 1] < 0.72 * 1.01
    assert speeds[change] > 0.72 * 0.99
    assert speeds[change] - speeds[change - 1] <= 0.001 * speeds[change]
    assert len(speeds) < 2 + math.log2(2 / 0.001 / 0.72) + 3
    with xr.open_dataset(tmp_path / "r" / TABLE) as stored:
        xr.testing.assert_equal(stored.load(), table)
    before = len((tmp_path / "r" / "rows.jsonl").read_text(encoding="utf-8").splitlines())
    again = refine(small(300), "initial.0.speed", [0.1, 2.0], tmp_path / "r", **arguments)  # type: ignore[arg-type]
    assert len((tmp_path / "r" / "rows.jsonl").read_text(encoding="utf-8").splitlines()) == before, "nothing runs twice"
    xr.testing.assert_equal(again, table)
    members = open_sweep(tmp_path / "r")
    assert members.W.dims == ("speed", "t", "x")
    np.testing.assert_allclose(members.W.isel(t=-1).max("x").values, table["peak"].values)


def test_it_divides_no_interval_whose_ends_come_out_alike(tmp_path: Path) -> None:
    table = refine(small(), "initial.0.speed", [0.5, 0.6, 0.7], tmp_path / "r", tracked=False)
    assert table.sizes["speed"] == 3
    assert len(rows_of(tmp_path / "r")) == 3


@given(st.floats(0.011, 99), st.integers(2, 7), st.floats(1e-4, 0.3))
def test_a_change_is_enclosed_as_closely_as_asked_wherever_it_is(place: float, parts: int, accuracy: float) -> None:
    tried, refined = [0.01, 100.0], {"accuracy": accuracy, "parts": parts}
    rounds = 0
    while more := _parts_of(tried, ["yes" if value > place else "no" for value in tried], refined):
        assert not set(tried) & set(more)
        tried, rounds = sorted([*tried, *more]), rounds + 1
    low, high = max(value for value in tried if value <= place), min(value for value in tried if value > place)
    assert high - low <= accuracy * high
    assert len(tried) == 2 + rounds * (parts - 1)
    assert rounds <= math.ceil(math.log(1e4, parts)) + math.ceil(math.log(2 / accuracy, parts)) + 2


@given(st.sampled_from([[0.0, 1.0], [-3.0, 0.0], [-2.0, 5.0]]), st.booleans())
def test_a_change_at_zero_is_enclosed_relative_to_the_range(ends: list[float], at_zero: bool) -> None:
    tried, refined = ends, {"accuracy": 0.01, "parts": 2}
    while more := _parts_of(tried, ["yes" if value > 0 or (at_zero and value == 0) else "no" for value in tried], refined):
        tried = sorted([*tried, *more])
    assert len(tried) < 40


@given(st.integers(-50, 50), st.integers(1, 60), st.integers(2, 9))
def test_whole_numbers_are_divided_into_whole_numbers(low: int, apart: int, parts: int) -> None:
    values = _divided(low, low + apart, parts, whole=True)
    assert all(isinstance(value, int) and low < value < low + apart for value in values)
    assert bool(values) == (apart > 1) or apart < parts


def test_where_the_outcome_changes_everywhere_it_says_that_it_is_not_finished(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mol_compactons.studies.refining.MOST_VALUES", 6)
    monkeypatch.setattr(Criterion, "of", lambda self, row: row["name"])
    table = refine(small(), "initial.0.speed", [0.5, 1.0], tmp_path / "r", tracked=False, accuracy=1e-6)
    assert table.sizes["speed"] == 5
    assert "ended at 5 values, before the accuracy was reached" in table.attrs[UNFINISHED]
    assert MOST_VALUES == 1000


def test_numbers_are_what_the_field_has_however_they_are_typed(tmp_path: Path) -> None:
    asked = {"outcome": "peak > 1.2", "accuracy": 0.1, "quantities": {"peak": final_height}, "tracked": False}
    table = refine(small(), "initial.0.speed", [2, 3], tmp_path / "s", outcome="mass_drift > 1", tracked=False)
    assert table["speed"].dtype.kind == "f"
    table = refine(small(150), "initial.0.speed", [0.5, 1], tmp_path / "f", **asked)  # type: ignore[arg-type]
    assert table.sizes["speed"] > 3
    table = refine(small(), "grid.size", np.array([60.0, 64.0]).tolist(), tmp_path / "i", tracked=False)
    assert table["size"].dtype.kind == "i"


class Losing(Here):
    """An engine that loses the process of some members."""

    def results(self, work: Any, tasks: Any, watch: Any = None) -> Any:
        for number, task in enumerate(tasks):
            yield number, (Lost("its process was killed") if task.changes["grid.size"] == 96 else work(task))


def test_a_lost_member_has_no_outcome_and_runs_again(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="1 members have no outcome, the first because its process was killed; run the same"):
        refine(small(), "grid.size", [60, 96], tmp_path / "r", engine=Losing(), tracked=False)
    table = refine(small(), "grid.size", [60, 96], tmp_path / "r", tracked=False)
    assert table["outcome"].values.tolist() == ["complete", "complete"]


def test_a_quantity_that_nobody_has_leaves_a_folder_that_can_be_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"asks for momentm_drift, which no member has; they have .*momentum_drift"):
        refine(small(), "grid.size", [60, 80], tmp_path / "r", outcome="momentm_drift > 1", tracked=False)
    members = open_sweep(tmp_path / "r")
    assert isinstance(members, xr.DataTree)
    assert members.to_dataset()["outcome"].values.tolist() == ["unknown", "unknown"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"values": [1.0]}, "two numbers or more that grow, not with .1.0"),
        ({"values": [2.0, 1.0]}, "that grow"),
        ({"values": ["a", "b"]}, "that grow"),
        ({"values": [0.5, math.inf]}, "that grow"),
        ({"accuracy": 0}, "accuracy = 0 must lie between"),
        ({"parts": 1}, "parts = 1 must lie between 2 and 100"),
        ({"path": "nothing"}, "is not a field"),
        ({"outcome": "height > > 2"}, "is not understood; write status"),
        ({"path": "title"}, "title.* is no number, and cannot be refined"),
        ({"path": "grid.size", "values": [60.5, 80]}, "grid.size.* has whole numbers"),
    ],
)
def test_bad_input_is_named(tmp_path: Path, arguments: dict[str, object], words: str) -> None:
    own = {"path": "initial.0.speed", "values": [0.5, 1.0], "folder": tmp_path / "r", "tracked": False}
    with pytest.raises(InputError, match=words.replace("(", r"\(")):
        refine(small(), **own | arguments)  # type: ignore[arg-type]
