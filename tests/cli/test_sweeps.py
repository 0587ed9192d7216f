from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from mol_compactons.cli.parser import main
from mol_compactons.cli.sweeps import values_of

QUICK = ["--set", "t_end=0.2", "--set", "frames=3", "--set", "integrator=Rosenbrock", "--workers", "1"]


def test_a_sweep_runs_is_told_and_goes_on(capfd: pytest.CaptureFixture[str]) -> None:
    command = ["sweep", "single_compacton", "--vary", "grid.size=5,60", "--vary", "scheme.viscosity=geomspace(1e-4, 1e-2, 3)"]
    for _ in range(2):
        assert main([*command, *QUICK]) == 0
        lines = capfd.readouterr().out.splitlines()
        assert lines[0] == "6 members: 3 complete, 3 failed"
        assert lines[1].startswith("failed 3 times: grid.size = 5 is too small")
        assert lines[-1] == "wrote single_compacton_sweep/table.nc"
    with xr.open_dataset("single_compacton_sweep/table.nc") as table:
        assert table["viscosity"].values == pytest.approx([1e-4, 1e-3, 1e-2])
        assert (table["momentum_drift"].sel(size=60).diff("viscosity") > 0).all()
    assert main(["info", "single_compacton_sweep"]) == 0
    told = capfd.readouterr().out
    assert "varied: grid.size = 5, 60" in told
    assert "momentum_drift: " in told
    assert main(["plot", "single_compacton_sweep"]) == 0
    assert Path("single_compacton_sweep.png").read_bytes().startswith(b"\x89PNG")
    assert len(list(Path("single_compacton_sweep/members").glob("*.nc"))) == 3


def test_fields_together_and_random_values(capfd: pytest.CaptureFixture[str]) -> None:
    both = ["--vary", "grid.size=60,80", "--vary", "initial.0.center=5,6", "--together"]
    assert main(["sweep", "single_compacton", *both, *QUICK, "-o", "both", "--untracked"]) == 0
    assert capfd.readouterr().out.startswith("2 members: 2 complete")
    draw = ["--draw", "initial.0.speed=0.5,1", "--count", "3", "--seed", "7", "--set", "grid.size=60"]
    assert main(["sweep", "single_compacton", *draw, *QUICK, "-o", "drawn", "--quiet", "--untracked"]) == 0
    with xr.open_dataset("drawn/table.nc") as table:
        assert table.sizes["speed"] == np.unique(table["speed"].values).size == 3


def test_a_sweep_of_which_nothing_is_left_is_status_1() -> None:
    assert main(["sweep", "single_compacton", "--vary", "grid.size=4,5", *QUICK, "--quiet"]) == 1


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("1,2, 3", ["1", "2", "3"]),
        ("A(x=1, y=2),B()", ["A(x=1, y=2)", "B()"]),
        ("'a,b',[1, 2]", ["'a,b'", "[1, 2]"]),
        ("", []),
        ("linspace(0, 1, 3)", [0.0, 0.5, 1.0]),
    ],
)
def test_values_are_listed_or_spaced(text: str, values: list[object]) -> None:
    assert values_of("f", text) == values


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "A study varies nothing"),
        (["--vary", "grid.sise=1,2"], "did you mean 'grid.size'?"),
        (["--vary", "grid.size="], "'grid.size' has no value to vary over"),
        (["--vary", "grid.size=1,2", "--vary", "grid.size=3"], "grid.size is given twice"),
        (["--vary", "grid.size"], "lacks a value"),
        (["--vary", "grid.size=linspace(1, 2)"], "is not understood; write it as geomspace"),
        (["--vary", "grid.size=geomspace(0, 1, 3)"], "is not understood; write it as geomspace"),
        (["--vary", "t_end=linspace(1, 2, 10000000)"], "10000000 values; choose between 2 and"),
        (
            [word for field in ("t_end", "grid.size", "frames") for word in ("--vary", f"{field}=linspace(1, 1000, 1000)")],
            "1e+09 members",
        ),
        (["--vary", "t_end=1,2", "--vary", "grid.size=60", "--together"], "need as many values each"),
        (["--vary", "t_end=1,2", "--draw", "t_end=1,2"], "give --draw or --vary"),
        (["--vary", "t_end=1,2", "--seed", "3"], "--seed belongs to random values; give --draw"),
        (["--refine", "t_end=1,2", "--count", "3"], "leave out --refine or --count"),
        (["--draw", "t_end=1"], "write two numbers, t_end=LOW,HIGH"),
        (["--vary", "t_end=1,2", "--scheduler", "tcp://127.0.0.1:1"], "does not answer; start it"),
        (["--vary", "t_end=1,2", "--workers", "0"], "workers = 0 must lie between"),
        (["--vary", "t_end=1,2", "--workers", "1", "--scheduler", "a"], "not allowed with"),
        (["--vary", "t_end=1,2", "-o", "no/where"], "does not exist"),
    ],
)
def test_what_cannot_be_swept_is_one_sentence(
    arguments: list[str], words: str, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mol_compactons.studies.engine.ANSWER_SECONDS", 1)
    try:
        status = main(["sweep", "single_compacton", "--quiet", *arguments])
    except SystemExit as end:
        status = int(str(end.code))
    told = capfd.readouterr()
    assert (status, told.out) == (2, "")
    assert words in told.err
    assert told.err.count("\n") == 1
    assert len(told.err) < 420


def test_a_class_of_a_script_runs_in_other_processes(tmp_path: Path) -> None:
    text = Path(__file__).parent.parent.joinpath("burgers_texts.py").read_text(encoding="utf-8")
    names: dict[str, str] = {}
    exec(text, names)
    (tmp_path / "mine.py").write_text(names["MODULE"].format(nu=0.1), encoding="utf-8")
    command = [sys.executable, "-m", "mol_compactons", "sweep", "mine.py", "--vary", "grid.size=60,80", "--workers", "2"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "2 members: 2 complete" in done.stdout


def test_a_refinement_says_where_the_outcome_changes(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["sweep", "single_compacton", "--set", "t_end=0.2", "--set", "frames=3", "--untracked", "--workers", "1"]
    assert main([*words, "--refine", "grid.size=3,60", "-o", "r", "--quiet"]) == 0
    assert capsys.readouterr().err == ""
    assert main(["info", "r"]) == 0
    told = capsys.readouterr().out
    assert re.search(r"failed at size = (\d+), complete at (\d+)", told)
    assert main([*words, "--refine", "grid.size=100,120", "--outcome", "momentum_drift > 1", "-o", "s"]) == 0
    assert "no at all 2 values of size" in capsys.readouterr().out
    assert main([*words, "--refine", "grid.size=100,120", "--vary", "t_end=1,2", "-o", "t"]) == 2
    assert "leave out --refine or --vary" in capsys.readouterr().err
    assert main([*words, "--vary", "t_end=1,2", "--parts", "3", "--outcome", "status", "-o", "t"]) == 2
    assert "--outcome, --parts belongs to a refinement" in capsys.readouterr().err
    assert main([*words, "--refine", "grid.size=a,b", "-o", "t"]) == 2
    assert "write numbers, grid.size=LOW,HIGH" in capsys.readouterr().err
    assert main([*words, "--refine", "grid.size=100,120", "--outcome", "nonsense", "-o", "t"]) == 2
    assert "is not understood" in capsys.readouterr().err
