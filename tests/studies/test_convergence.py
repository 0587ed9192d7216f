from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mol_compactons import (
    IDA,
    CompactScheme,
    ConservativeScheme,
    Grid,
    InputError,
    IntegrationError,
    Lattice,
    Ripple,
    RosenauHyman,
    Rosenbrock,
    Simulation,
    SolitaryWave,
    Symplectic,
    Uniform,
    run,
)
from mol_compactons.assignment import assign
from mol_compactons.cli import scenarios
from mol_compactons.studies.convergence import converge, group_name
from mol_compactons.studies.family import Family
from mol_compactons.studies.judgement import BUDGET, CONVERGED, NOT_CONVERGED, judge
from mol_compactons.studies.report import report, verdict
from tests.studies.simulations import chain, single
from tests.systems import one_compacton


def test_a_study_can_be_judged_anew(study: xr.DataTree) -> None:
    again, strict = judge(study), judge(study, accuracy=1e-12)
    xr.testing.assert_equal(again["summary"].to_dataset(), study["summary"].to_dataset())
    assert verdict(strict["summary"].to_dataset(), "inviscid") != CONVERGED


@pytest.fixture(scope="module")
def study() -> xr.DataTree:
    return converge(single())


def test_one_compacton_converges_and_the_error_bars_hold_the_truth(study: xr.DataTree) -> None:
    summary = study["summary"].to_dataset()
    assert verdict(summary, "inviscid") == CONVERGED
    exact = single().equation.compacton(1.0)
    truths = {"height 0": exact.amplitude, "speed 0": 1.0, "position 0": 13.0, "mass drift": 0.0, "momentum drift": 0.0}
    for name, truth in truths.items():
        row = summary.sel(limit="inviscid", quantity=name)
        assert abs(float(row["value"]) - truth) <= float(row["error"])
        assert float(row["error"]) < 1e-2 * float(row["scale"])
    assert float(summary.sel(limit="inviscid", quantity="profile")["rate"]) == pytest.approx(3.5, abs=1)


def test_the_budget_adds_up_and_members_carry_their_simulation(study: xr.DataTree) -> None:
    summary = study["summary"].to_dataset()
    assert np.allclose(sum(summary[part] for part in BUDGET), summary["error"])
    members = study["members"].children
    assert len(members) == 8
    for member in members.values():
        simulation = Simulation.from_json(member.attrs["simulation"])
        assert member["W"].sizes["x"] == simulation.grid.size
        assert {"position", "mass", "momentum"} <= set(member.data_vars)
    distance = study["ladder"].to_dataset()["distance"].sel(limit="inviscid", quantity="profile").squeeze()
    assert (distance.diff("size") < 0).all()


def test_an_unresolved_family_is_not_called_converged() -> None:
    simulation = assign(scenarios.load("two_bright"), {"integrator.rtol": "1e-4", "frames": "81"})
    family = Family(
        sizes=(50, 60, 75), schemes=(ConservativeScheme(order=2), CompactScheme("wide")), grid_viscosities=(0.3, 0.1)
    )
    tree = converge(simulation, family)
    assert verdict(tree["summary"].to_dataset(), "conservative") != CONVERGED
    assert tree["summary"]["verdict"].sel(quantity="profile").item() == "not converged"


@pytest.mark.slow
def test_the_viscous_compact_scheme_on_bright_dark_is_not_called_converged() -> None:
    simulation = assign(scenarios.load("bright_dark"), {"integrator.rtol": "1e-4", "frames": "61", "t_end": "30"})
    family = Family(sizes=(200, 250, 300), schemes=(CompactScheme("wide"),), viscosities=(2e-3, 1e-3))
    tree = converge(simulation, family)
    summary = tree["summary"].to_dataset()
    assert verdict(summary, "viscous") != CONVERGED
    assert "no independent scheme" in summary["reason"].sel(quantity="profile").item()
    beside = converge(simulation, Family(sizes=(200, 250, 300), viscosities=(2e-3, 1e-3), tolerances=(1e-3, 1e-4)))
    for quantity in ("profile", "momentum drift"):
        assert beside["summary"]["verdict"].sel(quantity=quantity).item() == "not converged"


def test_failed_members_are_named_and_not_counted() -> None:
    simulation = assign(
        single(n=3),
        {
            "integrator": "IDA(rtol=3e-3, max_steps=1000)",
            "t_end": "1.5",
            "frames": "4",
            "scheme": "CompactScheme(second_difference=nearest)",
        },
    )
    family = Family(sizes=(60, 120, 240), schemes=(CompactScheme("nearest"), ConservativeScheme()), viscosities=(1e-3, 0.0))
    lines: list[str] = []
    tree = converge(simulation, family, lines.append)
    failed = tree.attrs["failed"].splitlines()
    assert failed
    assert all("CompactScheme(second_difference=nearest)" in line and "viscosity=0" in line for line in failed)
    assert len(tree["members"].children) + len(failed) == len(lines)
    assert [line for line in report(tree) if line.startswith("failed and not counted")]


