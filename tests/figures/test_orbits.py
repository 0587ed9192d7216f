from __future__ import annotations

import numpy as np
import pytest

from mol_compactons import Compacton, Grid, PadeScheme, RosenauHyman, Simulation, orbit
from mol_compactons.figures import orbit_overview
from tests.figures.arrangement import places


def test_the_multipliers_the_circle_the_wave_and_the_mode_are_drawn() -> None:
    equation = RosenauHyman(2, 2, absolute=True)
    dataset = orbit(Simulation(equation, Grid(16, 60), [Compacton(1, 8)], 1, PadeScheme("pade_8")))
    figure = orbit_overview(dataset)
    left, right = figure.axes
    assert places(figure) == [(0, 0), (0, 1)]
    circle, dots = left.lines
    across, up = (np.asarray(data) for data in (circle.get_xdata(), circle.get_ydata()))
    assert np.hypot(across, up) == pytest.approx(np.ones(across.size))
    assert np.array_equal(np.asarray(dots.get_xdata()), dataset.multiplier_real.values)
    assert np.array_equal(np.asarray(dots.get_ydata()), dataset.multiplier_imag.values)
    assert dataset.attrs["verdict"] in left.get_title()
    wave, mode = right.lines
    assert np.array_equal(np.asarray(wave.get_ydata()), dataset.u.values)
    drawn, own = np.asarray(mode.get_ydata()), dataset.mode_real.values[0, 0]
    assert np.abs(drawn).max() == pytest.approx(float(dataset.u.max()))
    assert drawn * np.abs(own).max() == pytest.approx(own * np.abs(drawn).max(), abs=1e-12)
    assert f"{float(dataset.modulus[0]):.6g}" in right.get_title()
    figure.canvas.draw()
