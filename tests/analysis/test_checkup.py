from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from mol_compactons import (
    IDA,
    Compacton,
    ConservativeScheme,
    GranularCompacton,
    Grid,
    Nesterenko,
    Rosenbrock,
    Samples,
    Simulation,
    run,
)
from mol_compactons.analysis.checkup import Case, Finding, check_up
from mol_compactons.errors import InputError
from tests.analysis.painted import painted

SIMULATION = Simulation(
    equation=GranularCompacton(n=2),
    grid=Grid(length=40, size=400),
    scheme=ConservativeScheme(order=4),
    initial=[Compacton(speed=1, center=10.05)],
    t_end=18,
    frames=61,
    integrator=IDA(rtol=1e-6),
)


@pytest.fixture(scope="module")
def sound() -> xr.Dataset:
    """A run in which all is as it should be."""
    return run(SIMULATION)


def of(findings: list[Finding], check: str) -> list[Finding]:
    return [finding for finding in findings if finding.check == check]


def verdict_on(dataset: xr.Dataset, check: str) -> str:
    """The worst verdict on one thing; it was looked at."""
    verdicts = [finding.verdict for finding in of(check_up(dataset), check)]
    return max(verdicts, key=["agrees", "doubtful", "contradicts"].index)


def test_a_sound_run_agrees_in_everything(sound: xr.Dataset) -> None:
    findings = check_up(sound)
    assert {finding.verdict for finding in findings if finding.check != "energy"} == {"agrees"}
    seen = {finding.check for finding in findings}
    assert {"status", "mass", "momentum", "energy", "wave 0", "grid", "seam", "ripples", "solver"} <= seen
    speed, profile = of(findings, "wave 0")
    assert "a wave of its height 1.5" in speed.sentence or "a wave of its height 1.4" in speed.sentence
    assert "its profile differs from the exact wave" in profile.sentence


def test_a_run_that_ended_early(sound: xr.Dataset) -> None:
    half = sound.isel(t=slice(0, 31)).assign_attrs(status="interrupted at t = 9")
    assert verdict_on(half, "status") == "doubtful"
    assert verdict_on(sound.isel(t=slice(0, 31)), "status") == "doubtful"


def test_a_frame_of_no_numbers(sound: xr.Dataset) -> None:
    broken = sound.copy(deep=True)
    broken.W[40, 7] = np.nan
    (finding,) = of(check_up(broken), "frames")
    assert finding.verdict == "contradicts"
    assert "first at t = 12" in finding.sentence


@pytest.mark.parametrize(("loss", "verdict"), [(1e-6, "agrees"), (1e-3, "doubtful"), (0.11, "contradicts")])
def test_a_drift_against_the_tolerance(sound: xr.Dataset, loss: float, verdict: str) -> None:
    lossy = sound.copy(deep=True)
    lossy["mass"] = lossy.mass * np.linspace(1, 1 - loss, lossy.sizes["t"])
    assert verdict_on(lossy, "mass") == verdict


@pytest.mark.parametrize("series_per_frame", [1, 3])
@pytest.mark.parametrize(("quantity", "accuracy"), [("momentum", 0.02), ("energy", 0.1)])
def test_what_the_viscosity_takes_is_told_from_what_is_lost(quantity: str, accuracy: float, series_per_frame: int) -> None:
    scheme = ConservativeScheme(order=4, viscosity=4e-3)
    findings = check_up(run(replace(SIMULATION, scheme=scheme, series_per_frame=series_per_frame)))
    (found,) = of(findings, quantity)
    assert found.verdict != "contradicts"
    changed, explained = (
        float(found.sentence.split(words)[1].split()[0].rstrip(".;")) for words in ("changes by ", "viscosity takes ")
    )
    assert changed > 1e-3
    assert abs(explained / changed - 1) < accuracy
    (share,) = of(findings, "viscosity")
    assert share.verdict == "doubtful"
    assert "viscosity" not in of(findings, "mass")[0].sentence.split(";")[0]


