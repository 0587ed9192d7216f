"""Studies made by hand: members whose results are the exact wave and a deviation that is known."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import xarray as xr

from mol_compactons import CVODE, Compacton, ConservativeScheme, Family, GranularCompacton, Grid, Simulation, judge
from mol_compactons.configuration import encode
from mol_compactons.results.schema import FORMAT
from mol_compactons.studies.family import Member
from tests.analysis.relaxing import CENTERS, SPEEDS, Relaxing

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
    integrator=CVODE(rtol=1e-5),
)


def exact() -> float:
    """The L2 norm of the exact wave, on the coarsest grid of the default family."""
    grid = Grid(LENGTH, 60)
    return float(np.linalg.norm(SIMULATION.initial[0].values(SIMULATION.equation, grid, 3.0)) * np.sqrt(grid.spacing))


def spacing(member: Member) -> float:
    return member.simulation.grid.spacing


def study(
    deviation: Callable[[Member], float],
    family: Family | None = None,
    drift: float = 0.0,
    fails: Callable[[Member], bool] = lambda member: False,
    tracks: Callable[[Member], xr.Dataset] | None = None,
    simulation: Simulation = SIMULATION,
    whisper: float = 1e-9,
) -> xr.DataTree:
    """A study whose members end with the exact wave plus deviation(member) cos(2 pi x / L); `drift` is that of the mass.

    Members that fail are left out, and the others have the tracks that are given. A whisper of the tolerance, another for
    each, makes them different runs.
    """
    family = (family or Family()).completed(simulation)
    groups, failed = {}, []
    for index, member in enumerate(family.members(simulation)):
        if fails(member):
            failed.append(f"{member.label}: as a test")
            continue
        grid = member.simulation.grid
        wave = SIMULATION.initial[0].values(SIMULATION.equation, grid, 3.0)[0]
        own_deviation = deviation(member) + whisper * (1 + index) * member.tolerance
        values = wave + own_deviation * np.cos(2 * np.pi * grid.coordinates / LENGTH)
        own = xr.Dataset() if tracks is None else tracks(member)
        times = own["t"].values if tracks else np.array([0.0, 3.0])
        mass = np.linspace(1.0, 1.0 + drift, times.size)
        groups[f"/members/{index:03d}"] = xr.Dataset(
            {"W": ("x", values, {"role": "field"}), "mass": ("t", mass, {"role": "conserved"}), **own.data_vars},
            {"x": grid.coordinates, "t": times},
            {name: getattr(member, name) for name in ("label", "limit", "scheme", "viscosity", "tolerance")}
            | {"simulation": member.simulation.to_json(), "format": FORMAT},
        )
    attributes = {"family": json.dumps(encode(family)), "failed": "\n".join(failed), "title": "by hand"}
    attributes["simulation"] = simulation.to_json()
    return xr.DataTree.from_dict({"/": xr.Dataset(attrs=attributes), "/members": xr.Dataset(), **groups})


COLLISION = replace(
    SIMULATION,
    grid=Grid(length=100, size=400),
    initial=[Compacton(speed, center) for speed, center in zip(SPEEDS, CENTERS, strict=True)],
)


def collision_study(
    relaxing: Relaxing, family: Family | None = None, wrong: Callable[[Member], float] = lambda member: 0.0
) -> xr.DataTree:
    """A judged study of two waves whose slow one goes on changing; `wrong` is added to its shift by the numerical error."""

    def tracks(member: Member) -> xr.Dataset:
        fast, slow = relaxing.shifts
        return replace(relaxing, shifts=(fast, slow + wrong(member))).tracks(member.simulation.to_json())

    return judge(study(lambda member: 0.0, family, tracks=tracks, simulation=COLLISION))
