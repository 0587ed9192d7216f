from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import IDA, CompactScheme, Grid, InputError, PowerLaw, PowerLawEquation, Samples, Simulation, run
from tests.systems import Array

GRID = Grid(length=2 * np.pi, size=48)


def second(values: Array) -> Array:
    """The second derivative on the grid, exact for what the grid resolves."""
    return np.fft.irfft(-(GRID.wavenumbers**2) * np.fft.rfft(values), n=GRID.size)


def test_a_flux_of_ones_own_runs() -> None:
    """Korteweg-de Vries, u_t + (u^2/2)_x + u_xxx = 0: its soliton 3 c sech^2(sqrt(c) z / 2) moves at c."""
    equation = PowerLawEquation(a=PowerLaw(0.5, 2), b=PowerLaw(1, 0), g=PowerLaw(1, 1, odd=True))
    grid = Grid(length=40, size=200)

    def soliton(t: float) -> np.ndarray:
        return np.asarray(3 / np.cosh(grid.offset(12 + t) / 2) ** 2)

    simulation = Simulation(
        equation=equation,
        grid=grid,
        scheme=CompactScheme("five_point", viscosity=0),
        initial=[Samples(tuple(soliton(0.0)))],
        t_end=5,
        frames=2,
        integrator=IDA(rtol=1e-5),
    )
    dataset = run(simulation)
    assert np.abs(dataset.u.values[-1] - soliton(5.0)).max() < 0.01
    assert float(abs(dataset.energy[-1] / dataset.energy[0] - 1)) < 1e-4
    two_way = PowerLawEquation(a=PowerLaw(1, 1, odd=True), b=PowerLaw(0, 0), g=PowerLaw(1, 1, odd=True), two_way=True)
    assert two_way.variables == ("u", "v")


@given(st.floats(0.1, 2), st.floats(-2, 2), st.integers(1, 5))
def test_the_energy_of_korteweg_and_de_vries(a: float, dispersion: float, periods: int) -> None:
    """F = a u^2 + d u_xx: H = -Int [a u^3 / 3 - d u_x^2 / 2], for u = 1 + cos k x: -2 pi [5 a / 6 - d k^2 / 4]."""
    equation = PowerLawEquation(PowerLaw(a, 2), PowerLaw(dispersion, 0), PowerLaw(1, 1, odd=True))
    state = 1 + np.cos(periods * GRID.x)[None]
    found = equation.invariants(state, GRID.spacing, second)
    assert found["mass"] == pytest.approx(2 * np.pi)
    assert found["energy"] == pytest.approx(-2 * np.pi * (a * 2.5 / 3 - dispersion * periods**2 / 4), rel=1e-12, abs=1e-12)
    assert set(found) == {"mass", "energy"}


def test_the_energy_of_the_wave_equation() -> None:
    """F = c^2 u, two-way: Int v^2 / 2 + c^2 u^2 / 2, for u = cos x, v = c cos x: pi c^2."""
    equation = PowerLawEquation(PowerLaw(9, 1, odd=True), PowerLaw(0, 0), PowerLaw(1, 1, odd=True), two_way=True)
    state = np.array([np.cos(GRID.x), 3 * np.cos(GRID.x) + 0.5])
    found = equation.invariants(state, GRID.spacing, second)
    assert found["momentum"] == pytest.approx(np.pi)
    assert found["energy"] == pytest.approx(9 * np.pi + np.pi / 4)


def test_without_a_variational_flux_there_is_no_energy() -> None:
    """K(2, 2) in this form: b = 1 is no multiple of (u^2)'."""
    equation = PowerLawEquation(PowerLaw(1, 2), PowerLaw(1, 0), PowerLaw(1, 2))
    assert set(equation.invariants(np.ones((1, 48)), GRID.spacing, second)) == {"mass"}


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match=r"PowerLawEquation\.b has the exponent -1; it must not be negative"):
        PowerLawEquation(PowerLaw(1, 2), PowerLaw(1, -1), PowerLaw(1, 1))
    with pytest.raises(InputError, match="no compacton of closed form"):
        PowerLawEquation(PowerLaw(1, 2), PowerLaw(1, 0), PowerLaw(1, 1)).compacton(1)
