from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mol_compactons import (
    Compacton,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    Lattice,
    Nesterenko,
    PeriodicWave,
    PowerContact,
    Simulation,
    SolitaryWave,
    run,
)
from mol_compactons.analysis.fitting import Fit, fit
from mol_compactons.analysis.sighting import RECOGNISED, Frames, Sighting, frames_of, nearest_step
from mol_compactons.analysis.tracking import LARGEST_MISFIT, track
from mol_compactons.configuration import encode
from mol_compactons.equations.base import Equation
from tests.analysis.painted import GRID, painted


def still(equation: Equation, state: Any, grid: Grid | Lattice = GRID) -> Frames:
    """One frame of a state."""
    states = np.asarray(state)[None]
    hidden = np.zeros(grid.size, dtype=bool)
    return Frames("u", np.zeros(1), states, grid, equation, isinstance(equation, GranularChain), hidden)


def only(sightings: list[Sighting]) -> Sighting:
    (sighting,) = sightings
    return sighting


def test_an_exact_wave_is_measured_by_its_fit() -> None:
    equation = GranularCompacton(2)
    seen = only(still(equation, Compacton(0.7, 20.03, -1).values(equation, GRID)).look(0, 0.1))
    assert (seen.sign, seen.recognised) == (-1, True)
    assert [seen.position, seen.height, seen.family_speed] == pytest.approx([20.03, 1.05, 0.7], abs=1e-9)
    assert seen.support == pytest.approx(equation.compacton(0.7).width)
    assert seen.width == pytest.approx(equation.compacton(0.7).half_width, abs=0.01)
    assert seen.speed == seen.family_speed


def test_another_peak_is_measured_as_it_is_and_its_motion_is_that_of_its_flux() -> None:
    """Of the periodic wave F = c u + const; it is no compacton, though the speed of one belongs to its height."""
    equation, grid = GranularCompacton(3), Grid(2 * np.pi, 64)
    seen = only(still(equation, PeriodicWave(speed=1, crest=1.2).values(equation, grid), grid).look(0, 0.1))
    assert seen.residual > 0.2
    assert not seen.recognised
    assert seen.height == pytest.approx(1.2, abs=1e-5)
    assert seen.motion == pytest.approx(1, abs=0.01)
    assert seen.speed == seen.motion
    assert seen.family_speed == pytest.approx(0.72, abs=1e-5)


@pytest.mark.parametrize("direction", [1, -1])
def test_waves_that_go_both_ways_have_a_speed_with_a_sign(direction: int) -> None:
    two_way = Nesterenko(3)
    seen = only(still(two_way, Compacton(0.8 * direction, 20).values(two_way, GRID)).look(0, 0.1))
    assert [seen.motion, seen.family_speed] == pytest.approx([0.8 * direction, 0.8 * direction], abs=0.01)
    chain, lattice = GranularChain(PowerContact(1.5)), Lattice(60)
    seen = only(still(chain, SolitaryWave(0.8 * direction, 30.2).values(chain, lattice), lattice).look(0, 0.1))
    assert seen.family_speed == pytest.approx(0.8 * direction, abs=1e-7)
    assert np.sign(seen.motion or 0.0) == direction


def test_points_of_a_neighbour_are_left_out() -> None:
    equation = GranularCompacton(2)
    waves = [Compacton(speed, place).values(equation, GRID)[0] for speed, place in ((1, 20), (0.9, 26))]
    for seen, place, speed in zip(still(equation, [sum(waves)]).look(0, 0.1), (20, 26), (1, 0.9), strict=True):
        assert seen.position == pytest.approx(place, abs=0.01)
        assert seen.family_speed == pytest.approx(speed, abs=0.01)
        assert seen.residual < 0.01


def test_of_an_equation_without_known_waves_the_peaks_are_seen() -> None:
    frames = replace(still(GranularCompacton(2), Compacton(1, 20).values(GranularCompacton(2), GRID)), equation=None)
    seen = only(frames.look(0, 0.1))
    assert np.isnan([seen.residual, seen.family_speed]).all()
    assert (seen.motion, seen.speed) == (None, None)
    assert seen.position == pytest.approx(20, abs=1e-6)


