"""Studies made by hand: members whose results are the exact wave and a deviation that is known."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import xarray as xr

from mol_compactons import CVODE, Compacton, ConservativeScheme, Family, GranularCompacton, Grid, Simulation
from mol_compactons.configuration import encode
from mol_compactons.results.schema import FORMAT
from mol_compactons.studies.family import Member

LENGTH = 30.0

UNIT = np.sqrt(LENGTH / 2)
"""The L2 norm of the deviation 1."""

SIMULATION = Simulation(
    equation=GranularCompacton(2),
    grid=Grid(length=LENGTH, size=240),
    scheme=ConservativeScheme(order=4),
    initial=[Compacton(speed=1, center=10)],
    t_end=3,
    frames=2,
    integrator=CVODE(rtol=1e-6),
)


def exact() -> float:
    """The L2 norm of the exact wave, on the coarsest grid of the default family."""
    grid = Grid(LENGTH, 60)
    return float(np.linalg.norm(SIMULATION.initial[0].values(SIMULATION.equation, grid, 3.0)) * np.sqrt(grid.spacing))


def spacing(member: Member) -> float:
    return member.simulation.grid.spacing


def study(deviation: Callable[[Member], float], family: Family | None = None, drift: float = 0.0) -> xr.DataTree:
    """A study whose members end with the exact wave plus deviation(member) cos(2 pi x / L); `drift` is that of the mass."""
    family = (family or Family()).completed(SIMULATION)
    groups = {}
    for index, member in enumerate(family.members(SIMULATION)):
        grid = member.simulation.grid
        wave = SIMULATION.initial[0].values(SIMULATION.equation, grid, 3.0)[0]
        values = wave + deviation(member) * np.cos(2 * np.pi * grid.coordinates / LENGTH)
        groups[f"/members/{index:03d}"] = xr.Dataset(
            {"W": ("x", values, {"role": "field"}), "mass": ("t", [1.0, 1.0 + drift], {"role": "conserved"})},
            {"x": grid.coordinates, "t": [0.0, 3.0]},
            {name: getattr(member, name) for name in ("label", "limit", "scheme", "viscosity", "tolerance")}
            | {"simulation": member.simulation.to_json(), "format": FORMAT},
        )
    attributes = {"family": json.dumps(encode(family)), "failed": "", "title": "by hand"}
    return xr.DataTree.from_dict({"/": xr.Dataset(attrs=attributes), "/members": xr.Dataset(), **groups})
