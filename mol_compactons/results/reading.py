"""What a result says of itself: its fields, what it conserves, where its points are, and the waves that it starts from.

Nothing here makes a simulation again, but for results of the format 1, which say less.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.results.schema import CONSERVED, FIELD, FORMAT, WaveOutline, outlines
from mol_compactons.simulation import Simulation

if TYPE_CHECKING:
    import xarray as xr


def _format(dataset: xr.Dataset) -> int:
    number = int(dataset.attrs.get("format", 1))
    require(
        number <= FORMAT,
        f"The result has the format {number}, and this version of mol_compactons reads up to {FORMAT}; install a newer one.",
    )
    return number


def _names(dataset: xr.Dataset, role: str, dimensions: int) -> list[str]:
    """The variables of a role; in the format 1, which has no roles, those of a number of dimensions."""
    old = _format(dataset) < 2
    return [
        str(name)
        for name, variable in dataset.data_vars.items()
        if (variable.ndim == dimensions and "t" in variable.dims if old else variable.attrs.get("role") == role)
    ]


def field_names(dataset: xr.Dataset) -> list[str]:
    """The components of the state in a result."""
    return _names(dataset, FIELD, 2)


def conserved_names(dataset: xr.Dataset) -> list[str]:
    """The conserved quantities in a result."""
    return _names(dataset, CONSERVED, 1)


def grid_of(dataset: xr.Dataset) -> Grid | Lattice:
    """Where the points of a result are.

    Raises
    ------
    InputError
        If the dataset has no dimension in space.
    """
    space = next((name for name in ("x", "k") if name in dataset.coords), None)
    if space is None:
        raise InputError("The dataset has no coordinate x or k; give a result of run().")
    points = dataset[space]
    if space == "k":
        return Lattice(size=points.size)
    first, second = (float(x) for x in points[:2])
    period = float(points.attrs.get("period", points.size * (second - first)))
    return Grid(length=period, size=points.size, left=first)


def outlines_of(dataset: xr.Dataset) -> list[WaveOutline]:
    """The solitary waves that a result starts from."""
    if _format(dataset) < 2:
        return outlines(Simulation.from_json(str(dataset.attrs["simulation"])))
    stored: list[dict[str, Any]] = json.loads(str(dataset.attrs["waves"]))
    return [WaveOutline(**outline) for outline in stored]
