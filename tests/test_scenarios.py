"""Every scenario runs, and one number of it is asserted."""

import json
import runpy
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mol_compactons import Grid, Simulation, open_result, run
from mol_compactons.analysis.chain_and_continuum import compare, continuum_of
from mol_compactons.analysis.collisions import first_collision
from mol_compactons.analysis.tracking import track
from mol_compactons.assignment import assign
from mol_compactons.chain.solitary_wave import solitary_profile
from mol_compactons.cli import scenarios
from mol_compactons.studies.convergence import converge
from tests.systems import relative_error


def test_the_example_of_the_readme(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It runs as it stands, and follows both waves to the end."""
    readme = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    names: dict[str, Any] = {}
    exec(readme.split("```python\n")[1].split("```")[0].replace("plt.show()", ""), names)
    assert names["tracks"].attrs["lost"] == ""
    assert names["outcome"]["phase_shift"].values == pytest.approx([-2.38, -5.5], abs=0.1)
    assert Path("bright_dark.nc").is_file()


@cache
def result(name: str) -> xr.Dataset:
    return run(scenarios.load(name))


def test_single_compacton() -> None:
    dataset, simulation = result("single_compacton"), scenarios.load("single_compacton")
    final = dataset.W[-1]
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, 14)[0]
    assert float(final.idxmax()) == pytest.approx(19.5, abs=0.15)
    assert float(abs(dataset.mass / dataset.mass[0] - 1).max()) < 1e-10
    assert relative_error(final.values, exact) == pytest.approx(4.51e-2, rel=0.02)


def test_two_bright() -> None:
    """The faster wave is ahead of where it would have been alone, the slower one behind: the phase shifts of a collision."""
    final = result("two_bright").W[-1]
    fast, slow = float(final.idxmax()), float(final.sel(x=slice(15, 30)).idxmax())
    assert fast == pytest.approx(47.2, abs=0.5)
    assert slow == pytest.approx(20.5, abs=0.5)
    assert float(final.max()) == pytest.approx(np.sqrt(2), rel=0.06)


def test_two_dark_is_two_bright_with_the_sign_changed() -> None:
    assert np.array_equal(result("two_dark").W, -result("two_bright").W)


def test_bright_dark() -> None:
    """The viscosity takes a good part of the momentum where the sign changes, as the docstring warns."""
    dataset = result("bright_dark")
    kept = float(dataset.momentum[-1] / dataset.momentum[0])
    assert 0.4 < kept < 0.7
    assert float(dataset.W[-1].min()) < 0 < float(dataset.W[-1].max())


def test_hertz_compacton() -> None:
    simulation = scenarios.load("hertz_compacton")
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, simulation.t_end)[0]
    assert relative_error(result("hertz_compacton").W.values[-1], exact) < 1e-3


def test_no_viscosity() -> None:
    """Better than a twentieth of the error of the paper's scheme on twice the grid."""
    dataset, simulation = result("no_viscosity"), scenarios.load("no_viscosity")
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, 14)[0]
    assert relative_error(dataset.W.values[-1], exact) == pytest.approx(1.71e-3, rel=0.05)
    assert float(abs(dataset.mass / dataset.mass[0] - 1).max()) < 1e-12
    assert float(abs(dataset.momentum / dataset.momentum[0] - 1).max()) < 1e-6


def test_rosenau_hyman_collision() -> None:
    """The fastest wave has gone round the periodic box and all three have nearly their heights 4 c / 3."""
    dataset = result("rosenau_hyman_collision")
    final = dataset.u[-1]
    assert float(final.sel(x=slice(0, 60)).max()) == pytest.approx(8 / 3, rel=0.02)
    assert float(final.sel(x=slice(125, 150)).max()) == pytest.approx(2, rel=0.02)
    assert float(final.sel(x=slice(90, 120)).max()) == pytest.approx(4 / 3, rel=0.02)
    assert -0.2 < float(final.min()) < -0.01


def test_periodic_wave() -> None:
    """After two rounds the exact wave is where it began; on half the grid the error is sixteen times as large."""
    dataset = result("periodic_wave")
    error = float(abs(dataset.W[-1] - dataset.W[0]).max())
    coarse = run(assign(scenarios.load("periodic_wave"), {"grid.size": "32", "frames": "2"}))
    assert error < 1e-4
    assert float(abs(coarse.W[-1] - coarse.W[0]).max()) / error == pytest.approx(16, rel=0.15)
    assert float(abs(dataset.energy / dataset.energy[0] - 1).max()) < 1e-6


def test_rarefaction() -> None:
    simulation = scenarios.load("rarefaction")
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, simulation.t_end)[0]
    assert exact.min() == pytest.approx(-1.5, rel=1e-3)
    assert relative_error(result("rarefaction").W.values[-1], exact) < 1e-3


