from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from mol_compactons.pages.document import Page, Section
from mol_compactons.pages.sweeps import MOST_ROWS, page_of_sweep
from mol_compactons.studies.store import plan_of


@pytest.fixture(scope="module")
def table(swept: Path) -> xr.Dataset:
    with xr.open_dataset(swept / "table.nc") as dataset:
        return dataset.load()


def part(page: Page, name: str) -> Section:
    (found,) = [section for section in page.sections if section.name == name]
    return found


def test_each_member_is_a_row_and_each_failure_has_its_reason(table: xr.Dataset, swept: Path) -> None:
    page = page_of_sweep(table, plan_of(swept))
    (members,) = part(page, "members").tables
    assert [row[2] for row in members.rows] == table["status"].values.ravel().tolist()
    assert page.title.startswith("Sweep over grid.size, scheme.viscosity: ")
    assert page.lead == ["9 members: 6 complete, 3 failed"]
    (reasons,) = part(page, "failures").tables
    assert [row[0] for row in reasons.rows] == ["3"]
    assert "grid.size = 3" in reasons.rows[0][1]


def test_lines_and_maps_are_the_table(table: xr.Dataset, swept: Path) -> None:
    lines, maps = part(page_of_sweep(table, plan_of(swept)), "quantities").pictures
    name = "largest momentum drift"
    assert lines.choices
    assert maps.choices
    drawn = [lines.figure.data[number] for number in lines.choices[name]]
    expected = table["momentum_drift"].values.T
    np.testing.assert_array_equal(np.array([one.y for one in drawn], dtype=float), expected)
    (place,) = maps.choices[name]
    np.testing.assert_array_equal(np.array(maps.figure.data[place].z, dtype=float), expected)
    assert [one.visible for one in maps.figure.data].count(True) == 1


def test_of_very_many_members_the_first_are_listed(table: xr.Dataset, swept: Path) -> None:
    many = xr.concat([table] * 100, "size")
    (members,) = part(page_of_sweep(many, plan_of(swept)), "members").tables
    assert len(members.rows) == MOST_ROWS
    assert f"The first {MOST_ROWS} of 900" in part(page_of_sweep(many, plan_of(swept)), "members").text[0]


def test_parts_may_be_varied(swept: Path) -> None:
    table = xr.Dataset(
        {"status": ("scheme", ["complete"] * 2), "reason": ("scheme", ["", ""]), "error": ("scheme", [1.0, np.nan])},
        {"scheme": ["A(<b>)", "B"]},
    )
    (lines,) = part(page_of_sweep(table, plan_of(swept)), "quantities").pictures
    assert list(lines.figure.data[0].x) == ["A(&lt;b&gt;)", "B"]
