from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from mol_compactons import CompactScheme, ConservativeScheme, Family, FourierScheme, judge
from mol_compactons.studies.extrapolation import SAFETY, WIDE_SAFETY
from mol_compactons.studies.family import Member
from mol_compactons.studies.judgement import BUDGET, CONVERGED, CONVERGING, NOT_CONVERGED
from tests.analysis.relaxing import Relaxing
from tests.studies.by_hand import COLLISION, LENGTH, UNIT, exact, spacing, study

BOTH = (ConservativeScheme(), CompactScheme())

QUARTER, HALF, WHOLE = (LENGTH / size for size in (60, 120, 240))


def profile(tree: xr.DataTree, limit: str = "inviscid") -> xr.Dataset:
    """The row of a judged study on the last profile."""
    return judge(tree)["summary"].to_dataset().sel(limit=limit, quantity="profile")


def second_order(member: Member) -> float:
    """One thousandth h^2, whatever the scheme, and a hundred times the tolerance."""
    return 1e-3 * spacing(member) ** 2


def test_a_second_order_family_is_extrapolated_to_the_exact_wave() -> None:
    row = profile(study(second_order))
    assert row.verdict.item() == CONVERGED
    assert float(row.rate) == pytest.approx(2, abs=1e-6)
    assert float(row.value) == pytest.approx(exact(), rel=1e-9)
    assert float(row.scale) == pytest.approx(exact(), rel=1e-4)
    fine = 1e-3 * (HALF**2 - WHOLE**2) * UNIT
    assert float(row.space) == pytest.approx(SAFETY * fine / 3, rel=1e-6)
    assert float(row.time) == pytest.approx(0, abs=1e-11)
    assert float(row.error) == pytest.approx(sum(float(row[part]) for part in BUDGET))


@given(st.floats(0.5, 5), st.floats(-3, -1), st.sampled_from([1, -1]))
@settings(max_examples=15)
def test_the_error_bar_holds_the_truth_whatever_the_rate(rate: float, exponent: float, sign: int) -> None:
    row = profile(study(lambda member: sign * 10**exponent * spacing(member) ** rate))
    true = abs(float(row.value) - exact())
    assert true <= float(row.error) + 1e-12
    assert float(row.error) < 3 * 10**exponent * QUARTER**rate * UNIT + 1e-9


def test_two_schemes_that_tend_to_different_waves_are_not_converged() -> None:
    def deviation(member: Member) -> float:
        other = member.scheme.startswith("Compact")
        return (2 if other else 1) * second_order(member) + (0.1 if other else 0.0)

    family = Family(schemes=(ConservativeScheme(), CompactScheme()))
    row = profile(study(deviation, family))
    assert row.verdict.item() == NOT_CONVERGED
    relative = f"{0.1 * UNIT / float(row.scale):.1e}"
    assert f"CompactScheme(second_difference=wide) differs by {relative}, more than the error bars" in row.reason.item()
    assert float(row.scheme) == pytest.approx(0.1 * UNIT, rel=1e-6)
    agreeing = profile(study(second_order, family))
    assert agreeing.verdict.item() == CONVERGED
    assert float(agreeing.scheme) == pytest.approx(0, abs=1e-9)


def test_differences_that_do_not_shrink_are_not_converged() -> None:
    """0, 1 and 3 hundredths on the three grids: the finest is the farthest off."""
    steps = {60: 0.0, 120: 0.1, 240: 0.3}
    row = profile(study(lambda member: steps[member.size]))
    assert row.verdict.item() == NOT_CONVERGED
    assert "the differences between the grids do not shrink" in row.reason.item()
    assert np.isnan(row.rate)
    assert float(row.space) == pytest.approx(WIDE_SAFETY * 0.2 * UNIT, rel=1e-6)


def test_the_error_of_time_is_what_a_looser_tolerance_does() -> None:
    family = Family(tolerances=(1e-5, 1e-6))
    row = profile(study(lambda member: second_order(member) + 100 * (member.tolerance - 1e-6), family))
    assert float(row.time) == pytest.approx(100 * 9e-6 * UNIT, rel=1e-6)


