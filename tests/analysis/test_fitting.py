from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mol_compactons import (
    Compacton,
    GranularChain,
    GranularCompacton,
    Grid,
    Lattice,
    Nesterenko,
    PowerContact,
    RosenauHyman,
    SolitaryWave,
)
from mol_compactons.analysis.fitting import fit
from mol_compactons.equations.base import Equation

GRID = Grid(length=60, size=600)
CHAINS = [GranularChain(PowerContact(n)) for n in (1.5, 3)] + [GranularChain(PowerContact(3, linear=0.5))]


@given(st.floats(1.2, 8), st.floats(-3, 3), st.floats(0, 60), st.sampled_from([1, -1]), st.integers(160, 900))
@settings(deadline=None, max_examples=40)
def test_exact_compactons_are_found_to_round_off_wherever_they_stand(
    n: float, exponent: float, center: float, sign: int, size: int
) -> None:
    equation, grid, height = GranularCompacton(n), Grid(60, size), 10.0**exponent
    shape = equation.solitary_shape(height, sign)
    assert shape is not None
    assume(shape.width < 60)
    found = fit(shape(grid.offset(center)), grid, equation, sign, center + 0.4 * grid.spacing, 0.95 * height)
    assert found is not None
    assert found.position == pytest.approx(center, abs=1e-9)
    assert found.height == pytest.approx(height, rel=1e-9)
    assert found.residual < 1e-9


@pytest.mark.parametrize("chain", CHAINS)
@pytest.mark.parametrize("place", [30.0, 30.25, 30.5])
def test_exact_waves_of_a_chain_are_found_where_a_quartic_misses_by_a_tenth(chain: GranularChain, place: float) -> None:
    lattice, wave = Lattice(61), SolitaryWave(speed=1.2, center=place)
    height = wave.profile(chain).amplitude
    found = fit(wave.values(chain, lattice)[0], lattice, chain, 1, place + 0.2, 0.8 * height)
    assert found is not None
    assert found.position == pytest.approx(place, abs=1e-8)
    assert found.height == pytest.approx(height, rel=1e-8)
    assert found.residual < 1e-7


@pytest.mark.parametrize("equation", [GranularCompacton(2), RosenauHyman(2, 2), Nesterenko(1.5)])
def test_what_is_no_wave_has_a_residual_that_says_so(equation: Equation) -> None:
    shape = equation.solitary_shape(1.0)
    assert shape is not None
    narrow = shape(1.5 * GRID.offset(30.0))
    found = fit(narrow, GRID, equation, 1, 30.0, 1.0)
    assert found is not None
    assert found.residual > 0.1


def test_noise_is_seen_at_its_size_and_moves_the_wave_by_less() -> None:
    equation = GranularCompacton(3)
    shape = equation.solitary_shape(1.4)
    assert shape is not None
    noise = 1e-3 * np.random.default_rng(2).standard_normal(600)
    found = fit(shape(GRID.offset(20.03)) + noise, GRID, equation, 1, 20.0, 1.3)
    assert found is not None
    assert 5e-4 < found.residual < 2e-3
    assert abs(found.position - 20.03) < 1e-3
    assert abs(found.height / 1.4 - 1) < 1e-3


def test_points_of_other_waves_can_be_left_out() -> None:
    equation = GranularCompacton(2)
    waves = [Compacton(speed, center).values(equation, GRID)[0] for speed, center in ((1, 20.02), (0.25, 28.0))]
    excluded = waves[1] > 0
    found = fit(sum(waves), GRID, equation, 1, 20.0, 1.5, excluded)
    assert found is not None
    assert found.position == pytest.approx(20.02, abs=1e-9)
    assert fit(sum(waves), GRID, equation, 1, 20.0, 1.5, np.ones(600, dtype=bool)) is None


def test_an_equation_without_known_waves_fits_nothing() -> None:
    assert fit(np.ones(600), GRID, GranularCompactonWithout(2), 1, 20.0, 1.5) is None


class GranularCompactonWithout(GranularCompacton):
    def solitary_shape(self, height: float, sign: int = 1) -> None:
        return None
