from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    IDA,
    Compacton,
    CompactScheme,
    Grid,
    InputError,
    Nesterenko,
    Ripple,
    RosenauHyman,
    Simulation,
    Uniform,
    run,
)
from mol_compactons.analysis.displacements import displacements


def by_hand(stress: np.ndarray, velocity: np.ndarray, x: np.ndarray, t: np.ndarray) -> xr.Dataset:
    """A result of two fields, shape (t, x)."""
    return xr.Dataset({"S": (("t", "x"), stress), "v": (("t", "x"), velocity)}, {"t": t, "x": x})


@given(st.integers(1, 5), st.sampled_from([24, 25]), st.floats(-2, 2), st.floats(-1, 1), st.floats(0, 6))
def test_a_wave_is_integrated_exactly(periods: int, size: int, mean: float, speed: float, phase: float) -> None:
    """S = mean + cos(k x - phase) and v = speed have u = -mean (x - x0) - sin(k x - phase) / k + speed t."""
    grid, t = Grid(length=7, size=size, left=-1), np.array([0.0, 0.5, 2.0])
    wavenumber = 2 * np.pi * periods / grid.length
    wave = np.tile(wavenumber * grid.x - phase, (3, 1))
    u = displacements(by_hand(mean + np.cos(wave), np.full((3, size), speed), grid.x, t))
    exact = -mean * (grid.x + 1) - np.sin(wave) / wavenumber + speed * t[:, None]
    assert np.abs(u.values - exact).max() < 1e-12
    assert u.dims == ("t", "x")
    assert np.array_equal(u.x, grid.x)


def test_displacements_solve_the_equation_in_displacements() -> None:
    """u_x = -S, u_t = v and u_tt = -F[-u_x]_x, by differences of the frames of a smooth run."""
    equation = Nesterenko(n=2, grain_distance=0.3, prestress=1)
    grid = Grid(length=2 * np.pi, size=48)
    simulation = Simulation(
        equation=equation,
        grid=grid,
        scheme=CompactScheme("five_point", viscosity=0),
        initial=[Uniform(1), Ripple(0.05, 1)],
        t_end=0.2,
        frames=201,
        integrator=IDA(rtol=1e-6, atol=1e-13),
    )
    dataset = run(simulation)
    u = displacements(dataset).values
    step = simulation.t_end / (simulation.frames - 1)
    middle = 100
    mean = dataset.S.values[middle].mean()
    wavy = u[middle] + mean * grid.x
    slope = np.fft.irfft(1j * grid.wavenumbers * np.fft.rfft(wavy), n=48) - mean
    assert np.allclose(slope, -dataset.S.values[middle], atol=1e-12)
    assert np.allclose((u[middle + 1] - u[middle - 1]) / (2 * step), dataset.v.values[middle], atol=1e-6)
    stress = -slope
    g = stress ** ((equation.n + 1) / 2)
    g_second = np.fft.irfft(-(grid.wavenumbers**2) * np.fft.rfft(g), n=48)
    force = equation.stiffness * (stress**2 + equation.dispersion * stress**0.5 * g_second) + equation.sound_speed**2 * stress
    acceleration = (u[middle + 1] - 2 * u[middle] + u[middle - 1]) / step**2
    expected = -np.fft.irfft(1j * grid.wavenumbers * np.fft.rfft(force), n=48)
    assert np.allclose(acceleration, expected, atol=2e-4 * np.abs(expected).max())


def test_displacements_need_a_two_way_result() -> None:
    simulation = Simulation(
        equation=RosenauHyman(2, 2),
        grid=Grid(length=20, size=60),
        scheme=CompactScheme(),
        initial=[Compacton(1, 10)],
        t_end=0.1,
        frames=2,
    )
    with pytest.raises(InputError, match="need a result with S and v"):
        displacements(run(simulation))


def test_the_order_of_dimensions_and_points_changes_nothing() -> None:
    grid = Grid(length=7, size=3, left=-1)
    result = by_hand(np.random.default_rng(1).standard_normal((3, 3)), np.ones((3, 3)), grid.x, np.array([0.0, 0.5, 2.0]))
    expected = displacements(result)
    assert np.ptp(expected.values) > 1
    for other in (result.transpose("x", "t"), result.isel(x=slice(None, None, -1))):
        xr.testing.assert_identical(displacements(other), expected)
