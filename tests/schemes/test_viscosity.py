from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from mol_compactons import CompactScheme, ConservativeScheme, FourierScheme, GranularCompacton, Grid
from mol_compactons.schemes.viscosity import Damping
from tests.systems import random_state, right_hand_side

GRID = Grid(length=10, size=40)


@pytest.mark.parametrize("power", [4, 6])
def test_a_ripple_is_damped_at_the_rate_of_its_wavenumber(power: Literal[4, 6]) -> None:
    """-eps k^p for long ripples, and the rate `fastest` for the shortest."""
    damping = Damping(ConservativeScheme(viscosity=0.3, viscosity_order=power), GRID.spacing)
    for periods, rate in ((1, 0.3 * (2 * np.pi / GRID.length) ** power), (GRID.size // 2, damping.fastest)):
        ripple = np.cos(2 * np.pi * periods * np.arange(GRID.size) / GRID.size)
        out = np.zeros(GRID.size)
        damping.add(ripple, out)
        assert np.allclose(out, -rate * ripple, atol=0.01 * rate)


@pytest.mark.parametrize("power", [4, 6])
@pytest.mark.parametrize("scheme", [CompactScheme, ConservativeScheme, FourierScheme])
def test_grid_units_are_the_spacing_to_the_power_less_one(scheme: type, power: int) -> None:
    def rate(**viscosity: float) -> np.ndarray:
        system = scheme(**{"viscosity": 0.0, "viscosity_order": power} | viscosity).discretize(GranularCompacton(2), GRID)
        return right_hand_side(system, random_state(3, 1, GRID.size))

    absolute, relative = rate(viscosity=0.2 * GRID.spacing ** (power - 1)), rate(grid_viscosity=0.2)
    assert np.allclose(absolute, relative, rtol=1e-12)
    assert np.abs(absolute - rate()).max() > 1e-3 * np.abs(absolute).max()


@pytest.mark.parametrize("power", [4, 6])
def test_the_damping_keeps_mass_and_takes_momentum(power: Literal[4, 6]) -> None:
    state, out = random_state(4, 1, GRID.size)[0], np.zeros(GRID.size)
    Damping(ConservativeScheme(viscosity=1.0, viscosity_order=power), GRID.spacing).add(state, out)
    assert abs(float(out.sum())) < 1e-12 * float(np.abs(out).sum())
    assert float(out @ state) < 0
