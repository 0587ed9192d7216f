from __future__ import annotations

import numpy as np
import pytest

from mol_compactons.studies.outcome import on_grid


def test_a_profile_on_a_coarser_grid() -> None:
    """Every other point where the points coincide, a periodic spline where not."""
    fine = np.cos(2 * np.pi * np.arange(120) / 120)
    assert np.array_equal(on_grid(fine, 60), fine[::2])
    coarse = np.cos(2 * np.pi * np.arange(50) / 50)
    assert on_grid(fine, 50) == pytest.approx(coarse, abs=1e-6)