def test_a_wave_that_moves_at_another_speed_than_that_of_its_height(sound: xr.Dataset) -> None:
    assert verdict_on(sound.assign_coords(t=sound.t / 1.01), "wave 0") == "doubtful"
    assert verdict_on(sound.assign_coords(t=sound.t / 1.1), "wave 0") == "contradicts"


def test_a_wave_of_another_shape_than_a_compacton() -> None:
    result = painted(2, [(Compacton(1, 10), 0, 0)], t_end=10)
    assert verdict_on(result.assign_attrs(status="complete"), "wave 0") == "agrees"
    peaked = result.assign_attrs(status="complete")
    peaked["W"] = 1.5 * (peaked.W / 1.5) ** 3
    assert verdict_on(peaked, "wave 0") == "contradicts"


@pytest.mark.parametrize(("size", "verdict"), [(100, "agrees"), (40, "doubtful")])
def test_points_in_a_wave(size: int, verdict: str) -> None:
    assert verdict_on(run(replace(SIMULATION, grid=Grid(40, size), t_end=0.1, frames=3)), "grid") == verdict


def test_a_wave_that_meets_what_it_left_behind() -> None:
    result = painted(2, [(Compacton(1, 10), 0, 0)], t_end=120).assign_attrs(status="complete")
    rng = np.random.default_rng(1)
    assert of(check_up(result.isel(t=slice(0, 60))), "ring") == []
    assert verdict_on(result, "ring") == "agrees"
    result["W"] = result.W + 0.02 * rng.standard_normal(result.W.shape)
    assert verdict_on(result, "ring") == "doubtful"


def test_data_that_do_not_close_on_the_ring() -> None:
    grid = Grid(length=20, size=200)
    ramp = replace(SIMULATION, grid=grid, initial=[Samples(tuple(1 + grid.x / 20), tuple(grid.x))], t_end=0.01, frames=2)
    assert verdict_on(run(ramp), "seam") == "contradicts"


def test_ripples_at_the_scale_of_the_grid(sound: xr.Dataset) -> None:
    rippled = sound.copy(deep=True)
    rippled.W[-1] += 0.05 * (-1.0) ** np.arange(400)
    assert verdict_on(rippled, "ripples") == "doubtful"


def test_the_share_of_the_ripples_is_that_of_their_squares(sound: xr.Dataset) -> None:
    """cos 3 a + cos 180 a / 10 on 400 points, of which the waves from 134 on are the shortest third: 1/100 in 1 + 1/100."""
    by_hand, angle = sound.copy(deep=True), 2 * np.pi * np.arange(400) / 400
    by_hand.W[0] = np.cos(3 * angle) + 0.01 * np.cos(134 * angle)
    by_hand.W[-1] = np.cos(3 * angle) + 0.1 * np.cos(180 * angle) + 0.1 * np.cos(133 * angle)
    (finding,) = of(check_up(by_hand), "ripples")
    assert "holds 9.8e-03 of the squared field at the end, 1.0e-04 at first" in finding.sentence
    assert finding.verdict == "doubtful"
    by_hand.W[0] = by_hand.W[-1]
    assert verdict_on(by_hand, "ripples") == "agrees"


def test_the_sentences_hold_the_numbers(sound: xr.Dataset) -> None:
    lossy = sound.copy(deep=True)
    lossy["mass"] = lossy.mass * (1 + np.array([0.0, 2e-3, -3e-3, *[0.0] * 58]))
    lossy.attrs["simulation"] = replace(SIMULATION, integrator=IDA(rtol=1e-6, atol=1e-4)).to_json()
    told = {finding.check: finding.sentence for finding in check_up(lossy)}
    assert "changes by 3.0e-03 of its first value" in told["mass"]
    assert "61 frames to t = 18 of 18, complete" in told["status"]
    width = GranularCompacton(n=2).compacton(1).width
    assert f"the narrowest wave has {width / 0.1:.0f} points in its support" in told["grid"]
    assert "the absolute one is 6.7e-05 of the lowest wave, the relative one is 1e-06" in told["tolerance"]
    grid = Grid(length=20, size=200)
    ramp = replace(SIMULATION, grid=grid, initial=[Samples(tuple(1 + grid.x / 20), tuple(grid.x))], t_end=0.01, frames=2)
    (seam,) = of(check_up(run(ramp)), "seam")
    assert "the data jump by 5.0e-01 of their size, elsewhere by at most 2.5e-03" in seam.sentence


