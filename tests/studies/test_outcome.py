from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from mol_compactons.analysis.collisions import first_collision
from mol_compactons.studies.outcome import Outcome, on_grid, outcome_of
from tests.analysis.relaxing import MOMENT, Relaxing, with_a_third
from tests.studies.by_hand import COLLISION, study


def test_a_fingerprint_tells_runs_from_each_other() -> None:
    """One bit in a frame or in a conserved quantity, and no name."""
    member = next(iter(study(lambda member: 0.0)["members"].children.values())).to_dataset()
    own = outcome_of(member, 60)
    renamed = outcome_of(member.assign_attrs(label="another", tolerance=0.5), 60)
    assert own.is_same_run_as(renamed)
    for name in ("W", "mass"):
        changed = member.copy(deep=True)
        changed[name].values[1] = np.nextafter(changed[name].values[1], 2)
        assert not own.is_same_run_as(outcome_of(changed, 60))
    assert not own.has_the_steps_of(outcome_of(changed, 60))
    counted = [outcome_of(one.assign_attrs(solver_steps=7), 60) for one in (member, changed)]
    assert counted[0].has_the_steps_of(counted[1])


def outcome_with(tracks: xr.Dataset) -> Outcome:
    members = study(lambda member: 0.0, tracks=lambda member: tracks, simulation=COLLISION)["members"].children
    return outcome_of(next(iter(members.values())).to_dataset(), 60)


@pytest.mark.parametrize(("back", "counts"), [(20, True), (21, False)])
def test_the_last_twenty_frames_tell_how_exactly_a_place_is_read(back: int, counts: bool) -> None:
    """Before any collision; of what is left half the range."""
    tracks = Relaxing(t_end=9.0).tracks(COLLISION.to_json())
    quiet = outcome_with(tracks).readings
    assert quiet["position 0"] < 1e-12
    tracks["position"][-back, 0] += 0.1
    tracks["height_left"][-back] += 0.004
    readings = outcome_with(tracks).readings
    assert (readings["position 0"] > 1e-3) == counts
    assert readings["height left"] == pytest.approx(0.002 * counts)


def test_what_is_left_is_that_of_the_waves_that_collided() -> None:
    """Though another met nobody: in the last window, and not in the last frame."""
    tracks = with_a_third(24 + 30 - 2 * MOMENT, Relaxing(t_end=60.0).tracks(COLLISION.to_json()))
    tracks["mass_left"][-1] = 0.5
    collision = first_collision(tracks)
    assert np.isnan(collision.phase_shift).values.tolist() == [False, False, True]
    assert 0.01 < float(collision.mass_left) < 0.1
    assert outcome_with(tracks).values["mass left"] == pytest.approx(float(collision.mass_left))


def test_a_profile_on_a_coarser_grid() -> None:
    """Every other point where the points coincide, a periodic spline where not."""
    fine = np.cos(2 * np.pi * np.arange(120) / 120)
    assert np.array_equal(on_grid(fine, 60), fine[::2])
    coarse = np.cos(2 * np.pi * np.arange(50) / 50)
    assert on_grid(fine, 50) == pytest.approx(coarse, abs=1e-6)