def test_universal_pair() -> None:
    """Both waves are there at the end, and the bright one is ahead."""
    final = result("universal_pair").W[-1]
    assert float(final.idxmax()) > float(final.idxmin()) + 10
    assert float(final.max()) == pytest.approx(1.5, rel=0.05)
    assert float(final.min()) < -0.05


def test_nesterenko_breakup() -> None:
    """The finer the grid the faster: four times for half the spacing, at the fastest rate of linear theory."""
    names = runpy.run_path(str(scenarios.folder() / "nesterenko_breakup.py"))
    (early, fine_rate), (late, coarse_rate) = names["breakup"](16), names["breakup"](8)
    assert fine_rate / coarse_rate == pytest.approx(4, rel=0.1)
    assert late > 2.5 * early
    assert fine_rate == pytest.approx(names["fastest_rate"](16), rel=0.1)
    assert coarse_rate == pytest.approx(names["fastest_rate"](8), rel=0.1)
    pulse = run(names["chain"])
    assert float(pulse.R[-1].max()) > 0.8 * float(pulse.R[0].max())


def test_lattice_single() -> None:
    """Chain and continuum of the Hertz contact at c = 1: 0.21 sites apart after 14, and a fifth in L2."""
    chain = scenarios.load("lattice_single")
    last = compare(result("lattice_single"), run(continuum_of(chain))).isel(t=-1, wave=0)
    assert float(last.position - last.continuum_position) == pytest.approx(0.207, abs=0.002)
    assert float(last.distance) == pytest.approx(0.202, abs=0.005)
    assert float(last.height / last.continuum_height) == pytest.approx(1.011, abs=0.001)
    assert float(last.residual) < 4e-4


def test_head_on() -> None:
    """They come out farther ahead where they meet at a grain, and lose more where they meet at a contact."""
    names = runpy.run_path(str(scenarios.folder() / "head_on.py"))
    found = {}
    for place, center in names["PLACES"].items():
        dataset = run(replace(names["meeting"](center), frames=301))
        collision = first_collision(track(dataset, newborn=False))
        found[place] = *collision.phase_shift.values, *(100 * names["lost_energy"](collision))
    assert found["a contact"] == pytest.approx([0.3565, -0.3565, 0.296, 0.296], abs=1e-3)
    assert found["a grain"] == pytest.approx([0.3601, -0.3601, 0.045, 0.045], abs=1e-3)


def test_lattice_collision() -> None:
    """The slow wave moves at sqrt(c) = 1/2 in the chain and at c = 1/4 in the continuum."""
    chain = scenarios.load("lattice_collision")
    early = compare(result("lattice_collision"), run(continuum_of(chain))).sel(t=3, method="nearest")
    assert early.position.values - [10, 16] == pytest.approx([3, 1.5], abs=0.1)
    assert early.continuum_position.values - [10, 16] == pytest.approx([3, 0.75], abs=0.02)


def test_hertz_chain() -> None:
    """Each wave of the train has the speed of the exact wave of its height."""
    names = runpy.run_path(str(scenarios.folder() / "hertz_chain.py"))
    dataset = result("hertz_chain")
    stress = -np.diff(dataset.Q.values, axis=1)
    unit = solitary_profile(names["equation"], speed=1).amplitude
    trains = [names["passing"](stress, dataset.t.values, site, 3) for site in (80, 120)]
    for (first, _), (second, height) in zip(*trains, strict=True):
        assert 40 / (second - first) == pytest.approx((height / unit) ** 0.25, rel=5e-4)
    last = track(dataset.isel(t=slice(None, 561, 4))).isel(t=-2)
    assert last.sizes["wave"] == 5
    assert last.compacton.values.all()
    assert np.sort(last.height)[1:] == pytest.approx([0.4873, 0.7144, 0.8911, 0.9871], abs=5e-4)


def test_prestressed_chain() -> None:
    """A weak compacton is blown away by the linear term."""
    names = runpy.run_path(str(scenarios.folder() / "prestressed_chain.py"))
    dataset = result("prestressed_chain")
    assert names["near_the_crest"](dataset.R.values[0]) > 0.999
    assert names["near_the_crest"](dataset.R.values[-1]) < 0.5


def test_rarefaction_chain() -> None:
    simulation = scenarios.load("rarefaction_chain")
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, simulation.t_end)[0]
    assert float(np.abs(result("rarefaction_chain").R.values[-1] - exact).max()) < 1e-7


