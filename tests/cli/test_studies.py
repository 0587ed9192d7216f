from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import pytest
import xarray as xr

from mol_compactons import Family
from mol_compactons.cli.parser import main
from mol_compactons.cli.studies import FAMILY_OPTIONS


def test_stability_prints_its_verdicts_and_stores_the_report(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stability", "n=2", "sizes=20,40,80", "-o", "report.nc"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-2].startswith("verdict: stable")
    assert lines[-1] == "wrote report.nc"
    with xr.open_dataset("report.nc") as dataset:
        assert {"eigenvalue", "growth", "functional", "I", "J"} <= set(dataset.data_vars)
    assert main(["stability", "sizes=20,40,80", "-o", "report.png"]) == 0
    assert Path("report.png").read_bytes().startswith(b"\x89PNG")


def test_converge_stores_prints_and_draws(capsys: pytest.CaptureFixture[str]) -> None:
    quick = [
        "--set",
        "t_end=0.5",
        "--set",
        "frames=11",
        "--set",
        "equation.n=2",
        "--viscosities",
        "2e-3,1e-3",
        "--workers",
        "1",
    ]
    family = [
        "--workers",
        "1",
        "--sizes",
        "60,90,120",
        "--schemes",
        "ConservativeScheme(order=4),CompactScheme",
        "--tolerances",
        "1e-4,1e-5",
    ]
    assert main(["converge", "single_compacton", "-o", "study.nc", *quick, *family]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("1/14 viscous ConservativeScheme(order=4) N=60")
    assert any(line.startswith("viscous limit: ") for line in lines)
    assert main(["info", "study.nc"]) == 0
    assert "  profile" in capsys.readouterr().out
    assert main(["plot", "study.nc"]) == 0
    assert Path("study.png").read_bytes().startswith(b"\x89PNG")
    with xr.open_datatree("study.nc") as tree:
        assert set(tree.children) == {"summary", "ladder", "profile", "schemes", "members"}
    assert main(["run", "study.nc", "-o", "again.nc", "--quiet"]) == 0
    assert {path.name for path in Path().iterdir()} == {"study.nc", "study.png", "again.nc"}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--sizes", "60,none"], "must be a list of a whole number"),
        (["--schemes", "FurierScheme"], "must be a list of"),
        (["--schemes", "NearestNeighbours,CompactScheme"], "NearestNeighbours does not suit GranularCompacton"),
        (["--sizes", "4,8,16"], "is too small"),
        (["-o", "study.txt"], "must end in .nc"),
        (["--accuracy", "0"], "accuracy = 0 must lie between"),
    ],
)
def test_bad_options_are_one_sentence(options: list[str], words: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["converge", "single_compacton", "--workers", "1", *options]) == 2
    printed = capfd.readouterr().err
    assert words in printed
    assert len(printed.splitlines()) == 1
    assert not list(Path().iterdir())


def test_every_field_of_a_family_is_an_option() -> None:
    assert list(FAMILY_OPTIONS) == [field.name for field in fields(Family)]


def test_a_study_can_be_drawn_without_being_stored(capsys: pytest.CaptureFixture[str]) -> None:
    quick = ["--workers", "1", "--set", "t_end=0.2", "--set", "frames=3", "--quiet"]
    family = ["--sizes", "60,90", "--schemes", "ConservativeScheme(order=4)", "--tolerances", "1e-4", "--viscosities", "1e-3"]
    assert main(["converge", "single_compacton", "-o", "study.png", *quick, *family]) == 0
    assert Path("study.png").read_bytes().startswith(b"\x89PNG")
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "viscous limit: not converged"
    assert lines[-1] == "wrote study.png"
    assert [path.name for path in Path().iterdir()] == ["study.png"]


def test_the_accuracy_is_one_number_and_not_a_list() -> None:
    quick = ["--workers", "1", "--set", "t_end=0.2", "--set", "frames=3", "--quiet", "--accuracy", "0.5"]
    family = ["--sizes", "60,90", "--schemes", "[ConservativeScheme]", "--tolerances", "1e-4", "--viscosities", "1e-3"]
    assert main(["converge", "single_compacton", "-o", "study.nc", *quick, *family]) == 0
    with xr.open_datatree("study.nc") as tree:
        assert '"accuracy": 0.5' in tree.attrs["family"]
        assert '"sizes": [60, 90]' in tree.attrs["family"]