@pytest.mark.parametrize(
    ("atol", "verdict"),
    [
        (1e-8, "agrees"),
        (1.5e-6, "agrees"),
        (1e-4, "doubtful"),
        (0.015, "doubtful"),
        (0.016, "contradicts"),
        (1.0, "contradicts"),
    ],
)
def test_an_absolute_tolerance_against_the_height(atol: float, verdict: str) -> None:
    """The height is 3/2, and what is equal to a bound is within it."""
    small = replace(SIMULATION, integrator=IDA(rtol=1e-6, atol=atol), t_end=0.01, frames=2)
    assert verdict_on(run(small), "tolerance") == verdict


@pytest.mark.parametrize(("size", "verdict"), [(20, "agrees"), (40, "contradicts")])
def test_growth_that_the_equation_has(size: int, verdict: str) -> None:
    """On one point a site pi / h is below sqrt(12) and nothing grows; on two it is above."""
    equation = Nesterenko(n=3)
    simulation = Simulation(equation, Grid(20, size), [Compacton(1, 10)], t_end=2, frames=3)
    findings = of(check_up(run(simulation)), "growth")
    assert [finding.verdict for finding in findings] == ([] if verdict == "agrees" else [verdict])


def test_troubles_of_the_solver(sound: xr.Dataset) -> None:
    troubled = sound.assign_attrs(solver_warnings=3, solver_first_warning="the step is tiny")
    (finding,) = of(check_up(troubled), "solver")
    assert finding.verdict == "doubtful"
    assert "the step is tiny" in finding.sentence
    assert verdict_on(sound.assign_attrs(solver_failures=sound.attrs["solver_steps"]), "solver") == "doubtful"


def test_order_of_dimensions_changes_nothing(sound: xr.Dataset) -> None:
    assert check_up(sound.transpose("x", "t")) == check_up(sound)


def test_what_is_no_result_is_refused(sound: xr.Dataset) -> None:
    with pytest.raises(InputError, match="no result of a run"):
        check_up(xr.Dataset())
    with pytest.raises(InputError, match="holds no frame"):
        check_up(sound.isel(t=slice(0, 0)))
    assert verdict_on(sound.isel(t=slice(0, 1)), "mass") == "agrees"


def test_a_case_without_its_classes_is_looked_at_all_the_same(sound: xr.Dataset) -> None:
    foreign = sound.assign_attrs(simulation=sound.attrs["simulation"].replace('"GranularCompacton"', '"elsewhere:Own"'))
    assert Case(foreign).simulation is None
    assert verdict_on(foreign, "mass") == "agrees"


def test_what_hardly_changes_is_no_contradiction_where_the_scheme_gives_back_what_the_viscosity_takes() -> None:
    """The conservative scheme does not keep the energy, and in a collision the viscosity would take ten times what is lost."""
    collision = replace(
        SIMULATION,
        equation=GranularCompacton(n=3),
        grid=Grid(length=60, size=600),
        scheme=ConservativeScheme(order=4, grid_viscosity=0.03, viscosity_order=6),
        initial=[Compacton(1, 5.5), Compacton(0.25, 15.5)],
        t_end=20,
        integrator=Rosenbrock(),
    )
    dataset = run(collision)
    (energy,) = of(check_up(dataset), "energy")
    lost, taken = (
        float(energy.sentence.split(words)[1].split()[0].rstrip(".;,")) for words in ("changes by ", "viscosity takes ")
    )
    assert taken > 5 * lost
    assert energy.verdict != "contradicts"
