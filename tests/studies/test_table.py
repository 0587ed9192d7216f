from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mol_compactons import CompactScheme, FourierScheme
from mol_compactons.studies.plan import Axis, Plan, product
from mol_compactons.studies.table import MISSING, table
from tests.studies.sweeps import small


def row(places: list[list[int]], status: str = "complete", reason: str = "", **quantities: Any) -> dict[str, Any]:
    name = f"m{places}"
    return {"name": name, "places": places, "status": status, "reason": reason, "seconds": 1.5, "quantities": quantities}


PLANNED = product(small(), {"grid.size": [60, 80, 100], "scheme": [CompactScheme(), FourierScheme()]}).described()


def test_rows_stand_where_their_members_do() -> None:
    rows = [row([[0, 0]], height=1.25, drift=1e-3), row([[2, 1], [1, 1]], height=2.5), row([[0, 1]], "failed", "too small")]
    result = table(PLANNED, rows)
    assert dict(result.sizes) == {"size": 3, "scheme": 2}
    assert float(result.height.sel(size=60)[0]) == 1.25
    assert result.height.values[:, 1].tolist()[1:] == [2.5, 2.5]
    assert np.isnan(result.drift.values).sum() == 5
    assert result.status.values.tolist() == [["complete", "failed"], [MISSING, "complete"], [MISSING, "complete"]]
    assert result.reason.values[0, 1] == "too small"
    assert result.size.attrs["field"] == "grid.size"
    assert result.scheme.values.tolist() == ["CompactScheme()", "FourierScheme()"]
    assert result.seconds.attrs["units"] == "s"


def test_what_members_have_of_each_wave_has_room_for_all() -> None:
    result = table(PLANNED, [row([[0, 0]], speed_after=[1.0, 0.25, 0.1]), row([[1, 0]], speed_after=[2.0]), row([[2, 0]])])
    assert result.speed_after.dims == ("size", "scheme", "wave")
    assert result.speed_after.values[0, 0].tolist() == [1.0, 0.25, 0.1]
    assert np.isnan(result.speed_after.values[1, 0]).tolist() == [False, True, True]
    assert np.isnan(result.speed_after.values[2]).all()


def test_values_are_numbers_where_they_can_be() -> None:
    plan = Plan(small(), [Axis({"t_end": ["1", "2.5"]}), Axis({"grid.size": [60, 80], "title": ["a", "b"]})])
    result = table(plan.described(), [])
    assert result.t_end.values.tolist() == [1.0, 2.5]
    assert result["size"].dims == result["title"].dims == ("member_1",)
    assert result["title"].values.tolist() == ["a", "b"]
    assert set(result.status.values.ravel()) == {MISSING}


@pytest.mark.parametrize("values", [[True, False], ["a", "1"], [None, 1]])
def test_others_are_words(values: list[Any]) -> None:
    plan = {"axes": [{"dimension": "d", "fields": {"f": {"name": "d", "values": values, "told": [*map(str, values)]}}}]}
    assert table(plan, []).d.values.tolist() == [*map(str, values)]
