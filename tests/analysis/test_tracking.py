from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from mol_compactons import (
    CVODE,
    Compacton,
    ConservativeScheme,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    Lattice,
    NearestNeighbours,
    PeriodicWave,
    PowerContact,
    Simulation,
    SolitaryWave,
    Symplectic,
    Uniform,
    run,
)
from mol_compactons.analysis.tracking import track
from tests.analysis.painted import GRID, painted


@given(st.floats(1.3, 4), st.floats(0.3, 2), st.floats(-50, 50), st.sampled_from([1, -1]))
@settings(max_examples=15)
def test_one_wave_is_followed_around_the_box(n: float, speed: float, center: float, sign: int) -> None:
    tracks = track(painted(n, [(Compacton(speed, center, sign), 0, 0)], t_end=60))
    shape = GranularCompacton(n).compacton(speed, sign)
    assert np.abs(tracks.position.values[:, 0] - center - speed * tracks.t.values).max() < 1e-4
    assert np.abs(tracks.height.values / shape.amplitude - 1).max() < 1e-6
    assert np.abs(tracks.speed.values[1:-1] - speed).max() < 1e-3
    half = 2 / shape.wavenumber * np.arccos(0.5 ** (1 / shape.exponent))
    assert np.abs(tracks.width.values - half).max() < 1e-2
    assert tracks.isolated.values.all()
    assert np.abs(tracks.height_left).max() < 1e-12


def test_lost_waves_are_named() -> None:
    result = painted(3, [(Compacton(1, 10), 0, 0), (Compacton(0.25, 30, -1), 0, 0)], t_end=10)
    assert track(result).attrs["lost"] == ""
    result["W"][81:] = result["W"][81:].clip(min=0)
    tracks = track(result)
    assert tracks.attrs["lost"] == "Wave 1 is lost after t = 5: where it should be there is no peak of about its height."
    assert np.isnan(tracks.position[81:, 1]).all()


def test_a_wave_in_a_collision_is_not_lost() -> None:
    result = run(
        Simulation(
            equation=GranularCompacton(3),
            grid=Grid(60, 600),
            scheme=ConservativeScheme(4, grid_viscosity=0.03, viscosity_order=6),
            initial=[Compacton(1, 5.5), Compacton(0.25, 15.5)],
            t_end=8,
            frames=81,
            integrator=CVODE(rtol=1e-5),
        )
    )
    tracks = track(result)
    assert np.isnan(tracks.position[-1]).any()
    assert tracks.attrs["lost"] == ""


def test_positions_are_of_a_high_order() -> None:
    errors = []
    for size in (150, 300):
        tracks = track(painted(2, [(Compacton(1, 10.3), 0, 0)], grid=Grid(60, size)))
        errors.append(np.abs(tracks.position.values[:, 0] - 10.3 - tracks.t.values).max())
    assert errors[1] < errors[0] / 12


def test_ripple_left_behind_is_counted() -> None:
    result = painted(3, [(Compacton(1, 8), 0, 0)])
    bump = 0.02 * np.exp(-((GRID.x - 55) ** 2))
    tracks = track(result.assign(W=result.W + bump))
    assert tracks.mass_left.values[:100] == pytest.approx(0.02 * np.sqrt(np.pi), rel=1e-6)
    assert tracks.momentum_left.values[:100] == pytest.approx(0.5 * 0.02**2 * np.sqrt(np.pi / 2), rel=1e-6)
    assert tracks.height_left.values[:100] == pytest.approx(0.02, rel=1e-3)


def test_without_compactons_the_peaks_of_the_first_frame_are_followed() -> None:
    equation, wave = GranularCompacton(3), PeriodicWave(speed=1, crest=1.2)
    simulation = Simulation(equation=equation, grid=Grid(4 * np.pi, 128), initial=[wave], t_end=7, frames=29)
    frames = np.array([wave.values(equation, simulation.grid, t)[0] for t in simulation.times])
    result = xr.Dataset(
        {"W": (("t", "x"), frames)},
        {"t": simulation.times, "x": simulation.grid.coordinates},
        {"simulation": simulation.to_json()},
    )
    tracks = track(result)
    assert tracks.sizes["wave"] == 2
    moved = tracks.position - tracks.position[0]
    assert np.abs(moved.values - tracks.t.values[:, None]).max() < 1e-4


def test_displacements_are_not_followed() -> None:
    chain = Simulation(
        equation=GranularChain(PowerContact(1.5), form="displacements", ends="free"),
        grid=Lattice(60),
        scheme=NearestNeighbours(),
        initial=[SolitaryWave(1, 20)],
        t_end=1,
        frames=3,
        integrator=Symplectic(),
    )
    with pytest.raises(InputError, match="followed in stresses, not in displacements"):
        track(run(chain))


def test_nothing_to_follow() -> None:
    simulation = Simulation(equation=GranularCompacton(3), grid=Grid(30, 60), initial=[Uniform(1.0)], t_end=1, frames=3)
    with pytest.raises(InputError, match="There is no wave to follow"):
        track(run(simulation))


def test_what_is_no_result() -> None:
    with pytest.raises(InputError, match="There is no field to follow waves in"):
        track(xr.Dataset(attrs={"simulation": "{}"}))
