from __future__ import annotations

import numpy as np
import pytest

from mol_compactons.studies.outcome import on_grid, outcome_of
from tests.studies.by_hand import study


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


def test_a_profile_on_a_coarser_grid() -> None:
    """Every other point where the points coincide, a periodic spline where not."""
    fine = np.cos(2 * np.pi * np.arange(120) / 120)
    assert np.array_equal(on_grid(fine, 60), fine[::2])
    coarse = np.cos(2 * np.pi * np.arange(50) / 50)
    assert on_grid(fine, 50) == pytest.approx(coarse, abs=1e-6)
