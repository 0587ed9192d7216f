from __future__ import annotations

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
    NearestNeighbours,
    PowerContact,
    Simulation,
    Symplectic,
    run,
)
from mol_compactons.results.reading import (
    arranged,
    conserved_names,
    equation_of,
    field_names,
    grid_of,
    outlines_of,
    ring_of,
    space_of,
)
from mol_compactons.results.schema import FORMAT
from tests.systems import one_compacton

POINTS = np.linspace(1, 3, 5)


def by_hand(**attributes: object) -> xr.Dataset:
    """Variables of every role; their shapes say nothing of it."""
    return xr.Dataset(
        {
            "u": (("t", "x"), np.zeros((3, 5)), {"role": "field"}),
            "u_x": (("t", "x"), np.zeros((3, 5)), {"role": "diagnostic"}),
            "mass": ("t", np.zeros(3), {"role": "conserved"}),
            "skewness": ("t", np.zeros(3), {"role": "diagnostic"}),
            "depth": ("x", np.zeros(5)),
            "count": 3,
        },
        {"t": [0.0, 1.0, 2.0], "x": POINTS},
        attributes,
    )


def test_roles_say_what_a_variable_is() -> None:
    dataset = by_hand(format=FORMAT)
    assert field_names(dataset) == ["u"]
    assert conserved_names(dataset) == ["mass"]


def test_in_the_first_format_which_has_no_roles_the_shape_says_it() -> None:
    dataset = by_hand()
    assert field_names(dataset) == ["u", "u_x"]
    assert conserved_names(dataset) == ["mass", "skewness"]


def test_a_format_from_the_future_is_refused() -> None:
    with pytest.raises(InputError, match=rf"format {FORMAT + 1}, and this version of mol_compactons reads up to {FORMAT}"):
        field_names(by_hand(format=FORMAT + 1))


@pytest.mark.parametrize("grid", [Grid(30, 60), Grid(7, 35, left=-2.5), Lattice(12)])
def test_the_grid_of_a_run_is_found_again(grid: Grid | Lattice) -> None:
    if isinstance(grid, Grid):
        equation: GranularCompacton | GranularChain = GranularCompacton(3)
        waves = [Compacton(1, 10)] if grid.length > 7 else [Compacton(1, 1)]
        simulation = Simulation(equation, grid, waves, t_end=0.1, frames=2)
    else:
        equation = GranularChain(PowerContact(3))
        simulation = Simulation(
            equation, grid, [Compacton(1, 6)], t_end=0.1, frames=2, scheme=NearestNeighbours(), integrator=Symplectic()
        )
    assert grid_of(run(simulation)) == grid


def test_the_period_is_read_and_not_guessed() -> None:
    """A result that was thinned out along x has its period still."""
    dataset = run(one_compacton())
    thin = dataset.isel(x=slice(None, None, 3))
    assert grid_of(thin) == Grid(length=30, size=50)
    del thin.x.attrs["period"]
    assert grid_of(thin).length == pytest.approx(30)
    part = dataset.isel(x=slice(10, 140))
    grid, places = ring_of(part)
    assert grid == Grid(length=30, size=150, left=2)
    assert np.array_equal(places, np.arange(130))
    with pytest.raises(InputError, match="holds 130 of the 150 points of the period 30; give it whole"):
        grid_of(part)
    with pytest.raises(InputError, match="do not lie on a grid of the period 30; give every point, or every m-th"):
        grid_of(dataset.isel(x=slice(None, None, 4)))


def test_points_across_the_seam_are_found_on_their_ring() -> None:
    dataset = run(one_compacton())
    grid, places = ring_of(dataset.isel(x=[*range(0, 20, 2), *range(130, 150, 2)]))
    assert grid == Grid(length=30, size=75)
    assert np.array_equal(places, [*range(10), *range(65, 75)])


def test_a_part_of_a_chain_keeps_the_numbers_of_its_sites() -> None:
    lattice = Lattice(40)
    chain = GranularChain(PowerContact(3))
    simulation = Simulation(chain, lattice, [Compacton(1, 16)], 0.1, NearestNeighbours(), 2, Symplectic())
    dataset = run(simulation)
    grid, places = ring_of(dataset.isel(k=slice(5, 25)))
    assert grid == lattice
    assert np.array_equal(places, np.arange(5, 25))
    assert grid_of(dataset.isel(k=slice(1, None, 2))) == Grid(length=40, size=20, left=1)


def test_arranged_puts_dimensions_and_points_in_order() -> None:
    dataset = run(one_compacton())
    for other in (
        dataset.transpose("x", "t"),
        dataset.isel(x=slice(None, None, -1), t=slice(None, None, -1)),
        dataset.roll(x=7, roll_coords=True),
    ):
        xr.testing.assert_identical(arranged(other), dataset)
    with pytest.raises(InputError, match="has no dimension t"):
        arranged(dataset.isel(t=0))


def test_the_equation_is_read_where_its_class_is_known() -> None:
    dataset = run(one_compacton())
    assert equation_of(dataset) == one_compacton().equation
    assert equation_of(dataset.assign_attrs(simulation='{"equation": {"type": "elsewhere:Own"}}')) is None
    assert equation_of(xr.Dataset()) is None
    assert space_of(dataset) == "x"


def test_without_a_coordinate_in_space_there_is_no_grid() -> None:
    with pytest.raises(InputError, match="has no coordinate x or k"):
        grid_of(xr.Dataset({"u": ("t", [1.0])}, {"t": [0.0]}))


def test_outlines_are_the_same_in_both_formats() -> None:
    """In the first format they are made from the simulation."""
    dataset = run(one_compacton())
    stored = outlines_of(dataset)
    assert [(wave.sign, wave.center, wave.speed) for wave in stored] == [(1, 10.0, 1.0)]
    assert stored[0].height == pytest.approx(np.sqrt(2))
    assert stored[0].width == pytest.approx(2 * np.pi)
    old = dataset.drop_attrs().assign_attrs(simulation=dataset.attrs["simulation"])
    assert outlines_of(old) == stored


def test_reading_a_result_needs_no_class_of_its_simulation() -> None:
    """As where the equation was one of the user's own, which is not loaded."""
    dataset = run(one_compacton())
    dataset.attrs["simulation"] = '{"type": "nowhere:Unknown"}'
    assert field_names(dataset) == ["W"]
    assert conserved_names(dataset) == ["mass", "momentum", "energy"]
    assert grid_of(dataset) == Grid(30, 150)
    assert len(outlines_of(dataset)) == 1
