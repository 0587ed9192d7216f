"""What settles late, runs that are one run, and largest values: parts of the budget with known answers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from mol_compactons import (
    CompactScheme,
    ConservativeScheme,
    Family,
    GranularChain,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Simulation,
    SolitaryWave,
    Symplectic,
    judge,
)
from mol_compactons.studies.convergence import converge
from mol_compactons.studies.evidence import Evidence, gather
from mol_compactons.studies.extrapolation import SAFETY
from mol_compactons.studies.family import Member
from mol_compactons.studies.judgement import CONVERGED, NOT_CONVERGED
from mol_compactons.studies.outcome import Outcome, outcome_of
from tests.analysis.relaxing import SUPPORT, Relaxing
from tests.studies.by_hand import COLLISION, LENGTH, UNIT, collision_study, exact, spacing, study

BOTH = (ConservativeScheme(), CompactScheme())
ASYMPTOTIC = {
    "phase shift 1": -4.5,
    "speed 1 after": 0.25,
    "height 1 after": 0.375,
    "phase shift 0": 1.5,
    "speed 0 after": 1.0,
}


def rows(tree: xr.DataTree, limit: str = "inviscid") -> xr.Dataset:
    return tree["summary"].to_dataset().sel(limit=limit)


def assert_honest(summary: xr.Dataset) -> None:
    """Every bar holds what the quantity tends to, and nothing is converged that may still change by more than the accuracy."""
    for name, truth in ASYMPTOTIC.items():
        row = summary.sel(quantity=name)
        assert abs(float(row.value) - truth) <= float(row.error) * (1 + 1e-6) + 1e-6, name
        if float(row.settling) > 0.01 * float(row.scale):
            assert row.verdict.item() == NOT_CONVERGED
            assert "not settled: it may still change by" in row.reason.item()


@given(st.floats(0.35, 3), st.floats(0.01, 20), st.sampled_from([-1, 1]), st.floats(40, 120), st.booleans())
@settings(max_examples=12, deadline=None)
def test_the_bars_hold_what_a_slow_wave_tends_to(power: float, size: float, sign: int, t_end: float, belonging: bool) -> None:
    size = min(size, 10**power / power)
    relaxing = Relaxing(size=sign * size, power=power, t_end=t_end, belonging=belonging)
    assert_honest(rows(collision_study(relaxing, Family(schemes=(ConservativeScheme(),), tolerances=(1e-5,)))))


def test_what_is_settled_is_recognised_and_what_is_not_is_refused() -> None:
    family = Family(schemes=BOTH)
    settled = rows(collision_study(Relaxing(size=0.3, power=3.0, t_end=120), family))
    moving = rows(collision_study(Relaxing(size=5.0, power=1.0, t_end=60), family))
    for name in ASYMPTOTIC:
        assert settled.verdict.sel(quantity=name).item() == CONVERGED
    assert moving.verdict.sel(quantity="phase shift 1").item() == NOT_CONVERGED
    assert moving.reason.sel(quantity="phase shift 1").item().startswith("not settled: it may still change by")
    assert moving.verdict.sel(quantity="phase shift 0").item() == CONVERGED
    assert_honest(settled)
    assert_honest(moving)


def test_a_speed_that_does_not_belong_to_the_height_is_a_change_to_come() -> None:
    """The speed is that of a wave lower by a tenth for all times, as if it were settled."""
    tracks = Relaxing(t_end=120).tracks(COLLISION.to_json())
    tracks["height"][:, 1] *= 1.1
    tracks = tracks.assign(residual=0 * tracks.height, family_speed=tracks.speed * xr.DataArray([1.0, 1.1], dims="wave"))
    tree = judge(study(lambda member: 0.0, Family(schemes=BOTH), tracks=lambda member: tracks, simulation=COLLISION))
    row = rows(tree).sel(quantity="speed 1 after")
    assert float(row.settling) == pytest.approx(0.025, rel=1e-3)
    assert row.verdict.item() == NOT_CONVERGED
    assert float(rows(tree).sel(quantity="speed 0 after").settling) < 1e-6
    given_speed = tracks.assign(family_speed=tracks.speed)
    tree = judge(study(lambda member: 0.0, Family(schemes=BOTH), tracks=lambda member: given_speed, simulation=COLLISION))
    assert float(rows(tree).sel(quantity="speed 1 after").settling) < 1e-6


def test_what_the_grid_changes_is_no_settling() -> None:
    """A shift that grows in time by an error of h^2 is a matter of the grid."""

    def drifting(member: Member) -> xr.Dataset:
        tracks = Relaxing(t_end=90).tracks(member.simulation.to_json())
        tracks["position"][:, 1] += 1e-3 * spacing(member) ** 2 * (tracks.t - 16).where(tracks.t > 16, 0) ** 2
        return tracks

    summary = rows(judge(study(lambda member: 0.0, Family(schemes=BOTH), tracks=drifting, simulation=COLLISION)))
    row = summary.sel(quantity="phase shift 1")
    assert abs(float(row.value) + 4.5) <= float(row.error)
    assert float(row.settling) < 0.2 * float(row.space)


def outcomes(tree: xr.DataTree) -> list[Outcome]:
    return [outcome_of(member.to_dataset(), 60) for member in tree["members"].children.values()]


def test_too_few_frames_leave_open_whether_a_wave_has_settled() -> None:
    tracks = Relaxing(t_end=90).tracks(COLLISION.to_json())
    sparse = tracks.isel(t=np.r_[:20:4, 64, 120:360:32])
    tree = judge(study(lambda member: 0.0, Family(schemes=BOTH), tracks=lambda member: sparse, simulation=COLLISION))
    row = rows(tree).sel(quantity="phase shift 1")
    assert float(row.value) == pytest.approx(-4.5)
    assert np.isinf(row.settling)
    assert "too few frames" in row.reason.item()
    assert row.verdict.item() == NOT_CONVERGED


def test_two_tolerances_that_are_one_run_are_one() -> None:
    """Steps that are cut to the times of the frames: the same number of steps, the same numbers."""
    tree = study(lambda member: 1e-3 * spacing(member) ** 2, Family(schemes=BOTH))
    assert gather("profile", [o for o in outcomes(tree) if o.member.scheme.startswith("Cons")]).gaps == ()
    for member in tree["members"].children.values():
        member.attrs["solver_steps"] = 100
    found = gather("profile", [o for o in outcomes(tree) if o.member.scheme.startswith("Cons")])
    assert found.gaps == ("only one tolerance",)


def gathered(tree: xr.DataTree, kind: str = "Cons") -> Evidence:
    return gather("profile", [one for one in outcomes(tree) if one.member.scheme.startswith(kind)])


def test_tolerances_that_change_nothing_are_one() -> None:
    """The same numbers, bit for bit, whatever the counters say."""
    changing = Family(schemes=(ConservativeScheme(),))
    assert gathered(study(lambda member: 0.0, changing, whisper=0.0)).gaps == ("only one tolerance",)
    assert gathered(study(lambda member: 1e-3 * member.tolerance, changing, whisper=0.0)).gaps == ()


def test_viscosities_that_change_nothing_are_one() -> None:
    family = Family(schemes=(ConservativeScheme(),), grid_viscosities=(0.2, 0.1))
    assert "only one viscosity" in gathered(study(lambda member: spacing(member) ** 2, family, whisper=0.0)).gaps
    found = gathered(study(lambda member: spacing(member) ** 2 + 1e-9 * member.viscosity, family, whisper=0.0))
    assert "only one viscosity" not in found.gaps


def test_of_many_viscosities_the_smallest_counts() -> None:
    """Its grids, its tolerances and its value, and no more of the viscosity where it is none."""
    irregular = {60: 0.0, 120: 0.1, 240: 0.3}

    def deviation(member: Member) -> float:
        if member.viscosity:
            return irregular[member.size] + member.viscosity
        return 1e-3 * spacing(member) ** 2 + member.tolerance - 1e-6

    for viscosities in ((1e-3, 0.0), (4e-3, 1e-3, 0.0), (4e-3, 2e-3, 1e-3, 0.0)):
        family = Family(schemes=(ConservativeScheme(),), viscosities=viscosities, tolerances=(1e-5, 1e-6))
        found = gathered(study(deviation, family))
        assert (found.irregularities, found.gaps) == ((), ())
        assert found.rate == pytest.approx(2, rel=1e-3)
        assert np.linalg.norm(found.value) == pytest.approx(exact(), rel=1e-6)
        fine = 1e-3 * ((LENGTH / 120) ** 2 - (LENGTH / 240) ** 2) * UNIT
        expected = {"space": SAFETY * fine / 3, "time": 9e-6 * UNIT, "viscosity": 0.0, "settling": 0.0, "reading": 0.0}
        assert found.budget == pytest.approx(expected, rel=1e-3)


def chain_study(step: float, frames: int) -> xr.DataTree:
    """A chain whose own step is cut to the times of the frames."""
    own = Simulation(
        equation=GranularChain(PowerContact(n=3 / 2)),
        grid=Lattice(40),
        scheme=NearestNeighbours(),
        initial=[SolitaryWave(speed=1, center=10)],
        t_end=3,
        frames=frames,
        integrator=Symplectic(step=step),
    )
    return converge(own)


def test_a_step_longer_than_the_time_between_frames_still_has_an_error() -> None:
    """All of 0.8, 0.4, 0.2 and 0.1 come to one step of 0.1: half and a quarter of it are taken instead."""
    tree = chain_study(step=0.2, frames=31)
    tolerances = sorted(outcome.member.tolerance for outcome in outcomes(tree))
    assert tolerances == pytest.approx([0.025, 0.05, 0.1])
    assert sorted(outcome.steps or 0 for outcome in outcomes(tree)) == [30, 60, 120]
    row = rows(tree).sel(quantity="profile")
    assert float(row.time) > 0
    truth = SolitaryWave(speed=1, center=10).values(GranularChain(PowerContact(n=3 / 2)), Lattice(40), 3.0)
    assert abs(float(row.value) - np.linalg.norm(truth[0])) <= float(row.error)


def test_tolerances_close_to_each_other_show_a_part_of_the_error() -> None:
    """The error is ten times the tolerance, and bars from a pair hold it however close they are."""
    for tolerances in ((1e-5, 1e-6), (1.1e-6, 1e-6)):
        tree = study(lambda member: 10 * member.tolerance, Family(schemes=BOTH, tolerances=tolerances))
        found = gather("profile", [o for o in outcomes(tree) if o.member.scheme.startswith("Cons")])
        assert found.budget["time"] >= 0.99 * 10 * 1e-6 * np.sqrt(15)


def ripple(member: Member, heights: dict[int, float], other: float = 0.0) -> xr.Dataset:
    tracks = Relaxing(t_end=60).tracks(member.simulation.to_json())
    tracks["height_left"] += heights[member.size] + (other if member.scheme.startswith("Compact") else 0.0)
    return tracks


def test_a_largest_value_is_not_extrapolated() -> None:
    """Its bar is three times the last change, or half of the one before, and what other schemes differ by."""
    heights = {100: 0.03, 200: 0.02, 400: 0.01}
    tree = judge(study(lambda m: 0.0, Family(schemes=BOTH), tracks=lambda m: ripple(m, heights, 0.004), simulation=COLLISION))
    row = rows(tree).sel(quantity="height left")
    assert float(row.space) == pytest.approx(0.01 / (2**0.4 - 1))
    assert float(row.scheme) == pytest.approx(0.004)
    either = (pytest.approx(0.02), pytest.approx(0.024))
    assert float(row.value) in either, "the schemes have the same error, and so either may be the best"
    smooth = rows(tree).sel(quantity="mass left")
    assert float(smooth.space) == pytest.approx(0, abs=1e-9)


@given(st.floats(0.45, 4), st.floats(1e-6, 1), st.floats(0, 1))
@settings(max_examples=10, deadline=None)
def test_the_bar_of_a_ripple_holds_its_limit_whatever_the_rate(rate: float, size: float, limit: float) -> None:
    heights = {points: limit + size * (100 / points) ** rate for points in (100, 200, 400)}
    family = Family(schemes=(ConservativeScheme(),), tolerances=(1e-5,))
    tree = study(lambda m: 0.0, family, tracks=lambda m: ripple(m, heights), simulation=COLLISION)
    found = gather("height left", outcomes(tree))
    assert abs(float(found.value) - limit - 0.01) <= found.error * (1 + 1e-6)


def test_two_ripples_that_agree_by_chance_prove_nothing() -> None:
    heights = {100: 0.05, 200: 0.02, 400: 0.02}
    tree = judge(study(lambda m: 0.0, Family(schemes=BOTH), tracks=lambda m: ripple(m, heights), simulation=COLLISION))
    assert float(rows(tree).sel(quantity="height left").space) >= 0.03


def test_a_largest_value_is_not_extrapolated_in_the_viscosity_either() -> None:
    heights = {0.4: 0.01, 0.2: 0.016, 0.1: 0.02}

    def tracks(member: Member) -> xr.Dataset:
        return ripple(member, dict.fromkeys((100, 200, 400), heights[member.viscosity]))

    family = Family(schemes=BOTH, viscosities=tuple(heights))
    row = rows(judge(study(lambda m: 0.0, family, tracks=tracks, simulation=COLLISION)), "viscous").sel(quantity="height left")
    assert float(row.value) == pytest.approx(0.03)
    assert float(row.viscosity) == pytest.approx(0.004 / (2**0.4 - 1))


@pytest.mark.parametrize("ratio", [2.0, 1.1, 1.01])
def test_viscosities_close_to_each_other_show_a_part_of_a_ripple(ratio: float) -> None:
    def tracks(member: Member) -> xr.Dataset:
        return ripple(member, dict.fromkeys((100, 200, 400), 0.1 * member.viscosity))

    family = Family(schemes=BOTH, viscosities=(0.1 * ratio, 0.1))
    row = rows(judge(study(lambda m: 0.0, family, tracks=tracks, simulation=COLLISION)), "viscous").sel(quantity="height left")
    assert float(row.viscosity) >= 0.01


@pytest.mark.parametrize("sizes", [(100, 200, 400), (380, 390, 400), (150, 152, 154)])
def test_grids_close_to_each_other_show_a_part_of_a_ripple(sizes: tuple[int, ...]) -> None:
    heights = {points: 0.02 * (100 / points) ** 0.5 for points in sizes}
    family = Family(sizes=sizes, schemes=BOTH)
    row = rows(judge(study(lambda m: 0.0, family, tracks=lambda m: ripple(m, heights), simulation=COLLISION)))
    assert float(row.sel(quantity="height left").space) >= heights[sizes[-1]]


def test_the_range_of_a_largest_value_in_its_window_counts() -> None:
    def scattered(member: Member) -> xr.Dataset:
        tracks = ripple(member, dict.fromkeys((100, 200, 400), 0.0))
        tracks["height_left"] += 0.004 * (np.arange(tracks.sizes["t"]) % 2)
        return tracks

    summary = rows(judge(study(lambda m: 0.0, Family(schemes=BOTH), tracks=scattered, simulation=COLLISION)))
    assert float(summary.sel(quantity="height left").settling) >= 0.002
    assert float(summary.sel(quantity="height left").reading) == pytest.approx(0.002)


def test_a_study_without_tracks_needs_no_settling_and_no_reading() -> None:
    found = gather("profile", outcomes(study(lambda member: 0.0, Family(schemes=(ConservativeScheme(),)))))
    assert found.budget["settling"] == found.budget["reading"] == 0


def read(jitter: float, misfit: float, seed: int = 0) -> xr.Dataset:
    """A judged collision whose places and heights are read with errors of a given size, by fits of a given misfit."""
    rng = np.random.default_rng(seed)

    def tracks(member: Member) -> xr.Dataset:
        one = Relaxing(t_end=90).tracks(member.simulation.to_json())
        one["position"] = one.position + rng.normal(0, jitter, one.position.shape)
        one["position"].attrs["period"] = 200.0
        one["height"] = one.height * (1 + rng.normal(0, jitter, one.height.shape))
        one["residual"] = one.height * 0 + misfit
        return one

    return rows(judge(study(lambda member: 0.0, Family(schemes=BOTH), tracks=tracks, simulation=COLLISION)))


def test_the_error_of_reading_is_that_of_the_readings() -> None:
    """Ten times the errors of the frames are ten times the error; and the bars hold the truth in thirty of thirty cases."""
    for seed in range(3):
        fine, coarse = read(1e-4, 0.0, seed), read(1e-3, 0.0, seed)
        for name in (*ASYMPTOTIC, "position 1"):
            first, second = (float(one.reading.sel(quantity=name)) for one in (fine, coarse))
            assert second == pytest.approx(10 * first, rel=0.02)
            assert first > 0
        assert_honest(fine)
        assert_honest(coarse)


def test_what_the_fit_leaves_open_is_an_error_of_reading() -> None:
    """A misfit of 1 % leaves open 1 % of the height, and of the place a quarter of a per cent of the support, twice."""
    exact, off = read(0.0, 0.0), read(0.0, 0.01)
    added = off.reading - exact.reading
    assert float(added.sel(quantity="height 1 after")) == pytest.approx(0.01 * 0.375)
    assert float(added.sel(quantity="phase shift 1")) == pytest.approx(0.005 * SUPPORT)
    assert float(added.sel(quantity="position 1")) == pytest.approx(0.0025 * SUPPORT)
    assert float(added.sel(quantity="speed 1 after")) == 0


def test_a_later_end_only_narrows_the_bar() -> None:
    """Bars of one relaxation, seen for longer and longer."""
    family, one = Family(schemes=(ConservativeScheme(),), tolerances=(1e-5,)), Relaxing(size=2.0, power=1.0)
    bars = [
        float(rows(collision_study(replace(one, t_end=t), family)).sel(quantity="phase shift 1").settling)
        for t in (40, 80, 160)
    ]
    assert bars == sorted(bars, reverse=True)
    assert bars[-1] < 0.5 * bars[0]
