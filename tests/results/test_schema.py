from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

import numpy as np
import pytest

from mol_compactons import (
    Compacton,
    CompactScheme,
    GranularChain,
    GranularCompacton,
    Grid,
    Lattice,
    NearestNeighbours,
    Nesterenko,
    PowerContact,
    RosenauHyman,
    Simulation,
    SolitaryWave,
    Uniform,
)
from mol_compactons.integrators import Counters
from mol_compactons.results import schema
from mol_compactons.results.schema import CONSERVED, DIAGNOSTIC, FIELD, WaveOutline, attributes, layout_of, outlines
from tests.systems import one_compacton


def two_way() -> Simulation:
    return Simulation(Nesterenko(n=3), Grid(30, 100, left=-5), [Compacton(1, 5)], t_end=1, frames=7, scheme=CompactScheme())


def test_a_layout_names_fields_and_numbers_with_their_roles() -> None:
    layout = layout_of(two_way(), ["mass", "energy"], ["skewness"])
    assert {name: own["role"] for name, own in layout.fields.items()} == {"S": FIELD, "v": FIELD}
    assert {name: own["role"] for name, own in layout.series.items()} == {
        "mass": CONSERVED,
        "energy": CONSERVED,
        "skewness": DIAGNOSTIC,
    }
    assert all(own["units"] == "1" for own in [*layout.fields.values(), *layout.series.values()])
    assert layout.frames == 7


def test_the_names_of_an_equation_come_before_those_of_the_program() -> None:
    layout = layout_of(two_way(), ["mass", "momentum"], ["skewness"])
    assert layout.fields["v"]["long_name"] == "velocity of the grains"
    assert layout.series["momentum"]["long_name"] == "momentum, the integral of the velocity"
    assert layout.series["mass"]["long_name"] == schema.LONG_NAMES["mass"]
    assert layout.series["skewness"]["long_name"] == "skewness"


@pytest.mark.parametrize(
    ("simulation", "space", "first", "spacing", "period"),
    [
        (two_way(), "x", -5.0, 0.3, 30.0),
        (
            Simulation(
                GranularChain(PowerContact(2)), Lattice(40), [SolitaryWave(1, 20)], t_end=1, scheme=NearestNeighbours()
            ),
            "k",
            0.0,
            1.0,
            40.0,
        ),
    ],
)
def test_the_coordinate_says_where_it_begins_and_ends(
    simulation: Simulation, space: str, first: float, spacing: float, period: float
) -> None:
    layout = layout_of(simulation, [], [])
    assert layout.space == space
    assert layout.coordinates[0] == first
    assert np.allclose(np.diff(layout.coordinates), spacing)
    assert layout.coordinate_attributes["period"] == period
    assert layout.coordinate_attributes["spacing"] == pytest.approx(spacing)


def test_outlines_are_those_of_the_exact_compactons() -> None:
    """n = 3, c = 1 and 1/4: heights sqrt(2 c), widths 2 pi; what is no solitary wave has none."""
    simulation = Simulation(
        GranularCompacton(3), Grid(60, 120), [Compacton(1, 8), Compacton(0.25, 20, -1), Uniform(0.0)], t_end=1
    )
    bright, dark = outlines(simulation)
    assert (bright.sign, bright.center, bright.speed) == (1, 8.0, 1.0)
    assert (dark.sign, dark.center, dark.speed) == (-1, 20.0, 0.25)
    assert [bright.height, dark.height] == pytest.approx([np.sqrt(2), np.sqrt(0.5)])
    assert [bright.width, dark.width] == pytest.approx([2 * np.pi, 2 * np.pi])


def test_the_attributes_hold_the_simulation_and_its_waves() -> None:
    simulation = one_compacton()
    own = attributes(simulation)
    assert Simulation.from_json(own["simulation"]) == simulation
    assert [WaveOutline(**outline) for outline in json.loads(own["waves"])] == outlines(simulation)
    assert own["format"] == schema.FORMAT
    assert own["status"] == "running"
    assert own["Conventions"] == "CF-1.11"


@pytest.mark.parametrize(
    ("equation", "first"),
    [(GranularCompacton(3), "Vladimirov"), (Nesterenko(3), "Nesterenko"), (RosenauHyman(2, 2), "Rosenau")],
)
def test_the_reference_is_that_of_the_equation_or_else_the_paper(equation: Any, first: str) -> None:
    simulation = Simulation(equation, Grid(60, 120), [Compacton(1, 20)], t_end=1, scheme=CompactScheme())
    assert attributes(simulation)["references"].startswith(first)


def test_the_source_names_the_program_and_every_library_with_its_version() -> None:
    from importlib.metadata import version

    text = schema.source()
    for name in ("mol_compactons", *schema.LIBRARIES):
        assert f"{name} {version(name)}" in text
    assert schema._version("a package that nobody has") == "of unknown version"


def test_the_cost_has_one_attribute_for_each_counter() -> None:
    counters = Counters(steps=5, evaluations=11, jacobians=2, failures=1, warnings=3, first_warning="careful")
    own = schema.cost_attributes("complete", counters, 1.23456)
    assert {f"solver_{name}": value for name, value in asdict(counters).items()}.items() <= own.items()
    assert (own["status"], own["cpu_seconds"]) == ("complete", 1.235)


def test_every_name_of_the_program_can_be_described() -> None:
    for name, words in schema.LONG_NAMES.items():
        assert schema.describe(name) == {"long_name": words, "units": "1"}
    assert len(set(schema.LONG_NAMES.values())) == len(schema.LONG_NAMES)