@pytest.mark.slow
def test_collision_study() -> None:
    """The conservative limit by two independent schemes on coarse grids, which agree within their error bars."""
    names = runpy.run_path(str(scenarios.folder() / "collision_study.py"))
    summary = converge(names["collision"](3), names["conservative"](3))["summary"].to_dataset().sel(limit="conservative")
    for quantity, value in (("phase shift 0", 2.626), ("phase shift 1", -4.627), ("height 1 after", 0.697)):
        row = summary.sel(quantity=quantity)
        assert row["verdict"].item() == "converged"
        assert float(row["value"]) == pytest.approx(value, abs=float(row["error"]) + 2e-3)


@pytest.mark.parametrize("name", list(scenarios.listing()))
def test_each_is_complete_and_keeps_its_mass(name: str) -> None:
    dataset = result(name)
    assert dataset.attrs["status"] == "complete"
    assert dataset.attrs["title"]
    if "mass" in dataset:
        # The studies' own runs have the tolerance 1e-5, and "band" keeps the mass to a thousandth of it only.
        assert float(abs(dataset.mass - dataset.mass[0]).max()) < (1e-7 if name.endswith("_study") else 1e-9)
    elif json.loads(dataset.attrs["simulation"])["equation"]["ends"] == "held":
        assert dataset.energy.attrs["role"] == "diagnostic"
    else:
        assert float(abs(dataset.energy / dataset.energy[0] - 1).max()) < 1e-5


def test_pulse_widths() -> None:
    """The distance of chain and continuum falls with the second power of the width, and the pulse has moved."""
    own = runpy.run_path(str(scenarios.folder() / "pulse_widths.py"))
    distances = []
    for width in (4, 8, 16):
        dataset = run(own["chain"](2.0, width))
        distances.append(own["distance"](dataset))
        assert relative_error(dataset.R.values[-1], dataset.R.values[0]) > 0.02
    assert np.log2(distances[1] / distances[2]) == pytest.approx(2, abs=0.1)
    assert distances[0] < 1e-3
    assert own["PLAN"].shape == (3, 4)


def test_discretisations() -> None:
    """All three problems run with the schemes that the study gives them, and the smooth one shows their orders."""
    own = runpy.run_path(str(scenarios.folder() / "discretisations.py"))
    for name, problem in own["PROBLEMS"].items():
        families = [family for _, family in problem.families(quick=True)]
        assert sum(len(family.schemes) for family in families) == 7
        assert problem.simulation(3).title
        assert name in ("smooth wave", "compacton", "collision")
    smooth = own["PROBLEMS"]["smooth wave"]
    ((names, family),) = smooth.families(quick=True)
    table = converge(smooth.simulation(1.5), replace(family, schemes=family.schemes[2:4]))["schemes"].to_dataset()
    assert names[2:4] == ["compact, five_point", "conservative, order 2"]
    assert table["fitted_order"].values[:, 0] == pytest.approx([4, 2], abs=0.1)


def test_paper_figures(tmp_path: Path) -> None:
    """On coarse grids: the paper's panels at the paper's times, and below each what was open, chosen and seen."""
    own = runpy.run_path(str(scenarios.folder() / "paper_figures.py"))

    def shorten(simulation: Simulation) -> Simulation:
        fine = isinstance(simulation.grid, Grid)
        grid = replace(simulation.grid, size=simulation.grid.size // 4) if fine else simulation.grid
        return replace(simulation, grid=grid, frames=(simulation.frames - 1) // 5 + 1)

    figures = own["make"](tmp_path, shorten, ["pdf"])
    assert list(figures) == ["fig1", "fig2", "fig3", "fig4", "bright_dark"]
    told = {name: figure.get_supxlabel() for name, figure in figures.items()}
    for name, plate in own["PLATES"].items():
        assert (tmp_path / f"{name}.pdf").stat().st_size > 5000
        assert len(figures[name].axes) == (len(plate.times) or len(plate.runs))
        assert all(f"{word}: " in told[name] for word in ("Left open", "Chosen", "Seen"))
        for axes, t in zip(figures[name].axes, plate.times, strict=False):
            line, dots = axes.lines
            assert axes.get_title() == f"t = {t:g}"
            with open_result(tmp_path / f"{plate.runs[0]}.nc") as chain:
                np.testing.assert_array_equal(dots.get_ydata(), chain.R.sel(t=t, method="nearest").values)
            assert np.abs(line.get_ydata()).max() == pytest.approx(np.abs(dots.get_ydata()).max(), rel=0.25)
    changes = [told[name].rpartition("The heights change by ")[2] for name in ("fig1", "fig2")]
    assert changes[0] == changes[1] != "", "dark waves are bright ones with the sign changed"
    assert "is lost" in told["bright_dark"]
