from __future__ import annotations

import numpy as np
import xarray as xr

from mol_compactons import CompactScheme, ConservativeScheme, Family, judge
from mol_compactons.studies.judgement import CONVERGED, CONVERGING, NOT_CONVERGED
from mol_compactons.studies.report import differences_of_limits, report, verdict
from tests.studies.by_hand import spacing, study

BOTH = (ConservativeScheme(), CompactScheme())


def summary(verdicts: list[list[str]]) -> xr.Dataset:
    limits = ["conservative", "viscous"][: len(verdicts)]
    return xr.Dataset(
        {"verdict": (("limit", "quantity"), verdicts)},
        {"limit": limits, "quantity": ["profile", "height 0"][: len(verdicts[0])]},
    )


def test_the_worst_verdict_counts() -> None:
    table = summary([[CONVERGED, CONVERGED], [CONVERGED, CONVERGING]])
    assert verdict(table, "conservative") == CONVERGED
    assert verdict(table, "viscous") == CONVERGING
    assert verdict(summary([[CONVERGING, NOT_CONVERGED]]), "conservative") == NOT_CONVERGED


def test_a_table_for_each_limit_with_the_numbers_of_the_summary() -> None:
    tree = judge(study(lambda member: 1e-3 * spacing(member) ** 2))
    lines = report(tree)
    row = tree["summary"].to_dataset().sel(limit="inviscid", quantity="profile")
    assert lines[0] == "inviscid limit: converged"
    assert " ".join(lines[1].split()) == (
        "quantity value error = space + time + viscosity + scheme + settling + reading rate error / scale, verdict"
    )
    (line,) = [line for line in lines if line.startswith("  profile")]
    numbers = line.split()
    assert float(numbers[1]) == float(f"{float(row.value):.6g}")
    assert float(numbers[2]) == float(f"{float(row.error):.1e}")
    assert "  2.00  " in line
    assert line.endswith(f"converged: {row.reason.item()}")
    table = tree["schemes"].to_dataset().isel(n=0, size=-1)
    *rows, title, first, second = lines[1:]
    assert len(rows) == 1 + tree["summary"].sizes["quantity"]
    assert title == "schemes on 240 points; errors against the exact wave:"
    for line, scheme in zip((first, second), table["scheme"].values, strict=True):
        assert line.startswith(f"  {scheme}: error {float(table['error'].sel(scheme=scheme)):.1e}, order 2.00, ")


def test_the_headline_is_the_worst_verdict_of_the_table() -> None:
    """Errors that grow as the grid is refined: neither the headline nor the line of the profile says converged."""
    tree = judge(study(lambda member: 0.1 * np.sign(0.3 - spacing(member)) / spacing(member)))
    row = tree["summary"].to_dataset().sel(limit="inviscid", quantity="profile")
    assert row["verdict"].item() == NOT_CONVERGED
    lines = report(tree)
    assert lines[0] == f"inviscid limit: {NOT_CONVERGED}"
    (line,) = [line for line in lines if line.startswith("  profile")]
    assert f" {NOT_CONVERGED}: " in line


def test_what_failed_is_named_at_the_end() -> None:
    tree = judge(study(lambda member: 0.0))
    tree.attrs["failed"] = "one: gave up\nother: gave up too"
    assert report(tree)[-2:] == ["failed and not counted: one: gave up", "failed and not counted: other: gave up too"]


def test_the_headline_says_how_many_members_failed() -> None:
    """Even where what is left of the study agrees."""
    tree = judge(study(lambda member: 0.0, Family(schemes=BOTH), fails=lambda member: member.size == 240))
    lines = report(tree)
    assert lines[0] == "inviscid limit: converging; 4 of 8 members failed"
    assert len([line for line in lines if line.startswith("failed and not counted")]) == 4


def test_a_study_stored_before_there_were_all_parts_is_read() -> None:
    tree = judge(study(lambda member: 0.0))
    old = tree["summary"].to_dataset().drop_vars(["settling", "reading", "failed", "members"])
    lines = report(xr.DataTree.from_dict({"/": xr.Dataset(attrs=tree.attrs), "/summary": old}))
    assert lines[0] == "inviscid limit: converged"
    assert "settling" not in lines[1]
    assert "reading" not in lines[1]
    assert len(lines) == 2 + old.sizes["quantity"]


def two_limits(apart: float, bar: float) -> xr.Dataset:
    return xr.Dataset(
        {
            "value": (("limit", "quantity"), [[1.0, 5.0], [1.0 + apart, 7.0]]),
            "error": (("limit", "quantity"), [[bar, 0.0], [bar, 0.0]]),
        },
        {"limit": ["conservative", "viscous"], "quantity": ["height 0", "profile"]},
    )


def test_limits_differ_where_they_are_farther_apart_than_twice_their_error_bars() -> None:
    """Not the profile, whose value is a norm that says nothing of a distance."""
    assert differences_of_limits(two_limits(0.5, 0.1)) == [
        "height 0: the conservative and the viscous limit differ by 0.5, and their error bars add up to 0.2"
    ]
    assert differences_of_limits(two_limits(0.39, 0.1)) == []
    assert differences_of_limits(two_limits(-0.5, 0.1)) != []
    assert differences_of_limits(two_limits(0.5, 0.1).isel(limit=[0])) == []


def test_both_limits_of_a_study_are_reported() -> None:
    family = Family(schemes=BOTH, viscosities=(2e-3, 1e-3), grid_viscosities=(0.2, 0.1))
    lines = report(judge(study(lambda member: 0.0, family)))
    assert [line for line in lines if "limit: " in line] == ["conservative limit: converged", "viscous limit: converged"]
