from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import Compacton, GranularCompacton, Grid, Lattice
from mol_compactons.analysis.peaks import peaks
from tests.systems import fitted_order

GRID = Grid(length=20, size=80)


def test_peaks_at_the_ends_of_the_box() -> None:
    lattice = Lattice(50)
    for center in (0.0, 49.6, 0.3):
        wave = np.exp(-(lattice.offset(center) ** 2) / 20)
        positions, heights, widths = peaks(-wave, lattice, -1, 0.1)
        assert (positions - center + 25) % 50 == pytest.approx([25], abs=1e-3)
        assert heights == pytest.approx([1], abs=1e-3)
        assert widths == pytest.approx([2 * np.sqrt(20 * np.log(2))], rel=0.01)


@given(st.floats(-40, 40), st.floats(0.5, 3), st.sampled_from([1, -1]))
def test_the_top_of_a_parabola_is_found_to_round_off(center: float, height: float, sign: int) -> None:
    """What is a quartic through five points is that everywhere between them."""
    profile = sign * (height - 0.1 * GRID.offset(center) ** 2)
    positions, heights, _ = peaks(profile, GRID, sign, 0.1)
    assert positions.size == 1
    distance = (positions[0] - center + 10) % 20 - 10
    assert abs(distance) < 1e-9
    assert heights == pytest.approx([height], rel=1e-12)


@given(st.integers(0, 79))
def test_a_shift_by_whole_points_moves_the_peaks_by_them(steps: int) -> None:
    profile = np.exp(-(GRID.offset(3.1) ** 2)) + 0.5 * np.exp(-2 * GRID.offset(12.77) ** 2)
    before, heights_before, widths_before = peaks(profile, GRID, 1, 0.1)
    after, heights_after, widths_after = peaks(np.roll(profile, steps), GRID, 1, 0.1)
    assert np.sort(after % 20) == pytest.approx(np.sort((before + steps * GRID.spacing) % 20), abs=1e-9)
    assert np.sort(heights_after) == pytest.approx(np.sort(heights_before), rel=1e-12)
    assert np.sort(widths_after) == pytest.approx(np.sort(widths_before), rel=1e-9)


def test_a_coarse_grid_shows_where_the_crest_is_at_a_high_order() -> None:
    """Of cos^2, the compacton of n = 2, the position is of the fifth order, the height of the sixth at least."""
    shape, sizes = GranularCompacton(2).compacton(1), [40, 80, 160]
    position_errors, height_errors = [], []
    for size in sizes:
        grid = Grid(length=20, size=size)
        values = Compacton(1, 10.13).values(GranularCompacton(2), grid)[0]
        positions, heights, _ = peaks(values, grid, 1, 0.1)
        position_errors.append(abs(float(positions[0]) - 10.13))
        height_errors.append(abs(float(heights[0]) - shape.amplitude))
    assert fitted_order(sizes, position_errors) > 3.5
    assert fitted_order(sizes, height_errors) > 4.5
    assert position_errors[-1] < 1e-5


def test_the_width_is_that_at_half_the_height() -> None:
    """For n = 3 the compacton is M cos(z / 2): half its height lies at |z| = 2 pi / 3."""
    grid = Grid(length=20, size=2000)
    values = Compacton(1, 10).values(GranularCompacton(3), grid)[0]
    _, _, widths = peaks(values, grid, 1, 0.1)
    assert widths == pytest.approx([4 * np.pi / 3], abs=1e-4)


def test_only_peaks_of_the_sign_and_of_the_least_height_count() -> None:
    profile = np.exp(-(GRID.offset(5) ** 2)) - 0.7 * np.exp(-(GRID.offset(14) ** 2)) + 0.05 * np.exp(-4 * GRID.offset(10) ** 2)
    assert peaks(profile, GRID, 1, 0.2)[0] == pytest.approx([5], abs=1e-3)
    assert peaks(profile, GRID, -1, 0.2)[0] == pytest.approx([14], abs=1e-3)
    assert np.sort(peaks(profile, GRID, 1, 0.02)[0]) == pytest.approx([5, 10], abs=1e-2)
    assert [part.size for part in peaks(profile, GRID, 1, 2.0)] == [0, 0, 0]
    assert [part.size for part in peaks(np.zeros(80), GRID, 1, 0.1)] == [0, 0, 0]