def test_what_is_taken_for_a_compacton_is_one() -> None:
    """The bounds: compactons in runs on 12 points for each width are within, Gaussians and other compactons are not."""
    for n, least in ((1.5, 0.025), (2.0, LARGEST_MISFIT), (3.0, LARGEST_MISFIT)):
        equation = GranularCompacton(n)
        width = equation.compacton(1).width
        simulation = Simulation(equation, Grid(4 * width, 48), [Compacton(1, width)], t_end=width, frames=21)
        tracks = track(run(simulation)).isel(t=slice(5, -1))
        assert float(tracks.residual.max()) < 0.6 * LARGEST_MISFIT
        assert np.abs(tracks.speed / tracks.family_speed - 1).max() < 0.02
        assert tracks.compacton.values.all()
        shape, grid = equation.compacton(1), Grid(4 * width, 160)
        z = grid.offset(2 * width)

        def misfit(values: np.ndarray, n: float = n, grid: Grid = grid) -> float:
            found: Fit | None = fit(values, grid, GranularCompacton(n), 1, grid.length / 2, float(values.max()))
            return np.inf if found is None else found.residual

        noise = 0.01 * shape.amplitude * np.random.default_rng(3).standard_normal(160)
        assert misfit(shape(z)) < 1e-9
        assert 0.005 < misfit(shape(z) + noise) < LARGEST_MISFIT
        assert min(misfit(np.exp(-((z / (part * width)) ** 2))) for part in np.linspace(0.15, 0.5, 36)) > least
        assert min(misfit(GranularCompacton(other).compacton(1)(z)) for other in {1.3, 1.5, 2, 3} - {n}) > RECOGNISED
        assert misfit(shape(1.03 * z)) < LARGEST_MISFIT < RECOGNISED < misfit(shape(1.08 * z))


def of_a_chain(equation: GranularChain, field: list[float]) -> xr.Dataset:
    """A result of one frame, whose second component is twice the first."""
    first, second = equation.variables
    values = np.array([field])
    settings = {"equation": encode(equation), "grid": {"size": len(field)}}
    return xr.Dataset(
        {first: (("t", "k"), values), second: (("t", "k"), 2 * values)},
        {"t": [0.0], "k": np.arange(len(field))},
        {"simulation": json.dumps(settings)},
    )


@pytest.mark.parametrize(
    ("ends", "stress"),
    [("periodic", [2, 0.5, -1.5, -1]), ("free", [0, 0.5, -1.5, -1]), ("fixed", [-1, 0.5, -1.5, -1, 3])],
)
def test_of_displacements_the_stresses_are_followed(ends: Any, stress: list[float]) -> None:
    """R_k = Q_(k-1) - Q_k, with the other end before the first, or nothing, or walls; beyond the ends the sites are empty."""
    result = of_a_chain(GranularChain(PowerContact(3), form="displacements", ends=ends), [1, 0.5, 2, 3])
    frames = frames_of(result)
    empty = [0.0] * (0 if ends == "periodic" else len(stress))
    assert frames.name == "R"
    assert frames.states[0].tolist() == [stress + empty, [2 * one for one in stress] + empty]
    assert frames.grid == Lattice(len(stress + empty))
    with pytest.raises(InputError, match="give all grains of the chain"):
        frames_of(result.isel(k=slice(0, 3)))


def test_heavy_grains_are_slower_by_their_masses() -> None:
    chain = GranularChain(PowerContact(3), form="displacements", ends="free", masses=(1.0, 2.0, 4.0, 8.0))
    assert frames_of(of_a_chain(chain, [1, 0.5, 2, 3])).states[0, 1, :4].tolist() == [0, 2 - 0.5, 0.5 - 1, 1 - 0.75]


@pytest.mark.parametrize(("law", "lowest"), [(PowerContact(1.5, kind="one_sided"), 0), (PowerContact(1.5), -5)])
def test_where_grains_have_parted_there_is_no_stress(law: PowerContact, lowest: float) -> None:
    """In a one-sided law; in an odd one tension is a stress."""
    states = frames_of(of_a_chain(GranularChain(law), [0, 1, 0, -5, 0])).states
    assert states.min(axis=2).tolist() == [[lowest, 2 * lowest]]
    assert states.max(axis=2).tolist() == [[1, 2]]


def test_points_that_are_not_there_are_hidden_and_linear() -> None:
    result = painted(2, [(Compacton(1, 10), 0, 0)], t_end=1)
    result["W"] = result.W + 2 + result.x / 60
    frames = frames_of(result.isel(x=[*range(100), *range(400, 600)]))
    assert frames.grid == GRID
    assert np.array_equal(np.flatnonzero(frames.hidden), np.arange(100, 400))
    between = frames.states[0, 0, 99:401]
    assert np.abs(np.diff(between, 2)).max() < 1e-12
    assert between[[0, -1]] == pytest.approx(result.W.values[0, [99, 400]])
    assert not frames.sees(10, 1)
    assert frames.sees(8, 1)


def test_what_has_no_frames_or_no_numbers_is_refused() -> None:
    result = painted(2, [(Compacton(1, 10), 0, 0)], t_end=10)
    with pytest.raises(InputError, match="holds no frame"):
        frames_of(result.isel(t=slice(0, 0)))
    result.W[16, 3] = np.inf
    with pytest.raises(InputError, match="values that are no numbers, first at t = 1; select the times before"):
        frames_of(result)


def test_the_nearest_of_some_places_on_a_ring() -> None:
    assert nearest_step(9.5, np.array([3.0, 0.5, 8.0]), 10) == pytest.approx(1)
    assert nearest_step(9.5, np.array([]), 10) == 0
