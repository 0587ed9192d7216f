"""What a result says of itself: its fields, what it conserves, where its points are, and the waves that it starts from.

Nothing here makes a simulation again, but for results of the format 1, which say less.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import decode
from mol_compactons.equations.base import Equation
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.results.schema import CONSERVED, FIELD, FORMAT, SERIES, SERIES_TIME, WaveOutline, outlines
from mol_compactons.simulation import Simulation

if TYPE_CHECKING:
    import xarray as xr


ROUGHNESS = 1e-6
"""How far points may be from their places, relative to their distance."""


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


def conserved_along_t(dataset: xr.Dataset) -> xr.Dataset:
    """The conserved quantities along t, as often as they were recorded between the first and the last frame, in memory."""
    names = conserved_names(dataset)
    often = [f"{name}_{SERIES}" for name in names]
    if SERIES_TIME not in dataset.coords or not dataset.sizes["t"] or not set(often) <= set(dataset.data_vars):
        return dataset[[*names, "t"]].load().sortby("t")
    series, ends = dataset[often].load(), (dataset["t"].min(), dataset["t"].max())
    series = series.isel({SERIES_TIME: ((series[SERIES_TIME] >= ends[0]) & (series[SERIES_TIME] <= ends[1])).values})
    return series.rename({SERIES_TIME: "t"} | dict(zip(often, names, strict=True)))


def space_of(dataset: xr.Dataset) -> str:
    """The dimension in space of a result, x or k.

    Raises
    ------
    InputError
        If the dataset has none.
    """
    space = next((name for name in ("x", "k") if name in dataset.coords and name in dataset.dims), None)
    if space is None:
        raise InputError("The dataset has no coordinate x or k; give a result of run().")
    return space


def arranged(dataset: xr.Dataset) -> xr.Dataset:
    """The result with its dimensions in the order (t, x) or (t, k), and both coordinates growing.

    Whatever reads arrays of a result begins here, so that a transposed, reversed or rolled result is the same to it.

    Raises
    ------
    InputError
        If the dataset has no dimension in time or in space.
    """
    space = space_of(dataset)
    require(
        "t" in dataset.dims,
        "The dataset has no dimension t; give a result of run(), or keep the dimension: dataset.isel(t=[0]).",
    )
    for name in ("t", space):
        if (np.diff(dataset[name].values) < 0).any():
            dataset = dataset.sortby(name)
    return dataset.transpose("t", space, ...)


def grid_of(dataset: xr.Dataset) -> Grid | Lattice:
    """Where the points of a result are, which may be every second or third of those of the run.

    Raises
    ------
    InputError
        If the dataset has no dimension in space, or its points are not equally spaced over the whole period.
    """
    grid, places = ring_of(dataset)
    require(
        places.size == grid.size,
        f"The result holds {places.size} of the {grid.size} points of the period {grid.length:.6g}; give it whole.",
    )
    return grid


def ring_of(dataset: xr.Dataset) -> tuple[Grid | Lattice, NDArray[np.intp]]:
    """The grid of the whole period of which a result may hold a part, and the numbers of the points that it holds.

    Raises
    ------
    InputError
        If the dataset has no dimension in space, or its points do not lie on an equally spaced grid of its period.
    """
    space = space_of(dataset)
    points = np.sort(dataset[space].values.astype(float))
    period = _period(dataset, space)
    require(points.size >= 3, f"The result has {points.size} points along {space}; at least 3 are needed.")
    spacing = float(np.diff(points).min())
    size = points.size if period is None else round(period / spacing) if spacing > 0 else 0
    length = points.size * (points[-1] - points[0]) / (points.size - 1) if period is None else period
    steps = (points - points[0]) * size / length
    places = np.rint(steps).astype(np.intp)
    require(
        spacing * size >= length * (1 - ROUGHNESS)
        and bool(np.abs(steps - places).max() <= ROUGHNESS * points.size)
        and int(places[-1]) < size,
        f"The {points.size} points of {space} from {points[0]:.6g} to {points[-1]:.6g} do not lie on a grid of the period "
        f"{length:.6g}; give every point, or every m-th where m divides their number.",
    )
    if space == "k" and round(length) == size and points[0] >= 0 and points[-1] < size:
        return Lattice(size=size), places + round(points[0])
    return Grid(length=length, size=size, left=float(points[0])), places


def _period(dataset: xr.Dataset, space: str) -> float | None:
    """The period of the run; None where the result does not know it."""
    if "period" in dataset[space].attrs:
        return float(dataset[space].attrs["period"])
    grid = json.loads(str(dataset.attrs.get("simulation") or "{}")).get("grid", {})
    number = grid.get("length", grid.get("size"))
    return None if number is None else float(number)


def equation_of(dataset: xr.Dataset) -> Equation | None:
    """The equation of a result; None where its class is not loaded."""
    try:
        equation = decode(Equation, json.loads(str(dataset.attrs["simulation"]))["equation"])
    except (InputError, KeyError):
        return None
    return equation if isinstance(equation, Equation) else None


def outlines_of(dataset: xr.Dataset) -> list[WaveOutline]:
    """The solitary waves that a result starts from."""
    if _format(dataset) < 2:
        return outlines(Simulation.from_json(str(dataset.attrs["simulation"])))
    stored: list[dict[str, Any]] = json.loads(str(dataset.attrs["waves"]))
    return [WaveOutline(**outline) for outline in stored]