def test_what_was_not_varied_is_a_gap() -> None:
    one_scheme = Family(schemes=(ConservativeScheme(),))
    row = profile(study(second_order, one_scheme))
    assert (row.verdict.item(), row.reason.item()) == (CONVERGING, "no independent scheme has a value")
    one_tolerance = Family(schemes=(ConservativeScheme(), CompactScheme()), tolerances=(1e-6,))
    row = profile(study(second_order, one_tolerance))
    assert (row.verdict.item(), row.reason.item()) == (CONVERGING, "only one tolerance")
    two_grids = Family(schemes=(ConservativeScheme(), CompactScheme()), sizes=(120, 240))
    reason = profile(study(lambda member: 10 * second_order(member), two_grids)).reason.item()
    assert "only 2 grid(s) ran to the end" in reason


def test_viscosity_that_stays_while_the_grid_is_refined_is_extrapolated_to_none() -> None:
    """Deviation eps / 2 + h^2 / 1000 with eps = 2e-3 and 1e-3: linearly to zero, with the whole correction as error."""
    family = Family(schemes=(ConservativeScheme(), CompactScheme()), viscosities=(2e-3, 1e-3))
    row = profile(study(lambda member: second_order(member) + 0.5 * member.viscosity, family), "viscous")
    assert float(row.value) == pytest.approx(exact(), rel=1e-9)
    assert float(row.viscosity) == pytest.approx(0.5e-3 * UNIT, rel=1e-6)
    assert row.verdict.item() == CONVERGED


def test_viscosity_that_vanishes_with_the_grid_counts_by_what_it_leaves() -> None:
    """In grid units the limits for h -> 0 of the two viscosities should be one; their distance is an error."""
    family = Family(schemes=(ConservativeScheme(), CompactScheme()), grid_viscosities=(0.2, 0.1))
    apart = profile(study(lambda member: second_order(member) + 1e-2 * member.viscosity, family), "conservative")
    assert float(apart.viscosity) == pytest.approx(1e-3 * UNIT, rel=1e-6)
    alone = Family(schemes=(ConservativeScheme(), CompactScheme()), grid_viscosities=(0.1,))
    assert profile(study(second_order, alone), "conservative").reason.item() == "only one viscosity"


def test_a_drift_is_a_quantity_of_its_own() -> None:
    summary = judge(study(second_order, drift=0.02))["summary"].to_dataset().sel(limit="inviscid", quantity="mass drift")
    assert float(summary.value) == pytest.approx(0.02)
    assert float(summary.scale) == 1


def test_a_stricter_accuracy_asks_for_more_and_changes_no_number() -> None:
    judged = judge(study(second_order))
    strict = judge(judged, accuracy=1e-9)
    one, other = (tree["summary"].to_dataset().sel(limit="inviscid", quantity="profile") for tree in (judged, strict))
    assert (one.verdict.item(), other.verdict.item()) == (CONVERGED, CONVERGING)
    assert "above the accuracy 1e-09" in other.reason.item()
    for name in ("value", "error", *BUDGET, "rate", "scale"):
        assert float(one[name]) == float(other[name])
    assert '"accuracy": 1e-09' in strict.attrs["family"]


def test_the_ladder_is_the_distance_of_each_grid_from_its_limit() -> None:
    ladder = judge(study(second_order))["ladder"].to_dataset()
    scheme = "ConservativeScheme(order=4)"
    distances = ladder.distance.sel(limit="inviscid", scheme=scheme, viscosity=0.0, quantity="profile")
    assert ladder["size"].values.tolist() == [60, 120, 240]
    assert ladder.spacing.values == pytest.approx([QUARTER, HALF, WHOLE])
    expected = 1e-3 * np.array([QUARTER, HALF, WHOLE]) ** 2 * UNIT / exact()
    assert distances.values == pytest.approx(expected, rel=1e-3)


DEAD = "members of CompactScheme(second_difference=wide) have no value (N = 240), and so it is no independent evidence"


def dead(member: Member) -> bool:
    """All members of the compact scheme on the finest grid."""
    return member.scheme.startswith("Compact") and member.size == 240


