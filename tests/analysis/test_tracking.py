from __future__ import annotations

from collections.abc import Sequence

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
from mol_compactons.analysis.collisions import first_collision
from mol_compactons.analysis.peaks import peaks
from mol_compactons.analysis.tracking import track

GRID = Grid(length=60, size=600)


def painted(n: float, flights: Sequence[tuple[Compacton, float, float]], t_end: float = 40, grid: Grid = GRID) -> xr.Dataset:
    """A result made by hand: exact compactons that jump ahead by a shift at a moment, each (wave, moment, shift)."""
    equation = GranularCompacton(n)
    simulation = Simulation(equation=equation, grid=grid, initial=[wave for wave, _, _ in flights], t_end=t_end, frames=161)
    frames = np.zeros((simulation.frames, grid.size))
    for wave, moment, shift in flights:
        for index, t in enumerate(simulation.times):
            moved = Compacton(wave.speed, wave.center + (shift if t > moment else 0), wave.sign)
            frames[index] += moved.values(equation, grid, t)[0]
    return xr.Dataset({"W": (("t", "x"), frames)}, {"t": simulation.times, "x": grid.x}, {"simulation": simulation.to_json()})


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


@pytest.mark.parametrize("signs", [(1, 1), (-1, -1), (1, -1), (-1, 1)])
def test_the_shift_of_a_collision_is_measured(signs: tuple[int, int]) -> None:
    fast, slow = Compacton(1, 8, signs[0]), Compacton(0.25, 20, signs[1])
    result = painted(3, [(fast, 16, 2.5), (slow, 16, -1.25)])
    collision = first_collision(track(result))
    assert collision.moment.values == pytest.approx([16, 16], abs=1e-3)
    assert collision.phase_shift.values == pytest.approx([2.5, -1.25], abs=1e-3)
    assert collision.speed_after.values == pytest.approx([1, 0.25], abs=1e-4)
    assert collision.height_before.values == pytest.approx([signs[0] * np.sqrt(2), signs[1] * np.sqrt(0.5)], rel=1e-4)
    assert collision.height_after.values == pytest.approx(collision.height_before.values, rel=1e-4)
    assert float(collision.momentum_left) < 1e-20


def test_a_collision_across_the_end_of_the_box() -> None:
    flights = [(Compacton(1, 50), 16, 1.0), (Compacton(0.25, 62), 16, -0.5), (Compacton(0.25, 30, -1), 0, 0)]
    collision = first_collision(track(painted(3, flights, t_end=32)))
    assert collision.phase_shift.values[:2] == pytest.approx([1, -0.5], abs=1e-3)
    assert collision.moment.values[:2] == pytest.approx([16, 16], abs=1e-3)
    assert np.isnan(collision.phase_shift.values[2])


def test_ripple_left_behind_is_counted() -> None:
    result = painted(3, [(Compacton(1, 8), 0, 0)])
    bump = 0.02 * np.exp(-((GRID.x - 55) ** 2))
    tracks = track(result.assign(W=result.W + bump))
    assert tracks.mass_left.values[:100] == pytest.approx(0.02 * np.sqrt(np.pi), rel=1e-6)
    assert tracks.momentum_left.values[:100] == pytest.approx(0.5 * 0.02**2 * np.sqrt(np.pi / 2), rel=1e-6)
    assert tracks.height_left.values[:100] == pytest.approx(0.02, rel=1e-3)


def test_the_overtaking_of_the_paper() -> None:
    """The taller bright wave comes out ahead of its free flight, the lower one behind it, and they keep their names."""
    simulation = Simulation(
        equation=GranularCompacton(3),
        grid=Grid(length=60, size=600),
        scheme=ConservativeScheme(4, grid_viscosity=0.1),
        initial=[Compacton(1, 8), Compacton(0.25, 20)],
        t_end=50,
        frames=201,
        integrator=CVODE(rtol=1e-4),
    )
    tracks = track(run(simulation))
    collision = first_collision(tracks)
    fast, slow = collision.phase_shift.values
    assert fast == pytest.approx(2.65, abs=0.1)
    assert slow == pytest.approx(-4.6, abs=0.2)
    assert np.isnan(tracks.position.values).any()
    assert collision.height_after.values == pytest.approx([1.41, 0.69], abs=0.03)
    assert 0.001 < float(collision.momentum_left) < 0.03


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


def test_without_free_flight_at_the_start_nothing_is_said_of_a_collision() -> None:
    flights = [(Compacton(1, 8), 16, 2.5), (Compacton(0.25, 20), 16, -1.25)]
    tracks = track(painted(3, flights))
    tracks["isolated"][1:40] = False
    collision = first_collision(tracks)
    assert np.isnan(collision.height_before.values).all()
    assert np.isnan(collision.phase_shift.values).all()


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


def test_what_is_no_result_and_what_is_no_track() -> None:
    with pytest.raises(InputError, match="There is no field to follow waves in"):
        track(xr.Dataset(attrs={"simulation": "{}"}))
    with pytest.raises(InputError, match=r"There are no tracks; give what track\(\) returned"):
        first_collision(painted(3, [(Compacton(1, 8), 0, 0)], t_end=1))


def test_nothing_to_follow() -> None:
    simulation = Simulation(equation=GranularCompacton(3), grid=Grid(30, 60), initial=[Uniform(1.0)], t_end=1, frames=3)
    with pytest.raises(InputError, match="There is no wave to follow"):
        track(run(simulation))


def test_peaks_at_the_ends_of_the_box() -> None:
    lattice = Lattice(50)
    for center in (0.0, 49.6, 0.3):
        wave = np.exp(-(lattice.offset(center) ** 2) / 20)
        positions, heights, widths = peaks(-wave, lattice, -1, 0.1)
        assert positions % 50 == pytest.approx([center], abs=1e-3)
        assert heights == pytest.approx([1], abs=1e-3)
        assert widths == pytest.approx([2 * np.sqrt(20 * np.log(2))], rel=0.01)
