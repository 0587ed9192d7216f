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
    PowerContact,
    Simulation,
    SolitaryWave,
    Symplectic,
    run,
)
from mol_compactons.analysis.collisions import family_speeds, first_collision, least_change, readings
from mol_compactons.analysis.flights import SHORTEST_FLIGHT
from mol_compactons.analysis.settling import FEWEST_FRAMES
from mol_compactons.analysis.tracking import track
from tests.analysis.painted import GRID, painted
from tests.analysis.relaxing import Relaxing
from tests.systems import one_compacton


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


def test_without_free_flight_at_the_start_nothing_is_said_of_a_collision() -> None:
    flights = [(Compacton(1, 8), 16, 2.5), (Compacton(0.25, 20), 16, -1.25)]
    tracks = track(painted(3, flights))
    tracks["isolated"][1:40] = False
    collision = first_collision(tracks)
    assert np.isnan(collision.height_before.values).all()
    assert np.isnan(collision.phase_shift.values).all()


def by_hand(positions: np.ndarray, isolated: np.ndarray, period: float = 100.0) -> xr.Dataset:
    """Tracks, shape (t, wave), of waves of height 1 and 2, one frame for each unit of time."""
    frames, waves = positions.shape
    heights = np.arange(1.0, waves + 1) * np.ones((frames, 1))
    left = np.linspace(0, 1, frames)
    return xr.Dataset(
        {
            "position": (("t", "wave"), positions, {"period": period}),
            "height": (("t", "wave"), heights),
            "width": (("t", "wave"), np.ones((frames, waves))),
            "isolated": (("t", "wave"), isolated),
            **dict.fromkeys(("mass_left", "momentum_left", "height_left"), ("t", left)),
        },
        {"t": np.arange(float(frames)), "wave": np.arange(waves)},
    )


def two_lines(shifts: tuple[float, float], frames: int = 41, blind: int = 4) -> xr.Dataset:
    """Waves of the speeds 2 and 1 that meet at t = 20, x = 40, and are not seen around then."""
    times = np.arange(float(frames))
    positions = np.array(
        [40 + speed * (times - 20) + shift * (times > 20) for speed, shift in zip((2, 1), shifts, strict=True)]
    )
    return by_hand(positions.T, np.repeat(np.abs(times - 20) > blind, 2).reshape(frames, 2))


@given(st.floats(-4, 4), st.floats(-4, 4))
@settings(max_examples=20)
def test_lines_give_the_shift_and_the_moment_to_round_off(first: float, second: float) -> None:
    collision = first_collision(two_lines((first, second)))
    assert collision.moment.values == pytest.approx([20, 20], abs=1e-10)
    assert collision.phase_shift.values == pytest.approx([first, second], abs=1e-10)
    assert collision.speed_before.values == pytest.approx([2, 1], abs=1e-10)
    assert collision.speed_after.values == pytest.approx([2, 1], abs=1e-10)
    assert collision.height_after.values == pytest.approx([1, 2], rel=1e-12)
    assert np.abs(collision.scatter.values).max() < 1e-10


def test_the_moment_is_the_meeting_that_is_nearest_on_the_ring() -> None:
    """Free flight that goes once around the period meets the other wave where the period says."""
    tracks = two_lines((1.0, -1.0))
    tracks["position"] = (("t", "wave"), tracks.position.values + np.array([300.0, -200.0]), {"period": 100.0})
    assert first_collision(tracks).moment.values == pytest.approx([20, 20], abs=1e-10)


def test_after_a_collision_the_first_half_of_the_flight_is_left_to_settle() -> None:
    tracks = two_lines((0.0, 0.0))
    tracks["height"][21:32] = 9.0
    settled = first_collision(tracks)
    assert settled.height_after.values == pytest.approx([1, 2])
    tracks["height"][36:] = 5.0
    assert (first_collision(tracks).height_after > settled.height_after).all()