def test_a_scheme_that_died_on_the_finest_grid_is_no_independent_evidence() -> None:
    tree = judge(study(second_order, Family(schemes=BOTH), fails=dead))
    summary = tree["summary"].to_dataset().sel(limit="inviscid")
    assert (summary.verdict != CONVERGED).all()
    assert summary.reason.sel(quantity="profile").item() == f"2 of 4 {DEAD}"
    assert (int(summary.failed), int(summary.members)) == (2, 8)
    alive = judge(study(second_order, Family(schemes=BOTH)))["summary"].to_dataset().sel(limit="inviscid")
    assert (int(alive.failed), alive.verdict.sel(quantity="profile").item()) == (0, CONVERGED)


def test_a_scheme_that_died_with_the_smallest_viscosity_is_none_either() -> None:
    family = Family(schemes=BOTH, grid_viscosities=(0.2, 0.1))
    tree = study(second_order, family, fails=lambda member: member.scheme.startswith("Compact") and member.viscosity == 0.1)
    row = profile(tree, "conservative")
    assert row.verdict.item() == CONVERGING
    assert "4 of 7 members of CompactScheme(second_difference=wide) have no value (N = 60, 120, 240)" in row.reason.item()


def test_a_scheme_that_died_with_everything_is_named() -> None:
    row = profile(study(second_order, Family(schemes=BOTH), fails=lambda member: member.scheme.startswith("Compact")))
    assert row.verdict.item() == CONVERGING
    assert "4 of 4 members of CompactScheme" in row.reason.item()


def test_what_the_best_scheme_lacks_on_the_finest_grid_is_named() -> None:
    family = Family(schemes=BOTH, sizes=(60, 90, 120, 240))
    row = profile(study(second_order, family, fails=lambda member: member.size == 240))
    assert row.verdict.item() != CONVERGED
    assert "have no value (N = 240)" in row.reason.item()


def test_another_scheme_that_ran_to_the_end_bears_witness_and_the_dead_one_is_named() -> None:
    family = Family(schemes=(*BOTH, FourierScheme()))
    row = profile(study(second_order, family, fails=dead))
    assert row.verdict.item() == CONVERGED
    assert "2 of 4 members of CompactScheme(second_difference=wide) have no value" in row.reason.item()


def test_members_without_a_value_of_a_quantity_count_for_it_as_dead() -> None:
    """A wave that was lost has no position, though the member ran to its end."""

    def tracks(member: Member) -> xr.Dataset:
        one = Relaxing(t_end=60).tracks(member.simulation.to_json())
        if member.scheme.startswith("Compact") and member.size == 400:
            one["position"][-1, 1] = np.nan
        return one

    tree = judge(study(lambda member: 0.0, Family(schemes=BOTH), tracks=tracks, simulation=COLLISION))
    summary = tree["summary"].to_dataset().sel(limit="inviscid")
    assert summary.verdict.sel(quantity="position 0").item() == CONVERGED
    assert summary.verdict.sel(quantity="position 1").item() != CONVERGED
    assert "2 of 4 members" in summary.reason.sel(quantity="position 1").item()
    assert int(summary.failed) == 0


def test_two_schemes_with_the_same_numbers_are_one() -> None:
    """Whatever they are called."""
    family = Family(schemes=BOTH)
    row = profile(study(lambda member: second_order(member) + member.tolerance, family, whisper=0.0))
    assert row.verdict.item() == CONVERGING
    assert "gives the same numbers as" in row.reason.item()
    assert "bit for bit, and so it is no independent evidence" in row.reason.item()

    def apart(member: Member) -> float:
        return second_order(member) + member.tolerance * (1 + 1e-6 * member.scheme.startswith("Compact"))

    assert profile(study(apart, family, whisper=0.0)).verdict.item() == CONVERGED


def test_one_kind_of_scheme_is_not_independent_of_itself() -> None:
    family = Family(schemes=(ConservativeScheme(order=2), ConservativeScheme(order=4)))
    row = profile(study(second_order, family))
    assert (row.verdict.item(), row.reason.item()) == (CONVERGING, "no independent scheme has a value")
