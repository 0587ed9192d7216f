import re
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    Compacton,
    CompactScheme,
    ConservativeScheme,
    GaussLegendre,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    Lattice,
    Midpoint,
    NearestNeighbours,
    Nesterenko,
    PowerContact,
    Samples,
    Simulation,
    Uniform,
    run,
)
from mol_compactons.assignment import assign
from mol_compactons.cli.scenarios import listing, load
from mol_compactons.integrators import IDA
from mol_compactons.simulation import speed_of
from tests.systems import one_compacton, relative_error

simulations = st.builds(
    Simulation,
    equation=st.builds(GranularCompacton, n=st.floats(1.5, 5)),
    grid=st.builds(Grid, length=st.floats(40, 80), size=st.integers(9, 40).map(lambda size: 10 * size), left=st.floats(-5, 5)),
    scheme=st.builds(
        CompactScheme,
        second_difference=st.sampled_from(["wide", "nearest", "five_point"]),
        viscosity=st.floats(0, 1),
    ),
    initial=st.lists(st.builds(Compacton, speed=st.floats(0.1, 3), center=st.floats(-50, 50)), min_size=1, max_size=1),
    t_end=st.floats(1e-3, 1e3),
    frames=st.integers(2, 1000),
    integrator=st.builds(IDA, rtol=st.floats(1e-12, 1e-3))
    | st.builds(Midpoint, step=st.floats(1e-4, 1))
    | st.builds(GaussLegendre, step=st.floats(1e-4, 1), order=st.sampled_from([4, 6])),
    title=st.text(max_size=10),
)


@given(simulations)
def test_json_round_trip_is_exact(simulation: Simulation) -> None:
    assert Simulation.from_json(simulation.to_json()) == simulation


@pytest.mark.parametrize("text", ["{", "[]", '"x"', '{"type": "Grid"}'])
def test_json_of_something_else_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        Simulation.from_json(text)


def test_bad_times_are_named() -> None:
    with pytest.raises(InputError, match="t_end = 0 must lie between"):
        replace(one_compacton(), t_end=0)
    with pytest.raises(InputError, match="frames = 1 must lie between 2"):
        replace(one_compacton(), frames=1)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_initial_data_that_are_not_finite_are_refused(bad: float) -> None:
    with pytest.raises(InputError, match="must be finite"):
        replace(one_compacton(), initial=[Samples((bad,) * 150)])


def test_the_paper_single_compacton_with_little_viscosity() -> None:
    """N = 600, t = 14: the error is below 5e-3 once the viscosity is no more than the grid needs."""
    simulation = one_compacton(size=600, t_end=14, second_difference="nearest", viscosity=1e-5)
    final = run(simulation).W.values[-1]
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, 14)[0]
    assert relative_error(final, exact) == pytest.approx(1.43e-3, rel=0.1)


def test_the_default_scheme_is_the_best_one_for_the_granular_equation() -> None:
    """Bright and dark together at n = 2, with nothing chosen: the run ends, and loses little momentum."""
    simulation = Simulation(
        equation=GranularCompacton(n=2),
        grid=Grid(length=60, size=300),
        initial=[Compacton(speed=1, center=8), Compacton(speed=1 / 4, center=20, sign=-1)],
        t_end=20,
        frames=3,
    )
    assert simulation.scheme == ConservativeScheme(order=4, grid_viscosity=0.03, viscosity_order=6)
    dataset = run(simulation)
    assert 0.97 < float(dataset.momentum[-1] / dataset.momentum[0]) < 1
    two_way = Simulation(equation=Nesterenko(2), grid=Grid(20, 60), initial=[Compacton(1, 10)], t_end=1)
    assert isinstance(two_way.scheme, CompactScheme)
    chain = Simulation(equation=GranularChain(PowerContact(2)), grid=Lattice(30), initial=[Compacton(1, 10)], t_end=1)
    assert chain.scheme == NearestNeighbours()


