from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from mol_compactons import (
    CVODE,
    Compacton,
    ConservativeScheme,
    Formula,
    GranularChain,
    GranularCompacton,
    Grid,
    Impact,
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
    assert np.abs(tracks.position.values[:, 0] - center - speed * tracks.t.values).max() < 1e-8
    assert np.abs(tracks.height.values / shape.amplitude - 1).max() < 1e-9
    assert np.abs(tracks.speed.values[1:-1] - speed).max() < 1e-8
    assert np.abs(tracks.family_speed.values - speed).max() < 1e-8
    assert np.abs(tracks.width.values - shape.half_width).max() < 1e-2
    assert tracks.isolated.values.all()
    assert tracks.compacton.values.all()
    assert np.abs(tracks.height_left).max() < 1e-12


def test_exact_waves_are_measured_to_round_off_on_few_points() -> None:
    """Where a quartic through five points is wrong by some thousandths."""
    for size in (60, 150):
        result = painted(2, [(Compacton(1, 10.3), 0, 0), (Compacton(0.3, 31.1, -1), 0, 0)], grid=Grid(60, size), t_end=10)
        tracks = track(result)
        assert np.abs(tracks.position.values[:, 0] - 10.3 - tracks.t.values).max() < 1e-9
        assert np.abs(tracks.height.values[0] - [1.5, -0.45]).max() < 1e-9
        assert float(tracks.residual.max()) < 1e-8


@pytest.mark.parametrize(("form", "ends"), [("stresses", "periodic"), ("stresses", "held"), ("displacements", "free")])
@pytest.mark.parametrize(("n", "speed"), [(1.5, 1), (3, -0.5)])
def test_waves_of_a_chain_have_the_heights_of_its_exact_waves(form: Any, ends: Any, n: float, speed: float) -> None:
    """1.48736 for n = 3/2 at the speed 1, wherever between the sites they stand."""
    equation = GranularChain(PowerContact(n), form=form, ends=ends)
    wave = SolitaryWave(speed, 30.3)
    lattice, scheme, integrator = Lattice(60), NearestNeighbours(), Symplectic(step=0.02)
    tracks = track(run(Simulation(equation, lattice, [wave], 12, scheme, 41, integrator)))
    assert tracks.attrs["field"] == "R"
    expected = wave.profile(GranularChain(PowerContact(n))).amplitude
    assert np.abs(tracks.height.values / expected - 1).max() < 1e-5
    assert np.abs(tracks.position.values[:, 0] - 30.3 - speed * tracks.t.values).max() < 1e-4
    assert np.abs(tracks.family_speed.values / speed - 1).max() < 1e-5
    assert float(tracks.residual.max()) < 1e-4
    assert tracks.compacton.values.all()
    assert expected == pytest.approx(1.48736, abs=1e-5) or n == 3


def of_own_data(result: xr.Dataset) -> xr.Dataset:
    """A result that names its field, and no solitary wave that it starts from."""
    result = result.assign_attrs(format=2, waves="[]")
    result.W.attrs["role"] = "field"
    return result


def two(t_end: float = 10, **changes: Any) -> xr.Dataset:
    """A bright wave and a dark one that do not meet."""
    return painted(2, [(Compacton(1, 12), 0, 0), (Compacton(0.3, 42, -1), 0, 0)], t_end=t_end, **changes)


def test_the_order_of_dimensions_and_points_changes_nothing() -> None:
    """Even of a square result; and there is something to see: both waves move."""
    result = two(grid=Grid(60, 161))
    assert result.sizes["t"] == result.sizes["x"]
    tracks = track(result)
    assert np.abs(tracks.position[-1] - [22, 45]).max() < 1e-8
    for other in (result.transpose("x", "t"), result.isel(t=slice(None, None, -1)), result.isel(x=slice(None, None, -1))):
        xr.testing.assert_allclose(track(other), tracks, rtol=0, atol=1e-9)


@pytest.mark.parametrize("step", [2, 5])
def test_every_second_frame_or_point_gives_the_same(step: int) -> None:
    result = two()
    tracks = track(result)
    for thin in (result.isel(x=slice(None, None, step)), result.isel(x=slice(1, None, step), t=slice(None, None, step))):
        thinned = track(thin)
        expected = tracks.sel(t=thinned.t)
        for name in ("position", "height", "family_speed", "isolated", "compacton"):
            assert np.abs(thinned[name].astype(float) - expected[name].astype(float)).max() < 1e-8
        assert np.abs(thinned.speed[1:-1] - [1, 0.3]).max() < 1e-8


def test_a_part_of_the_period_tells_of_the_waves_in_it() -> None:
    result = two()
    tracks, part = track(result), track(result.isel(x=slice(20, 310)))
    seen = part.position.notnull()
    assert np.abs(part.position - tracks.position).where(seen).max() < 1e-8
    assert seen.values[:100, 0].all()
    assert not seen.values[:, 1].any()
    assert part.isolated.values[:80, 0].all()
    assert part.attrs["lost"] == ""
    assert np.isnan(part.mass_left).all()


def test_a_part_of_the_time_tells_of_the_waves_in_it() -> None:
    result = two()
    late = track(result.isel(t=slice(80, None)))
    xr.testing.assert_allclose(late.position, track(result).position.isel(t=slice(80, None)))
    with pytest.raises(InputError, match="has no dimension t"):
        track(of_own_data(result).isel(t=3))


def test_points_that_lie_on_no_grid_of_the_period_are_refused() -> None:
    with pytest.raises(InputError, match="do not lie on a grid of the period 60; give every point"):
        track(two().isel(x=slice(None, None, 7)))


@pytest.mark.parametrize(("narrower", "faster", "exact"), [(1, 1, True), (1.08, 1, False), (1, 1.08, False)])
def test_profile_and_speed_make_a_compacton(narrower: float, faster: float, exact: bool) -> None:
    shape, result = GranularCompacton(2).compacton(1), painted(2, [(Compacton(1, 10), 0, 0)], t_end=20)
    result["W"].values[:] = [shape(narrower * GRID.offset(10 + faster * t)) for t in result.t.values]
    tracks = track(result)
    assert np.abs(tracks.speed[1:-1] - faster).max() < 1e-2
    assert tracks.compacton.values.all() == tracks.compacton.values.any() == exact


@pytest.mark.parametrize("known", [True, False])
def test_bright_and_dark_waves_of_the_first_frame_are_told_apart(known: bool) -> None:
    """By their signs alone where the class of the equation is not loaded, and so no speed is known."""
    result = of_own_data(two())
    if not known:
        result.attrs["simulation"] = result.attrs["simulation"].replace('"GranularCompacton"', '"elsewhere:Own"')
    tracks = track(result)
    assert tracks.position.values[0] == pytest.approx([12, 42], abs=1e-2)
    assert tracks.position.values[-1] == pytest.approx([22, 45], abs=1e-2)
    assert tracks.height.values == pytest.approx(np.array([[1.5, -0.45]] * 161), rel=1e-2)
    assert tracks.first_seen.values.tolist() == [0, 0]
    assert (tracks.attrs["lost"], tracks.attrs["doubtful"]) == ("", "")


def test_a_turned_field_turns_the_heights() -> None:
    bright, dark = (track(painted(3, [(Compacton(1, 10.03, sign), 0, 0)], t_end=10)) for sign in (1, -1))
    assert bright.height.values == pytest.approx(2**0.5, rel=1e-9)
    assert dark.height.values == pytest.approx(-bright.height.values)
    assert dark.family_speed.values == pytest.approx(bright.family_speed.values)


def test_a_pulse_breaks_up_into_compactons_with_their_births() -> None:
    """Each is known from its birth on, is a compacton in the end, and those ahead are taller."""
    pulse = Simulation(
        equation=GranularCompacton(3),
        grid=Grid(170, 600),
        scheme=ConservativeScheme(4, grid_viscosity=0.1, viscosity_order=6),
        initial=[Formula("1.5 * exp(-((x - 31) / 14)**2)")],
        t_end=52,
        frames=91,
        integrator=CVODE(rtol=1e-4),
    )
    result = run(pulse)
    tracks = track(result)
    last = tracks.isel(t=-2)
    assert tracks.sizes["wave"] == 5
    assert last.compacton.values.all()
    assert np.abs(last.speed / last.family_speed - 1).max() < 0.03
    assert (np.diff(last.height) < 0).all()
    assert (np.diff(last.position) < -10).all()
    births = tracks.first_seen.values
    assert births[0] == 0
    assert (np.diff(births) > 0).all()
    for wave, birth in enumerate(births):
        assert np.array_equal(tracks.t[tracks.position[:, wave].notnull()][0], birth)
    assert (tracks.attrs["lost"], tracks.attrs["doubtful"]) == ("", "")
    xr.testing.assert_equal(track(result, newborn=False).height[:, 0], tracks.height[:, 0])
    assert track(result, newborn=False).sizes["wave"] == 1


@pytest.mark.parametrize(("speed", "waves"), [(0.32, 2), (0, 1), (-0.1, 1), (-0.32, 2)])
def test_a_crest_that_does_not_move_as_a_wave_of_its_height_is_none(speed: float, waves: int) -> None:
    """It has the profile of the compacton of the speed 0.32; if it goes far the other way it is a wave, but no compacton."""
    result, shape = painted(3, [(Compacton(1, 10), 0, 0)], t_end=20), GranularCompacton(3).compacton(0.32)
    crest = np.array([shape(GRID.offset(40 + speed * t)) * (t > 5) for t in result.t.values])
    tracks = track(result + xr.DataArray(crest, dims=("t", "x")).rename("W"))
    assert tracks.sizes["wave"] == waves
    assert tracks.first_seen.values[1:] == pytest.approx([5.125][: waves - 1])
    assert tracks.compacton.values[50:-1, 1:].all() == (speed == 0.32 or waves == 1)


def test_waves_keep_their_names_and_belonging_speeds_through_a_collision_on_few_points() -> None:
    """Two of n = 3 on 20 points for each width."""
    width = 2 * np.pi
    waves = [Compacton(1, width), Compacton(0.5, 2.25 * width)]
    grid = Grid(6 * width, 120)
    tracks = track(run(Simulation(GranularCompacton(3), grid, waves, t_end=25, frames=81)), newborn=False)
    late = tracks.isel(t=slice(60, -1))
    assert late.isolated.values.all()
    assert (late.position[:, 0] > late.position[:, 1] + width).all()
    assert np.abs(late.height - [2**0.5, 1]).max() < 0.03
    assert np.abs(late.speed / late.family_speed - 1).max() < 0.02
    assert late.compacton.values.all()


def test_lost_waves_are_named() -> None:
    result = painted(3, [(Compacton(1, 10), 0, 0), (Compacton(0.25, 30, -1), 0, 0)], t_end=10)
    assert track(result).attrs["lost"] == ""
    result["W"][81:] = result["W"][81:].clip(min=0)
    tracks = track(result)
    assert tracks.attrs["lost"] == "Wave 1 is lost after t = 5: where it should be there is no peak of about its height."
    assert np.isnan(tracks.position[81:, 1]).all()


@pytest.mark.parametrize(("away", "lost"), [(160, "Wave 1 is lost after t = 9.9375"), (159, "")])
def test_the_last_frame_tells_whether_a_wave_is_lost(away: int, lost: str) -> None:
    result = painted(3, [(Compacton(1, 10), 0, 0), (Compacton(0.25, 30, -1), 0, 0)], t_end=10)
    result["W"][away] = result["W"][away].clip(min=0)
    tracks = track(result)
    assert tracks.attrs["lost"].partition(":")[0] == lost
    assert np.flatnonzero(np.isnan(tracks.position[:, 1])).tolist() == [away]


@pytest.mark.parametrize("apart", [-0.02, 0.02])
def test_a_wave_that_may_hide_in_the_last_frame_alone_is_not_lost(apart: float) -> None:
    """The supports, 2 pi wide, begin to overlap between the last two frames."""
    result = painted(3, [(Compacton(1, 10), 0, 0), (Compacton(0.25, 17.5 + 2 * np.pi + apart, -1), 0, 0)], t_end=10)
    result["W"][160] = result["W"][160].clip(min=0)
    tracks = track(result)
    assert tracks.isolated.values[:160].all()
    assert bool(tracks.attrs["lost"]) == (apart > 0)


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


def test_ripple_left_behind_is_counted() -> None:
    result = painted(3, [(Compacton(1, 8), 0, 0)])
    bump = 0.02 * np.exp(-((GRID.x - 55) ** 2))
    tracks = track(result.assign(W=result.W + bump))
    assert tracks.mass_left.values[:100] == pytest.approx(0.02 * np.sqrt(np.pi), rel=1e-6)
    assert tracks.momentum_left.values[:100] == pytest.approx(0.5 * 0.02**2 * np.sqrt(np.pi / 2), rel=1e-6)
    assert tracks.height_left.values[:100] == pytest.approx(0.02, rel=1e-3)


def periodic(t_end: float, frames: int) -> xr.Dataset:
    """Two crests of an exact periodic wave, a length of 2 pi apart, with the speed 1."""
    equation, wave = GranularCompacton(3), PeriodicWave(speed=1, crest=1.2)
    simulation = Simulation(equation=equation, grid=Grid(4 * np.pi, 128), initial=[wave], t_end=t_end, frames=frames)
    values = np.array([wave.values(equation, simulation.grid, t)[0] for t in simulation.times])
    return xr.Dataset(
        {"W": (("t", "x"), values)},
        {"t": simulation.times, "x": simulation.grid.coordinates},
        {"simulation": simulation.to_json()},
    )


def test_without_compactons_the_peaks_of_the_first_frame_are_followed() -> None:
    tracks = track(periodic(t_end=7, frames=29))
    assert tracks.sizes["wave"] == 2
    moved = tracks.position - tracks.position[0]
    assert np.abs(moved.values - tracks.t.values[:, None]).max() < 1e-4
    assert not tracks.compacton.values.any()
    assert tracks.attrs["doubtful"] == ""


def test_frames_in_which_one_crest_may_be_the_next_say_so() -> None:
    """Between frames each goes farther than to the place of the next."""
    doubtful = track(periodic(t_end=28, frames=3)).attrs["doubtful"]
    assert doubtful.startswith("Wave 0 may have been taken for another, and its speed be wrong: where it is in the next frame")
    assert doubtful.count("record more frames") == 2


@pytest.mark.parametrize("step", [1, 40])
def test_without_the_equation_a_peak_that_outruns_its_width_between_frames_is_doubtful(step: int) -> None:
    """Its class is not loaded here, and so nothing tells the speed but two frames."""
    result = painted(2, [(Compacton(1, 10), 0, 0)], t_end=40).isel(t=slice(None, None, step))
    foreign = result.attrs["simulation"].replace('"GranularCompacton"', '"elsewhere:Own"')
    tracks = track(of_own_data(result.assign_attrs(simulation=foreign)))
    assert bool(tracks.attrs["doubtful"]) == (step == 40)
    assert np.isnan(tracks.residual).all()
    assert step == 40 or np.abs(tracks.speed[1:-1] - 1).max() < 1e-3


@pytest.mark.parametrize("step", [8, 20, 40])
def test_own_data_are_followed_over_coarse_frames_by_the_speed_that_belongs_to_the_height(step: int) -> None:
    """A wave of the speed 1 goes 2, 5 and 10 between frames, more than a width of 9.4 and less than the box of 60."""
    tracks = track(of_own_data(painted(2, [(Compacton(1, 10), 0, 0)], t_end=40).isel(t=slice(None, None, step))))
    assert tracks.position.values[:, 0] == pytest.approx(10 + tracks.t.values)
    assert tracks.speed.values[1:-1] == pytest.approx(1)
    assert tracks.attrs["doubtful"] == ""


def test_a_chain_whose_grains_part_has_waves_in_its_stresses_alone() -> None:
    """A blow opens gaps, where Q_(k-1) - Q_k is a distance; the waves that it makes are exact ones, the first the tallest."""
    contact = PowerContact(1.5, kind="one_sided")
    equation = GranularChain(contact, form="displacements", ends="free")
    blow = Impact(velocity=1, grains=3)
    result = run(Simulation(equation, Lattice(120), [blow], 90, NearestNeighbours(), 181, Symplectic(step=0.05)))
    tracks = track(result)
    last = tracks.isel(t=-2)
    assert tracks.sizes["wave"] == 3
    assert last.compacton.values.all()
    assert np.abs(last.speed / last.family_speed - 1).max() < 1e-3
    assert (np.diff(last.height.values[np.argsort(last.position.values)]) > 0.1).all()


def test_nothing_to_follow() -> None:
    simulation = Simulation(equation=GranularCompacton(3), grid=Grid(30, 60), initial=[Uniform(1.0)], t_end=1, frames=3)
    with pytest.raises(InputError, match="There is no wave to follow"):
        track(run(simulation))


def test_what_is_no_result() -> None:
    with pytest.raises(InputError, match="There is no field to follow waves in"):
        track(xr.Dataset(attrs={"simulation": "{}"}))
