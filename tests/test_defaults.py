"""Nothing but equation, grid and waves is said: the run ends, its waves have met, and they are what they were."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mol_compactons import (
    Compacton,
    ConservativeScheme,
    CustomEquation,
    Equation,
    Formula,
    GranularChain,
    GranularCompacton,
    Grid,
    Lattice,
    Nesterenko,
    PowerContact,
    RosenauHyman,
    Simulation,
    SolitaryWave,
    run,
    track,
)

MEETINGS = 3
"""A run lasts until the faster wave could have met the slower one so many times on a straight line."""

EQUATIONS: list[tuple[Any, float]] = [
    (GranularCompacton(1.5), 40),
    (GranularCompacton(2), 20),
    (GranularCompacton(3), 20),
    (RosenauHyman(2, 2), 40),
    (RosenauHyman(3, 3), 20),
    (RosenauHyman(2, 2, absolute=True), 20),
]
"""Each with a number of points for each width of a compacton."""


def pair(equation: Equation, points: float, scale: float = 1.0) -> Simulation:
    """The wave of speed 1 behind that of speed 1/2, in a box of six widths; all speeds times a scale."""
    width = equation.compacton(scale).width
    waves = [Compacton(scale, width), Compacton(scale / 2, 2.25 * width)]
    t_end = MEETINGS * 1.25 * width / (scale / 2)
    return Simulation(equation, Grid(6 * width, round(6 * points)), waves, t_end=t_end, frames=151)


@pytest.mark.parametrize(("equation", "points"), EQUATIONS)
def test_two_compactons_to_three_collision_times(equation: Equation, points: float) -> None:
    simulation, width = pair(equation, points), equation.compacton(1).width
    dataset = run(simulation)
    assert dataset.attrs["status"] == "complete"
    field = dataset[equation.variables[0]]
    early = field.isel(t=5)
    assert float(early.x[int(np.argmax(early.values))]) == pytest.approx(
        width + float(early.t), abs=2 * simulation.grid.spacing
    )
    height = np.sort(track(dataset, newborn=False).height.values)
    assert np.abs(height[-1] / height[0] - 1).max() < 0.05
    assert float(np.abs(dataset.mass / dataset.mass[0] - 1).max()) < 1e-11


@pytest.mark.parametrize("scale", [1e-2, 1e2])
def test_the_default_follows_the_scale_of_the_speeds(scale: float) -> None:
    """W -> r W, t -> r^(1-n) t: viscosity is in proportion to the speed, and so the run is the same."""
    equation = RosenauHyman(2, 2)
    one, other = pair(equation, 20), pair(equation, 20, scale)
    assert isinstance(one.scheme, ConservativeScheme)
    assert isinstance(other.scheme, ConservativeScheme)
    assert other.scheme.grid_viscosity == pytest.approx(scale * one.scheme.grid_viscosity, rel=1e-12)
    tracks = [track(run(simulation), newborn=False) for simulation in (one, other)]
    heights = [followed.height[-1] / followed.height[0] for followed in tracks]
    assert np.abs(heights[0] - heights[1]).max() < 2e-3


def test_the_classical_collision_of_two() -> None:
    """K(2, 2) on 1,000 points, which blows up at t = 11.4 with a viscosity that does not know of its ripples."""
    waves = [Compacton(2, 10), Compacton(1, 30)]
    simulation = Simulation(equation=RosenauHyman(2, 2), grid=Grid(100, 1000), initial=waves, t_end=40)
    dataset = run(simulation)
    assert dataset.attrs["status"] == "complete"
    tracks = track(dataset, newborn=False)
    assert float(tracks.position[-1, 0]) > float(tracks.position[-1, 1]) + 8
    assert np.abs(tracks.height[-1] / tracks.height[0] - 1).max() < 0.01


def test_the_classical_collision_of_three() -> None:
    waves = [Compacton(3, 10), Compacton(2, 25), Compacton(1, 40)]
    dataset = run(Simulation(equation=RosenauHyman(2, 2), grid=Grid(110, 550), initial=waves, t_end=40, frames=201))
    assert dataset.attrs["status"] == "complete"
    heights = track(dataset, newborn=False).height
    assert np.abs(heights.dropna("t")[-1] / heights[0] - 1).max() < 0.06


def test_a_bright_and_a_dark_wave() -> None:
    equation = GranularCompacton(2)
    waves = [Compacton(1, 10), Compacton(1 / 4, 24, sign=-1)]
    dataset = run(Simulation(equation, Grid(60, 300), waves, t_end=56, frames=57))
    assert dataset.attrs["status"] == "complete"
    assert 0.93 < float(dataset.momentum[-1] / dataset.momentum[0]) < 1


@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_two_waves_of_the_chain(n: float) -> None:
    """Exact solitary waves, of which one overtakes the other, by the default integrator."""
    waves = [SolitaryWave(1, 15), SolitaryWave(0.5, 32)]
    simulation = Simulation(GranularChain(PowerContact(n)), Lattice(120), waves, t_end=3 * 17 / 0.5, frames=205)
    dataset = run(simulation)
    assert dataset.attrs["status"] == "complete"
    assert abs(float(dataset.energy[-1] / dataset.energy[0]) - 1) < 0.01
    assert int(np.argmax(dataset.R.values[-1])) == pytest.approx((15 + 102) % 120, abs=4)


def test_nesterenko_until_its_short_waves_have_grown() -> None:
    """Every state of it grows, the faster the finer the grid; on one point for each site it holds long enough to move."""
    equation = Nesterenko(1.5)
    width = equation.compacton(1).width
    waves = [Compacton(1, 10), Compacton(0.5, 10 + 1.5 * width)]
    dataset = run(Simulation(equation, Grid(60, 60), waves, t_end=20, frames=21))
    assert dataset.attrs["status"] == "complete"
    assert int(np.argmax(dataset.S.values[-1])) == pytest.approx(30, abs=2)


def test_a_formula_of_k22_has_the_same_care() -> None:
    """The flux is not odd, which the default of the central scheme notices."""
    equation = CustomEquation("u**2 + d2(u**2)")
    hump = "{c}*4/3*cos((x - {x})/4)**2*heaviside(2*pi - abs(x - {x}))"
    waves = [Formula(hump.format(c=2, x=10)), Formula(hump.format(c=1, x=30))]
    dataset = run(Simulation(equation, Grid(100, 500), waves, t_end=30, frames=61))
    assert dataset.attrs["status"] == "complete"
    assert float(dataset.u[-1].max()) == pytest.approx(8 / 3, rel=0.02)
