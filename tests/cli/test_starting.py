from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr

from mol_compactons.cli.parser import main
from mol_compactons.cli.scenarios import folder, listing, load


def test_a_scenario_is_printed_as_it_stands(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("two_bright", "hertz_chain.py"):
        assert main(["scenarios", name]) == 0
        path = folder() / f"{name.removesuffix('.py')}.py"
        assert capsys.readouterr().out == path.read_text(encoding="utf-8")
    assert main(["scenarios", "two_brigt"]) == 2
    assert "did you mean 'two_bright'?" in capsys.readouterr().err
    assert main(["scenarios"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == len(listing())


def test_a_new_script_runs_both_ways(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "mine.py"]) == 0
    assert "mol-compactons run mine.py" in capsys.readouterr().out
    assert load("mine.py").t_end == 40
    assert main(["run", "mine.py", "--quiet", "--set", "t_end=1", "--set", "frames=3"]) == 0
    with xr.open_dataset("mine.nc") as dataset:
        assert dataset.attrs["status"] == "complete"
    text = Path("mine.py").read_text(encoding="utf-8").replace("t_end=40", "t_end=1")
    Path("mine.py").write_text(text, encoding="utf-8")
    done = subprocess.run([sys.executable, "mine.py"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert Path("mine.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("name", "words"),
    [("mine.txt", "must end in .py"), ("my-script.py", "letters, digits and _"), ("nowhere/mine.py", "does not exist")],
)
def test_a_bad_name_is_named(
    name: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", name]) == 2
    assert words in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_script_that_exists_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text("mine", encoding="utf-8")
    assert main(["new", "mine.py"]) == 2
    assert "exists" in capsys.readouterr().err
    assert Path("mine.py").read_text(encoding="utf-8") == "mine"
    assert main(["new", "mine.py", "--overwrite"]) == 0


def test_versions_and_completion_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0
    told = capsys.readouterr().out
    assert all(name in told for name in ("mol_compactons", "SUNDIALS", "numpy", "numba", "scikit-sundae"))
    for shell in ("bash", "zsh", "tcsh"):
        with pytest.raises(SystemExit) as ended:
            main(["--print-completion", shell])
        assert ended.value.code == 0
        assert ("sweep" if shell == "tcsh" else "--refine") in capsys.readouterr().out
