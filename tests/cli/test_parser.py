import os
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr

from mol_compactons.cli.parser import main


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "two_brigth"], "did you mean 'two_bright'?"),
        (["run", "missing.nc"], "There is no file missing.nc"),
        (["run", "two_bright", "--set", "grid.sise=3"], "did you mean 'grid.size'?"),
        (["run", "two_bright", "--set", "grid.size"], "lacks a value"),
        (["run", "two_bright", "--set", "grid.size=many"], "must be a whole number"),
        (["run", "two_bright", "--set", "grid.size=5"], "choose at least 9 points"),
        (["run", "two_bright", "--set", "equation.n=1"], "larger than 1"),
        (["run", "two_bright", "--set", "initial.1.center=7"], "overlap"),
        (["run", "two_bright", "--set", "grid.length=5"], "does not fit in the box"),
        (["run", "two_bright", "--set", "integrator=CVODE"], "mass matrix"),
        (["run", "two_bright", "-o", "nowhere/a.nc"], "does not exist"),
        (["run", "two_bright", "-o", "."], "is a folder"),
        (["run", "two_bright", "-o", "a.txt"], "a.txt must end in .nc"),
        (["run", "notes.md"], "notes.md is neither a script (.py) nor a result (.nc)"),
        (["info", "nothing.nc"], "There is no file"),
        (["stability", "n=1"], "larger than 1"),
        (["stability", "3"], "'3' lacks a value; write FIELD=VALUE."),
        (["stability", "n=2", "n=3"], "n is given twice"),
        (["stability", "m=2"], "is not a field of StabilityStudy"),
        (["stability", "sizes=20,40,80", "-o", "report.txt"], "must end in .nc"),
        (["plot", "broken.nc"], "is not a NetCDF file"),
        (["info", "foreign.nc"], "is not a result of mol_compactons"),
        (["run", "empty.py"], "does not define a Simulation"),
        (["run", "wrong.py"], "could not be run (ZeroDivisionError"),
        (["run", "two_bright", "-o", "taken.nc"], "taken.nc exists; allow overwriting"),
        (["run", "two_bright", "-o", "pipe", "--overwrite"], "pipe is not an ordinary file"),
        (["run", "two_bright", "-o", "dangling.nc"], "dangling.nc is not an ordinary file"),
        (["run", "nowhere/two_bright.py"], "There is no scenario 'nowhere/two_bright.py'"),
        (["run", "leaving.py"], "could not be run (SystemExit"),
        (["run", "two_bright", "-o", "a" * 300], "cannot be the name of a file"),
        (["run", "two_bright", "-o", "/proc/a.nc"], "cannot be written"),
        (["run", "two_bright", "--set", "initial.0.speed=1e90", "--set", "equation.n=1.1"], "out of the range of numbers"),
        (["run", "two_bright", "--set", "grid.size=1e15"], "must lie between"),
        (["run", "two_bright", "--set", "grid.size=" + "9" * 400], "must be a whole number"),
        (["run", "two_bright", "--set", "grid.length=1e-300"], "must lie between"),
        (["run", "two_bright", "--set", "frames=1e12"], "must lie between"),
        (["run", "two_bright", "--set", "integrator=Midpoint", "--set", "integrator.rtol=1"], "is not a field"),
        (["run", "two_bright", "--set", "integrator=banana"], "must be Integrator (CVODE, GaussLegendre, IDA, Midpoint"),
        (["run", "two_bright", "--set", "initial=Compacton(speed=1, center=5)"], "must be a list of"),
        (["run", "two_bright", "--set", "integrator.atol=1e-300"], "must be above 1e-100"),
        (["run", "two_bright", "--set", "t_end=" + "-" * 1000 + "1"], "is nested more than 60 levels deep"),
        (["run", "two_bright", "--set", "t_end=" + "+".join("1" * 3000)], "is nested more than 60 levels deep"),
        (["run", "two_bright", "--set", "t_end=" + "*".join(["9" * 3000] * 2)], "is not a finite number; give one"),
        (["run", "two_bright", "--set", "t_end=" + "9" * 4000], "must be finite"),
        (["run", "two_bright", "--set", "x" * 4000 + "=1"], "is not a field of Simulation"),
        (["run", "two_bright", "--set", "initial.0.center=1e308"], "must lie between -1e+100 and 1e+100; choose other units"),
        (
            ["run", "two_bright", "--set", "initial.0.center=1e99"],
            "Compacton.center = 1e+99 must lie between",
        ),
        (["run", "two_bright", "--set", "grid.size=9"], "grid points in it, but at least 2 are needed; choose a grid.size of"),
        (["run", "two_bright", "--set", "grid.length=1e9"], "choose a shorter box"),
        (["run", "two_bright", "--set", "scheme.viscosity=1e90"], "must not be above 1e+06"),
        (["run", "two_bright", "--set", "scheme.grid_viscosity=1e90"], "choose smaller ones"),
        (["run", "two_bright", "--set", "initial=[Uniform(1e100)]"], "of the initial state, of size 1e+100, is not finite"),
        (["run", "two_bright", "--set", "initial=[Formula('exp(-1e8*(x-0.01234)**2)')]"], "is zero at all"),
        (["run", "nesterenko_breakup", "--set", "equation.n=1e100"], "must not be above 1000"),
        (["run", "nesterenko_breakup", "--set", "initial.0.speed=1e-200"], "out of the range of numbers"),
        (["run", "periodic_wave", "--set", "initial.0.speed=1e99"], "out of the range of numbers"),
        (["run", "head_on", "--set", "equation.law.n=1e99"], "must not be above 1000"),
        (["run", "head_on", "--set", "equation.law.strength=1e-200"], "leaves the range of numbers"),
    ],
)
def test_bad_input_is_one_sentence_status_2_and_nothing_written(
    arguments: list[str], words: str, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("notes.md").write_text("# Notes")
    Path("empty.py").write_text("")
    Path("wrong.py").write_text("1 / 0")
    Path("broken.nc").write_text("no NetCDF")
    Path("taken.nc").write_text("")
    Path("leaving.py").write_text("import sys; sys.exit(3)")
    Path("dangling.nc").symlink_to("elsewhere.nc")
    os.mkfifo("pipe")
    xr.Dataset({"a": 1}).to_netcdf("foreign.nc")
    before = sorted(Path().iterdir())
    assert main(arguments) == 2
    printed = capfd.readouterr()
    assert words in printed.err
    assert len(printed.err.splitlines()) == 1
    assert "\r" not in printed.err
    assert printed.err.startswith("mol-compactons: ")
    assert "Traceback" not in printed.err
    assert printed.out == ""
    assert sorted(Path().iterdir()) == before


def test_usage_errors_are_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (["fly"], [], ["run"], ["run", "a", "--fast"]):
        with pytest.raises(SystemExit) as leaving:
            main(arguments)
        assert leaving.value.code == 2
        assert len(capsys.readouterr().err.splitlines()) == 1


def test_a_solver_that_gives_up_is_status_1(capsys: pytest.CaptureFixture[str]) -> None:
    changes = [
        "--set",
        "scheme.viscosity=0",
        "--set",
        "scheme.second_difference=nearest",
        "--set",
        "integrator.max_steps=4000",
    ]
    assert main(["run", "single_compacton", "--quiet", *changes]) == 1
    assert "gave up at t = 0." in capsys.readouterr().err
    with xr.open_dataset("single_compacton.nc") as dataset:
        assert dataset.attrs["status"].startswith("failed at t = 0.")
        assert dataset.sizes["t"] > 1


@pytest.mark.slow
def test_a_cold_run_says_once_that_it_compiles(tmp_path: Path) -> None:
    """Also where only what another integrator needs is missing."""
    command = [sys.executable, "-m", "mol_compactons", "run", "lattice_single", "-o", "cold.nc", "--overwrite"]
    command += ["--set", "t_end=0.1", "--set", "frames=3"]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def printed(*more: str) -> str:
        return subprocess.run([*command, *more], capture_output=True, text=True, env=environment, check=True).stdout

    first, second = printed("--set", "integrator=CVODE"), printed("--set", "integrator=CVODE")
    assert first.count("compiling the kernels") == 1
    assert second.startswith("wrote cold.nc")
    assert printed("--set", "integrator=Symplectic").startswith("compiling the kernels")
    assert printed("--set", "integrator=Symplectic").startswith("wrote cold.nc")


@pytest.mark.parametrize(
    ("place", "arguments", "words"),
    [
        ("running.run", ["run", "single_compacton", "--quiet"], "interrupted; nothing was written."),
        ("studies.converge", ["converge", "single_compacton", "--quiet"], "interrupted; nothing was written."),
    ],
)
def test_an_interrupt_is_status_130(
    place: str, arguments: list[str], words: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(f"mol_compactons.cli.{place}", interrupted)
    assert main(arguments) == 130
    assert capfd.readouterr().err == f"mol-compactons: {words}\n"


@pytest.mark.parametrize("command", ["run", "info", "plot", "track", "doctor", "orbit", "converge"])
def test_a_name_longer_than_any_file_can_have(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "n" * 5000]) == 2
    told = capsys.readouterr().err
    assert told.startswith(("mol-compactons: nnn", "mol-compactons: 'nnn"))
    assert (told.count("\n"), len(told) < 450) == (1, True)