def test_the_headline_is_made_from_the_settings() -> None:
    """Changed settings never stand under the numbers of the scenario that they came from."""
    simulation = load("two_bright")
    assert simulation.headline == (
        "Two bright compactons (Fig. 1b): GranularCompacton(n=3); c = 1, 0.25; "
        "CompactScheme(second_difference=wide), N = 1200, viscosity 0.001"
    )
    changed = assign(
        simulation,
        {"equation.n": "2", "grid.size": "600", "initial.1.speed": "1/8", "scheme": "ConservativeScheme(6, 0, 0.1)"},
    )
    assert changed.headline == (
        "Two bright compactons (Fig. 1b): GranularCompacton(n=2); c = 1, 0.125; "
        "ConservativeScheme(order=6), N = 600, grid viscosity 0.1"
    )
    dataset = run(replace(changed, t_end=0.1, frames=2))
    assert dataset.attrs["title"] == changed.headline


@pytest.mark.parametrize("name", sorted(listing()))
def test_no_title_of_a_scenario_repeats_a_setting(name: str) -> None:
    """A number in a title is that of a figure in the paper, or the title would be wrong after --set."""
    assert not re.search(r"\d", re.sub(r"\(Fig\. \d\w?\)", "", load(name).title))


def test_an_equation_has_one_variable_for_each_component() -> None:
    @dataclass(frozen=True)
    class Several(GranularCompacton):
        variables = ("W", "V")  # type: ignore[assignment]

    with pytest.raises(InputError, match=r"Several\.variables = \('W', 'V'\) must be 1 for an equation with two_way = False"):
        Simulation(Several(3), Grid(30, 100), [Compacton(1, 10)], t_end=1)


def test_where_not_all_of_the_data_are_waves_the_speed_is_that_of_a_wave_as_high() -> None:
    """A slow wave on a background three times as high as it: W = 3 + 1/2, and c = 2 W^2 / 4 for n = 3."""
    slow, equation, grid = Compacton(0.125, 15), GranularCompacton(3), Grid(30, 100)
    alone = Simulation(equation, grid, [slow], t_end=1)
    lifted = Simulation(equation, grid, [slow, Uniform(3)], t_end=1)
    height = float(lifted.initial_state().max())
    assert height == pytest.approx(3.5, rel=1e-2)
    ratio = lifted.scheme.viscosities[1] / alone.scheme.viscosities[1]
    assert ratio == pytest.approx(height**2 / 2 / 0.125)


@pytest.mark.parametrize(("size", "speed"), [(7, 1.0), (8, 2.0)])
def test_eight_points_tell_the_speed_of_a_wave(size: int, speed: float) -> None:
    """For n = 3, sqrt(c + A cos x) is a wave of the speed c; with fewer points none is known, and 1 is taken."""
    grid = Grid(2 * np.pi, size)
    found = speed_of(GranularCompacton(3), grid, np.sqrt(2 + 0.01 * np.cos(grid.x))[None])
    assert found == pytest.approx(speed, rel=0.2)


@pytest.mark.parametrize("times", [[], [0], [0, 2, 1, 14], [1, 14], [0, 13], [0, 0, 14]])
def test_output_times_of_ones_own_grow_from_the_beginning_to_the_end(times: list[float]) -> None:
    with pytest.raises(InputError, match="output_times must grow from 0 to t_end = 14"):
        replace(load("single_compacton"), output_times=times)
    own = replace(load("single_compacton"), output_times=[0, 1.5, 14])
    assert (own.frames, own.times.tolist()) == (3, [0, 1.5, 14])


@pytest.mark.parametrize(("n", "speed"), [(2, 0.25), (3, 2.0)])
def test_the_speed_of_a_compacton_is_told_from_its_shape(n: float, speed: float) -> None:
    grid = Grid(20, 400)
    assert speed_of(GranularCompacton(n), grid, Compacton(speed, 10).values(GranularCompacton(n), grid)) == pytest.approx(
        speed, rel=0.1
    )
