"""Results of version 0.1.0 as it was before they had a format number, roles and outlines; made by that version itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from mol_compactons import GranularChain, PowerContact, Simulation, drift, first_collision, run, track
from mol_compactons.analysis.chain_and_continuum import on_lattice
from mol_compactons.cli.parser import main
from mol_compactons.results import conserved_names, field_names, grid_of
from mol_compactons.results.reading import outlines_of

DATA = Path(__file__).parent.parent / "data"
EQUATION, CHAIN = DATA / "version_0_1_0_equation.nc", DATA / "version_0_1_0_chain.nc"


@pytest.mark.parametrize(("path", "accuracy"), [(EQUATION, 1e-4), (CHAIN, 1e-9)])
def test_they_repeat(path: Path, accuracy: float) -> None:
    """With fixed steps to round-off, for sums may be ordered otherwise elsewhere; with a tolerance to what it allows."""
    with xr.open_dataset(path) as before:
        assert "format" not in before.attrs
        after = run(Simulation.from_json(before.attrs["simulation"]))
        assert after.attrs["status"] == before.attrs["status"] == "complete"
        for name in before.data_vars:
            scale = float(np.abs(before[name]).max())
            assert np.abs(after[name].values - before[name].values).max() <= accuracy * scale


def test_they_say_what_they_are() -> None:
    with xr.open_dataset(EQUATION) as one, xr.open_dataset(CHAIN) as chain:
        assert field_names(one) == ["W"]
        assert conserved_names(one) == ["mass", "momentum", "energy"]
        assert grid_of(one).length == pytest.approx(40, rel=1e-14)
        assert [(wave.speed, wave.sign) for wave in outlines_of(one)] == [(1, 1), (0.25, -1)]
        assert field_names(chain) == ["R", "R_t"]
        assert conserved_names(chain) == ["energy"]
        equation = Simulation.from_json(chain.attrs["simulation"]).equation
        assert isinstance(equation, GranularChain)
        assert equation.law == PowerContact(n=1.5, strength=2, kind="one_sided")
        assert len(equation.masses) == 41
        assert float(abs(drift(chain)["energy"]).max()) < 1e-9


def test_their_waves_are_followed() -> None:
    with xr.open_dataset(EQUATION) as dataset:
        tracks = track(dataset)
        assert np.allclose(tracks.position[0], [8, 24], atol=0.1)
        assert float(tracks.speed[:, 0].median()) == pytest.approx(1, abs=0.05)
        assert first_collision(tracks).speed_before.values[1] == pytest.approx(0.25, abs=0.05)


def test_a_continuum_of_them_is_on_their_lattice() -> None:
    with xr.open_dataset(CHAIN) as chain, xr.open_dataset(EQUATION) as dataset:
        line = on_lattice(dataset, chain.attrs["simulation"])
        assert float(line.x[-1] / dataset.x[-1]) == pytest.approx((1.5 / (6 * 2.5)) ** 0.5)


@pytest.mark.parametrize("path", [EQUATION, CHAIN])
def test_the_command_line_takes_them(path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(path)]) == 0
    assert f"Compacton(speed=1, center={8 if path == EQUATION else 10}, sign=1)" in capsys.readouterr().out
    assert main(["plot", str(path), "-o", str(tmp_path / "old.png")]) == 0
    assert (tmp_path / "old.png").stat().st_size > 10_000
    assert main(["run", str(path), "-o", str(tmp_path / "again.nc"), "--set", "frames=3", "--quiet"]) == 0
    with xr.open_dataset(tmp_path / "again.nc") as again:
        assert again.attrs["format"] == 2


def test_a_format_of_the_future_is_refused() -> None:
    with xr.open_dataset(EQUATION) as dataset, pytest.raises(ValueError, match=r"has the format 99, .* install a newer one"):
        field_names(dataset.assign_attrs(format=99))
