from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from mol_compactons import Compacton, GranularCompacton, Grid, InputError, Nesterenko, PeriodicWave, RosenauHyman
from mol_compactons.analysis.residuals import interior_residual, residual
from mol_compactons.equations import CosinePower, Equation, Flux
from tests.systems import fitted_order

CASES: list[tuple[Equation, float, int]] = [
    (GranularCompacton(1.5), 1, 1),
    (GranularCompacton(2), 0.7, -1),
    (GranularCompacton(2.5), 1, -1),
    (GranularCompacton(3), 1, -1),
    (GranularCompacton(4), 2, 1),
    (RosenauHyman(2, 2), 1, 1),
    (RosenauHyman(2, 2), -1, -1),
    (RosenauHyman(3, 3), 1, -1),
    (RosenauHyman(1.5, 1.5, absolute=True), 1, -1),
    (Nesterenko(1.5), -1, 1),
    (Nesterenko(3, strength=2, grain_distance=0.5), 1.3, 1),
    (Nesterenko(2, strength=2, grain_distance=0.5, prestress=3), 1.3, 1),
]


@pytest.mark.parametrize(("equation", "speed", "sign"), CASES)
def test_inside_its_support_a_compacton_solves_its_equation_to_round_off(equation: Equation, speed: float, sign: int) -> None:
    points = np.linspace(-0.97, 0.97, 41)
    balance = interior_residual(Compacton(speed, 0, sign), equation, points)
    assert np.abs(balance).max() < 2e-14 * max(1, speed**2) * abs(equation.compacton(speed, sign).amplitude)


@pytest.mark.parametrize(("equation", "speed", "sign"), CASES)
def test_across_its_edges_the_residual_falls_at_the_order_of_the_edge(equation: Equation, speed: float, sign: int) -> None:
    """With u ~ d^gamma at distance d from the edge, b g ~ d^q; the root mean square falls like h^(q - 3/2)."""
    shape = equation.compacton(speed, sign)
    sizes, errors = [128, 256, 512], []
    for size in sizes:
        grid = Grid(length=2 * shape.width, size=size, left=-shape.width)
        errors.append(float(np.sqrt(np.mean(residual(Compacton(speed, 0, sign), equation, grid) ** 2))))
    flux = equation.dispersive_flux
    assert isinstance(flux, Flux)
    order = shape.exponent * (flux.g.exponent + flux.b.exponent) - 1.5
    assert fitted_order(sizes, errors) == pytest.approx(order, abs=0.05)


@pytest.mark.parametrize("n", [1.5, 2, 2.5, 3, 4, 6])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.8])
def test_a_smooth_wave_solves_its_equation_to_round_off(n: float, share: float) -> None:
    equation = GranularCompacton(n)
    wave = PeriodicWave(speed=1, crest=1 + share * (equation.compacton(1).amplitude - 1), center=0.3)
    grid = Grid(length=wave.period(equation), size=128)
    round_off = 1e-15 * grid.wavenumbers[-1] ** 2
    assert np.abs(residual(wave, equation, grid)).max() < 10 * round_off


@dataclass(frozen=True)
class WrongHeight(GranularCompacton):
    """An equation that believes its compacton to be 10 % taller than it is."""

    def compacton(self, speed: float, sign: int = 1) -> CosinePower:
        right = GranularCompacton(self.n).compacton(speed, sign)
        return CosinePower(1.1 * right.amplitude, right.wavenumber, right.exponent)


def test_a_wrong_wave_has_a_residual() -> None:
    points = np.linspace(-0.9, 0.9, 11)
    assert np.abs(interior_residual(Compacton(1, 0), WrongHeight(3), points)).max() > 0.1
    grid = Grid(length=4 * np.pi, size=512, left=-2 * np.pi)
    assert np.abs(residual(Compacton(1, 0), WrongHeight(3), grid)).max() > 0.1


def test_points_outside_are_refused() -> None:
    with pytest.raises(InputError, match="strictly between -1 and 1"):
        interior_residual(Compacton(1, 0), GranularCompacton(3), np.array([0.0, 1.0]))
