"""What a study says is put beside the truth, and a bar that does not hold it is found."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.verdicts import __main__ as command
from benchmarks.verdicts import chains, traps
from benchmarks.verdicts.__main__ import FAMILIES, Tally, report
from benchmarks.verdicts.known import Known, NoTrapError, Row, Truth, rows
from mol_compactons import Family, InputError
from mol_compactons.studies.judgement import CONVERGED, CONVERGING, NOT_CONVERGED

VERDICTS = (CONVERGED, CONVERGING, NOT_CONVERGED)


def shown(*families: Callable[[], Known], every: bool = False) -> tuple[int, list[str]]:
    lines: list[str] = []
    return report(families, every, lines.append), lines


def row(verdict: str, value: float, bar: float, truth: float = 1.0, uncertainty: float = 0.0) -> Row:
    return Row("family", "inviscid", "height 0", verdict, value, bar, truth, uncertainty, scale=1, accuracy=0.01, reason="")


def test_there_are_thirty_families_or_more_each_with_a_name_of_its_own() -> None:
    names = [family.__name__ for family in FAMILIES]
    assert len(names) == len(set(names)) >= 30


def test_an_exact_wave_of_a_chain_is_recognised() -> None:
    status, (_, line, total) = shown(chains.chain_cubic)
    assert status == 0
    assert line.split() == ["chain_cubic", "7", "7", "0", "0"]
    assert total.split()[-4:] == ["7", "7", "0", "0"]


def test_a_planted_false_one_is_reported_with_value_bar_and_truth() -> None:
    def planted() -> Known:
        known = chains.chain_cubic()
        return replace(known, truths={**known.truths, "height 0": Truth(1.001 * known.truths["height 0"].value)})

    status, (_, line, said, total) = shown(planted)
    assert status == 1
    assert line.split() == ["planted", "7", "6", "1", "0"]
    assert said.split()[:3] == ["FALSE", "inviscid", "height"]
    (found,) = (row for row in rows("planted", planted()) if row.is_false)
    for number in (f"{found.value:.7g}", f"+- {found.bar:.1e}", f"truth {found.truth:.7g}"):
        assert number in said
    assert total.split()[-4:] == ["7", "6", "1", "0"]


def test_what_no_other_scheme_bears_out_is_right_and_not_recognised() -> None:
    def coarse() -> Known:
        known = traps.one_scheme()
        return replace(known, family=Family(sizes=(40, 80, 160), schemes=known.family.schemes, accuracy=0.05))

    status, lines = shown(coarse, every=True)
    judged, converged, false, unrecognised = (int(number) for number in lines[1].split()[1:])
    assert (status, judged, converged, false) == (0, 10, 0, 0)
    assert unrecognised > 5
    assert sum("not recognised " in line for line in lines[2:-1]) == unrecognised
    assert len(lines) == 3 + judged


def test_what_shows_the_trap_of_a_family_stands_below_it() -> None:
    status, (_, line, seen, _) = shown(
        lambda: replace(chains.chain_cubic(), trap=lambda study: f"{study.attrs['title']} fell")
    )
    assert status == 0
    assert line.split()[1:] == ["7", "7", "0", "0"]
    assert seen.strip().startswith("Convergence of")
    assert seen.endswith(" fell")


def test_a_family_without_its_trap_is_a_failure() -> None:
    def harmless() -> Known:
        return replace(chains.chain_cubic(), trap=partial(traps.some_died, sizes=(30,)))

    status, lines = shown(harmless)
    assert status == 1
    assert lines[1].startswith("harmless could not be run: members that failed should be those of CompactScheme for N = (30,)")
    assert lines[-1].split() == ["sum", "of", "0", "families", "0", "0", "0", "0"]


DEATHS = [
    ("CompactScheme(second_difference=wide) N=80 viscosity", "CompactScheme(second_difference=wide) N=40 viscosity"),
    ("CompactScheme(second_difference=wide) N=80 viscosity", "ConservativeScheme(order=4) N=80 viscosity"),
    (),
]


def test_a_scheme_dies_on_the_grids_that_are_named_and_on_no_others() -> None:
    def study(*failed: str) -> xr.DataTree:
        return xr.DataTree(xr.Dataset(attrs={"failed": "\n".join(f"inviscid {one}=0: gave up" for one in failed)}))

    assert "1 members failed" in traps.some_died(study(DEATHS[0][0]), sizes=(80,))
    for failed in DEATHS:
        with pytest.raises(NoTrapError):
            traps.some_died(study(*failed), sizes=(80,))


@given(st.floats(-1, 1), st.floats(0, 0.2))
def test_it_is_too_early_where_only_waiting_tells(apart: float, uncertainty: float) -> None:
    parts = {"space": 0.1, "time": 0.05, "viscosity": 0.02, "scheme": 0.03, "settling": 9.0, "reading": 9.0}
    columns = {name: (("limit", "quantity"), [[value]]) for name, value in (parts | {"value": 2 + apart}).items()}
    summary = xr.Dataset(columns, {"limit": ["inviscid"], "quantity": ["speed 0"]})
    study, truth = xr.DataTree.from_dict({"/summary": summary}), Truth(2.0, uncertainty)
    if abs(apart) - uncertainty > 0.2 + 1e-12:
        assert "truth 2" in traps.too_early(study, "speed 0", truth)
    elif abs(apart) - uncertainty < 0.2 - 1e-12:
        with pytest.raises(NoTrapError, match="truth 2"):
            traps.too_early(study, "speed 0", truth)


def test_a_family_that_cannot_be_run_is_named() -> None:
    def impossible() -> Known:
        raise InputError("no such wave")

    status, lines = shown(impossible)
    assert status == 1
    assert "impossible could not be run: no such wave" in lines
    assert lines[-1].split() == ["sum", "of", "0", "families", "0", "0", "0", "0"]


@given(st.sampled_from(VERDICTS), st.floats(-0.1, 0.1), st.floats(1e-9, 0.2), st.floats(0, 0.01))
def test_a_verdict_is_false_where_the_bar_does_not_hold_the_truth(
    verdict: str, distance: float, bar: float, uncertainty: float
) -> None:
    one = row(verdict, 1 + distance, bar, uncertainty=uncertainty)
    apart = abs(one.value - 1) - uncertainty
    assert one.is_false == (verdict == CONVERGED and apart > max(bar, 1e-12))
    assert one.is_right == (verdict == CONVERGED and not one.is_false)
    assert one.is_unrecognised == (verdict != CONVERGED and apart <= 0.01)
    assert Tally.of([one, one]) == Tally(2, 2 * one.is_right, 2 * one.is_false, 2 * one.is_unrecognised)


def test_a_value_that_is_not_a_number_is_false_if_called_converged() -> None:
    assert row(CONVERGED, math.nan, 1.0).is_false
    assert not row(NOT_CONVERGED, math.nan, math.nan).is_unrecognised
    assert row(CONVERGED, 1 + 1e-14, 0.0).is_right


def test_the_command_runs_those_that_are_named(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["verdicts", "--only", "chain_cub"])
    assert command.main() == 0
    assert "sum of 1 families" in capsys.readouterr().out
    monkeypatch.setattr(sys, "argv", ["verdicts", "--only", "no such family"])
    with pytest.raises(SystemExit):
        command.main()
    assert "chain_cubic" in capsys.readouterr().err


@pytest.mark.slow
def test_no_verdict_is_false() -> None:
    status, lines = shown(*FAMILIES)
    assert status == 0, "\n".join(lines)