def test_a_study_without_any_survivor_says_why() -> None:
    simulation = assign(single(), {"integrator.max_steps": "1"})
    with pytest.raises(IntegrationError, match="No member of the family ran to its end; the first: inviscid Conserv"):
        converge(simulation, Family(sizes=(60, 90, 120)))


def test_the_finest_grid_may_fail_at_the_tightest_tolerance(monkeypatch: pytest.MonkeyPatch) -> None:
    from mol_compactons.studies import convergence

    def failing(simulation: Simulation, progress: bool) -> xr.Dataset:
        if simulation.grid.size == 120 and simulation.integrator == IDA(rtol=1e-5):
            raise IntegrationError("as a test", 0.0)
        return run(simulation, progress=progress)

    monkeypatch.setattr(convergence, "run", failing)
    simulation = assign(single(size=120), {"integrator": "IDA(rtol=1e-5)"})
    tree = converge(simulation, Family(sizes=(60, 80, 120), schemes=(ConservativeScheme(),)))
    reason = tree["summary"]["reason"].sel(quantity="profile").item()
    assert "only one tolerance" in reason
    assert "only 2 grid(s)" in reason


def test_a_family_that_varies_nothing_else_has_gaps() -> None:
    simulation = Simulation(
        equation=RosenauHyman(3, 2),
        grid=Grid(40, 160),
        scheme=CompactScheme("wide", viscosity=1e-4),
        initial=[Uniform(1.0), Ripple(0.1, 1)],
        t_end=1,
        frames=11,
        integrator=IDA(rtol=1e-4),
    )
    family = Family(sizes=(80, 160), schemes=(CompactScheme("wide"),), viscosities=(1e-4,), tolerances=(1e-4,), accuracy=1e-9)
    tree = converge(simulation, family)
    summary = tree["summary"].sel(quantity="profile")
    assert summary["verdict"].item() == NOT_CONVERGED
    reason = summary["reason"].item()
    for gap in ("nothing shows", "only one tolerance", "only 2 grid(s)", "only one viscosity", "no independent scheme"):
        assert gap in reason


def test_the_ladder_of_a_chain_is_that_of_its_tolerances() -> None:
    """Two integrators of different kind agree within the error bars of both; a single step proves nothing."""
    ring = replace(chain(), grid=Lattice(60), initial=[SolitaryWave(1, 20)], t_end=12, frames=25)
    judged = [converge(replace(ring, integrator=integrator)) for integrator in (Symplectic(step=0.05), IDA(rtol=1e-7))]
    first, second = (tree["summary"].to_dataset().sel(limit="inviscid") for tree in judged)
    for name in ("position 0", "speed 0"):
        one, other = first.sel(quantity=name), second.sel(quantity=name)
        assert one.verdict.item() == "converged"
        assert abs(float(one.value - other.value)) <= float(one.error + other.error) + 1e-9
        assert float(one.error) > 0
    true = SolitaryWave(1, 20).profile(ring.equation).amplitude
    assert abs(float(second["value"].sel(quantity="height 0")) - true) < 1e-5
    single = converge(replace(ring, integrator=Symplectic(step=0.05)), Family(tolerances=(0.05, 0.025)))
    assert (single["summary"].to_dataset()["verdict"] == "converged").any()
    with pytest.raises(InputError, match="a single member"):
        converge(ring, Family(tolerances=(1e-6,)))


@pytest.mark.parametrize(
    ("attempt", "words"),
    [
        (
            lambda: converge(
                single(), Family(sizes=(60,), schemes=(ConservativeScheme(),), tolerances=(1e-4,), viscosities=(0,))
            ),
            "a single member",
        ),
        (lambda: converge(chain(), Family(sizes=(10, 20))), "a chain has no grid to refine"),
    ],
)
def test_bad_families_are_named(attempt: Callable[[], Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        attempt()


def test_members_whose_labels_are_alike_are_all_there() -> None:
    simulation = one_compacton(size=120, t_end=0.2, frames=3, integrator=Rosenbrock())
    viscosities = (0.001 * (1 + 1e-7), 0.001, 0.001 * (1 + 1e-14))
    tree = converge(
        simulation, Family(sizes=(60, 120), schemes=(CompactScheme(),), viscosities=viscosities, tolerances=(1e-4,))
    )
    assert len(tree["members"].children) == 6
    assert group_name("a/b" * 200) != group_name("a/b" * 200 + "c")
    assert len(group_name("\u03bd" * 500).encode()) < 256


def test_a_study_of_a_chain_goes_on_in_its_folder(tmp_path: Path) -> None:
    told: list[str] = []
    first = converge(chain(), Family(tolerances=(1e-4, 1e-5)), folder=tmp_path / "f")
    again = converge(chain(), Family(tolerances=(1e-4, 1e-5)), told.append, folder=tmp_path / "f")
    assert told == ["2/2 have run before"]
    xr.testing.assert_identical(again["summary"].to_dataset(), first["summary"].to_dataset())
