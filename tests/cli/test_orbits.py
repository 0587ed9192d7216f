from __future__ import annotations

from pathlib import Path

import pytest
import xarray as xr

from mol_compactons import Simulation
from mol_compactons.cli.parser import main

QUICK = [
    "single_compacton",
    "--set",
    "equation=RosenauHyman(2, 2, absolute=True)",
    "--set",
    "grid=Grid(20, 60)",
    "--set",
    "initial=[Compacton(1, 10)]",
    "--set",
    "scheme=PadeScheme('pade_6')",
]


def test_orbit_prints_the_largest_multipliers_and_stores_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["orbit", *QUICK, "-o", "orbit.nc"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "PadeScheme(stencil=pade_6), N = 60" in lines[0]
    assert lines[-1] == "wrote orbit.nc"
    with xr.open_dataset("orbit.nc") as dataset:
        assert f"  {float(dataset.modulus[0]):.8f} +- " in lines[-8]
        assert lines[-2].startswith(f"verdict: {dataset.attrs['verdict']}")
        assert dataset.attrs["around"] == "ring"
        assert Simulation.from_json(dataset.attrs["simulation"]).grid.size == 60
    assert {path.name for path in Path().iterdir()} == {"orbit.nc"}


def test_what_is_stored_is_read_drawn_and_run_again(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["orbit", *QUICK, "-o", "orbit.nc", "--around", "window", "--steps", "12", "--order", "6"]) == 0
    printed = capsys.readouterr().out.splitlines()[:-1]
    assert "by 12 Gauss-Legendre steps of order 6" in printed[1]
    assert any("around the window" in line for line in printed)
    assert main(["info", "orbit.nc"]) == 0
    assert capsys.readouterr().out.splitlines() == printed
    assert main(["plot", "orbit.nc"]) == 0
    assert Path("orbit.png").read_bytes().startswith(b"\x89PNG")
    assert main(["orbit", "orbit.nc", "--around", "window", "--steps", "12", "--order", "6", "-o", "again.png"]) == 0
    assert capsys.readouterr().out.splitlines()[1:-1] == printed
    assert Path("again.png").read_bytes().startswith(b"\x89PNG")
    assert main(["doctor", "orbit.nc"]) == 2
    assert "no result of a run" in capsys.readouterr().err


def test_a_file_is_replaced_only_when_asked(capsys: pytest.CaptureFixture[str]) -> None:
    Path("orbit.nc").write_text("precious")
    assert main(["orbit", *QUICK, "-o", "orbit.nc"]) == 2
    assert "orbit.nc exists; allow overwriting" in capsys.readouterr().err
    assert Path("orbit.nc").read_text() == "precious"
    assert main(["orbit", *QUICK, "-o", "orbit.nc", "--overwrite"]) == 0
    xr.open_dataset("orbit.nc").close()


def test_the_wave_of_a_chain_is_followed_on_a_window(capsys: pytest.CaptureFixture[str]) -> None:
    chain = ["head_on", "--set", "grid=Lattice(30)", "--set", "initial=[SolitaryWave(1, 15)]"]
    assert main(["orbit", *chain]) == 0
    printed = capsys.readouterr().out
    assert "around the window" in printed
    assert "verdict: stable" in printed
    assert "\n  1.0000000" in printed


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["two_bright"], "set scheme.viscosity=0"),
        (["two_bright", "--set", "scheme.viscosity=0"], "initial holds 2 waves"),
        (["hertz_chain"], "Impact does not know the speed"),
        ([*QUICK, "--steps", "0"], "steps = 0 must lie between 1 and"),
        ([*QUICK, "--speed", "0"], "speed = 0 must not be 0"),
        ([*QUICK, "--speed", "nan"], "speed = nan must not be 0"),
        ([*QUICK, "-o", "orbit.txt"], "must end in .nc, to store the orbit, or .png, to draw it"),
        ([*QUICK, "-o", "nowhere/orbit.nc"], "The folder nowhere does not exist"),
        ([*QUICK, "--order", "5"], "invalid choice: 5"),
        ([*QUICK, "--set", "grid.size=5000"], "5000 unknowns is too large"),
        ([*QUICK, "--around", "window", "--set", "grid.length=14"], "does not fit in the ring of length 14"),
    ],
)
def test_bad_options_are_one_sentence(options: list[str], words: str, capfd: pytest.CaptureFixture[str]) -> None:
    try:
        status = main(["orbit", *options])
    except SystemExit as leaving:
        status = int(leaving.code or 0)
    assert status == 2
    printed = capfd.readouterr().err
    assert words in printed
    assert len(printed.splitlines()) == 1
    assert not list(Path().iterdir())