def test_what_is_left_is_the_mean_over_the_settled_time() -> None:
    """The numbers rise from 0 to 1 in 40 units of time; the flight after the collision begins at 25, settles at 33."""
    left = first_collision(two_lines((0.0, 0.0)))
    for name in ("mass_left", "momentum_left", "height_left"):
        assert float(left[name]) == pytest.approx(np.arange(33, 41).mean() / 40)


def test_what_goes_on_changing_within_a_window_is_no_noise_of_what_is_left() -> None:
    """A course that does not slow down is far from its end, however little of it the windows show."""
    tracks = two_lines((0.0, 0.0))
    left = first_collision(tracks)
    rest = 2.0 * abs(float(left.window_mass_left[2]) - float(left.window_mass_left[1]))
    assert float(left.mass_left_noise) == pytest.approx(0, abs=1e-12)
    assert float(left.mass_left_settling) > rest > 0
    jitter = np.where(np.arange(tracks.sizes["t"]) % 2, 0.01, -0.01)
    tracks["mass_left"] = ("t", jitter)
    still = first_collision(tracks)
    assert 0.01 <= float(still.mass_left_noise) < 0.015
    assert float(still.mass_left_settling) < 0.05


def test_what_a_wave_has_yet_to_shed_is_left_open() -> None:
    """Half a misfit of height times support of each wave, of the square that of the misfit; nothing where all are exact."""
    tracks = two_lines((0.0, 0.0))
    exact = first_collision(tracks)
    tracks["residual"] = (("t", "wave"), np.full(tracks.height.shape, [0.1, 0.02]))
    off = first_collision(tracks)
    height, support = np.array([1.0, 2.0]), 2 * tracks.width.values[0]
    misfit = np.array([0.1, 0.02])
    for name, expected in {
        "mass_left": 0.5 * float(misfit @ (height * support)),
        "momentum_left": 0.25 * float(misfit**2 @ (height**2 * support)),
        "height_left": 0.0,
    }.items():
        assert float(off[f"{name}_reading"] - exact[f"{name}_reading"]) == pytest.approx(expected, rel=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("t_end", [26, 32, 45])
def test_what_is_left_is_open_until_the_waves_are_settled(t_end: int) -> None:
    """A collision of n = 2, whose slow wave takes in what counts as left behind until t = 90; the truths are from t = 240."""
    simulation = Simulation(
        equation=GranularCompacton(2),
        grid=Grid(length=60, size=240),
        scheme=ConservativeScheme(4, grid_viscosity=0.03, viscosity_order=6),
        initial=[Compacton(1, 8), Compacton(0.25, 20)],
        t_end=t_end,
        frames=4 * t_end + 1,
        integrator=CVODE(rtol=1e-4),
    )
    collision = first_collision(track(run(simulation), newborn=False))
    for name, truth in {"mass_left": 0.0199, "momentum_left": 0.0044}.items():
        off = abs(float(collision[name]) - truth)
        assert off > 0.1 * truth
        assert off < float(collision[f"{name}_settling"] + collision[f"{name}_reading"])


def test_scatter_is_the_largest_distance_from_the_lines() -> None:
    tracks = two_lines((0.0, 0.0))
    tracks["position"][5, 0] += 0.5
    scatter = first_collision(tracks).scatter.values
    assert 0.3 < scatter[0] < 0.5
    assert scatter[1] < 1e-10


@pytest.mark.parametrize("frames", [FEWEST_FRAMES - 1, FEWEST_FRAMES])
def test_so_many_frames_of_free_flight_are_needed_at_the_start(frames: int) -> None:
    tracks = two_lines((2.0, -1.0))
    tracks["isolated"][frames:16] = False
    known = ~np.isnan(first_collision(tracks).phase_shift.values)
    assert known.tolist() == [frames >= FEWEST_FRAMES] * 2


@pytest.mark.parametrize("frames", [SHORTEST_FLIGHT - 1, SHORTEST_FLIGHT])
def test_a_glimpse_within_a_collision_does_not_end_it(frames: int) -> None:
    tracks = two_lines((2.0, -1.0))
    tracks["isolated"][10:] = False
    tracks["isolated"][30 : 30 + frames] = True
    known = ~np.isnan(first_collision(tracks).phase_shift.values)
    assert known.tolist() == [frames >= SHORTEST_FLIGHT] * 2


def test_a_wave_that_meets_nobody_has_no_values_after() -> None:
    collision = first_collision(track(painted(3, [(Compacton(1, 8), 0, 0)])))
    assert float(collision.speed_before[0]) == pytest.approx(1, abs=1e-4)
    assert float(collision.height_before[0]) == pytest.approx(np.sqrt(2), rel=1e-5)
    for name in ("moment", "phase_shift", "speed_after", "height_after"):
        assert np.isnan(collision[name].values).all()
    assert np.isnan(collision.momentum_left)


def test_what_is_no_track() -> None:
    with pytest.raises(InputError, match=r"There are no tracks; give what track\(\) returned"):
        first_collision(painted(3, [(Compacton(1, 8), 0, 0)], t_end=1))


@pytest.mark.parametrize("n", [3 / 2, 2, 3])
def test_the_error_of_reading_holds_the_truth(n: float) -> None:
    """Exact waves on a coarse grid; it says nothing of what is read to round-off."""
    flights = [(Compacton(1, 8), 24, 2.5), (Compacton(0.25, 26, -1), 24, -1.25)]
    result = painted(n, flights, grid=Grid(length=120, size=240), t_end=80)
    heights = [wave.sign * GranularCompacton(n).compacton(wave.speed).amplitude for wave, _, _ in flights]
    collision = first_collision(track(result))
    for name, truth in {"phase_shift": [2.5, -1.25], "speed_after": [1, 0.25], "height_after": heights}.items():
        bar = collision[f"{name.removesuffix('_after')}_reading"].values
        assert (np.abs(collision[name].values - truth) <= bar + 1e-12).all()
        assert (bar < 1e-3).all()


def test_a_misfit_is_an_error_of_reading() -> None:
    """Of the height as much of it; of the shift a quarter of the support for each of the two places."""
    noises = dict.fromkeys(("phase_shift_noise", "speed_noise", "height_noise", "incoming_noise"), 0.0)
    heights = np.full(9, -2.0)
    exact, off = readings(noises, heights, np.nan, 10.0), readings(noises, heights, 0.01, 10.0)
    assert set(exact.values()) == {0.0}
    assert off == pytest.approx({"phase_shift_reading": 0.05, "speed_reading": 0.0, "height_reading": 0.02})
    noisy = readings(noises | {"phase_shift_noise": 1.0, "speed_noise": 2.0, "incoming_noise": 3.0}, heights, 0.0, 10.0)
    assert noisy == {"phase_shift_reading": 8.0, "speed_reading": 4.0, "height_reading": 0.0}
    assert readings(noises | {"incoming_noise": np.nan}, heights, 0.0, 10.0) == exact


@pytest.mark.parametrize("sign", [1, -1])
def test_a_speed_and_a_height_that_do_not_belong_together_have_to_change(sign: int) -> None:
    """By 1/10 of the speed 1/4, and so by up to 2/10 of the height; the place goes with it."""
    change = least_change(8.0, 0.25, 0.375, sign * 0.025)
    assert change == pytest.approx({"phase_shift": sign * 0.2, "speed": sign * 0.025, "height": sign * 0.075})
    assert set(least_change(8.0, 0.25, 0.375, np.nan).values()) == {0.0}
    tracks = Relaxing(t_end=120).tracks()
    tracks = tracks.assign(residual=0 * tracks.height, family_speed=tracks.speed - sign * 0.025)
    collision = first_collision(tracks)
    assert collision.speed_settling.values == pytest.approx([0.025, 0.025])
    assert collision.height_settling.values == pytest.approx([0.05 * 1.5, 0.2 * 0.375])
    assert (collision.phase_shift_settling > 1).all()


def test_the_misfit_is_that_of_the_settled_time() -> None:
    tracks = two_lines((0.0, 0.0))
    assert np.isnan(first_collision(tracks).misfit).all()
    residual = np.where(tracks.t.values > 32, 0.01, 0.5)[:, None] * [1.0, 2.0]
    residual[35, 0] = np.nan
    tracks["residual"] = (("t", "wave"), residual)
    assert first_collision(tracks).misfit.values == pytest.approx([0.01, 0.02])


def test_the_speed_of_a_height_is_that_of_the_wave() -> None:
    """Bright and dark compactons and waves of a chain, where their profile is that of one."""
    compactons = track(painted(3, [(Compacton(1, 8), 0, 0), (Compacton(0.25, 30, -1), 0, 0)], t_end=2))
    assert family_speeds(compactons) == pytest.approx(np.array([[1, 0.25]] * 161), rel=1e-3)
    compactons["residual"][3, 1] = 0.2
    assert np.argwhere(np.isnan(family_speeds(compactons))).tolist() == [[3, 1]]
    assert np.isnan(family_speeds(compactons.drop_vars("family_speed"))).all()
    chain = Simulation(
        equation=GranularChain(PowerContact(n=3 / 2)),
        grid=Lattice(60),
        scheme=NearestNeighbours(),
        initial=[SolitaryWave(speed=1.2, center=20)],
        t_end=4,
        frames=9,
        integrator=Symplectic(step=0.05),
    )
    assert family_speeds(track(run(chain))) == pytest.approx(np.full((9, 1), 1.2), rel=1e-6)


def test_a_collision_with_a_wave_that_is_much_lower_counts_for_both() -> None:
    """For n = 3/2 a wave of a quarter of the speed has a sixteenth of the height."""
    grid = Grid(120, 600)
    result = painted(1.5, [(Compacton(1, 12), 40, 2.5), (Compacton(0.25, 42), 40, -1.25)], t_end=80, grid=grid)
    collision = first_collision(track(result))
    assert collision.moment.values == pytest.approx([40, 40], abs=1e-3)
    assert collision.phase_shift.values == pytest.approx([2.5, -1.25], abs=1e-3)


def test_the_order_of_dimensions_changes_nothing() -> None:
    tracks = track(painted(3, [(Compacton(1, 8), 16, 2.5), (Compacton(0.25, 20), 16, -1.25)]))
    collision = first_collision(tracks)
    assert np.isfinite(collision.phase_shift).all()
    xr.testing.assert_identical(first_collision(tracks.transpose("wave", "t")), collision)


def test_a_wave_that_sheds_another_has_not_collided() -> None:
    """There is nothing that it could have met."""
    result = painted(3, [(Compacton(1, 10), 0, 0)], t_end=20)
    shape = GranularCompacton(3).compacton(0.32)
    shed = [shape(GRID.offset(10 + 0.32 * t)) * (t > 5) for t in result.t.values]
    tracks = track(result + xr.DataArray(shed, dims=("t", "x")).rename("W"))
    assert tracks.sizes["wave"] == 2
    assert not tracks.isolated.values[:, 0].all()
    collision = first_collision(tracks)
    assert 0.9 < float(collision.speed_before[0]) < 1.1
    assert np.isnan(collision.phase_shift).all()


def test_a_wave_that_meets_nothing_has_the_misfit_of_its_flight() -> None:
    tracks = track(run(one_compacton(size=300, t_end=3, frames=31, viscosity=1e-4)))
    outcome = first_collision(tracks)
    assert 0 < float(outcome["misfit"][0]) < 0.1
    assert float(outcome["misfit"][0]) == pytest.approx(float(tracks["residual"][:, 0].mean()), rel=0.5)
