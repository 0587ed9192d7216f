"""Opening a sweep: all members as one object, of which nothing is read before it is asked for."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import InputError
from mol_compactons.results.opening import open_result
from mol_compactons.studies.store import Row, plan_of, result_path, rows_of
from mol_compactons.studies.table import table

if TYPE_CHECKING:
    import xarray as xr

Names = NDArray[np.str_]
"""The name of the member at each place of the plan; empty where there is none with a result."""


def open_sweep(folder: str | Path) -> xr.Dataset | xr.DataTree:
    """All members of a sweep, lazily, also while it runs.

    Parameters
    ----------
    folder : str or Path
        What `sweep` or ``mol-compactons sweep`` wrote.

    Returns
    -------
    xarray.Dataset or xarray.DataTree
        The table of the sweep and, along the axes of the plan and then t and space, the fields and the series of all
        members as Dask arrays; NaN for members that failed, have not run, or stopped early. Where members differ in their
        grids or times, a DataTree: the table in its root, and below it a Dataset for each value that makes the difference,
        as ``size=300``.

    Raises
    ------
    InputError
        If the folder holds no sweep, or Dask is not installed.
    """
    import xarray as xr

    folder = Path(folder)
    plan, rows = plan_of(folder), rows_of(folder)
    whole = table(plan, rows.values())
    dimensions = [str(name) for name in whole["status"].dims]
    names, layouts = np.full(whole["status"].shape, "", dtype="U16"), np.full(whole["status"].shape, "", dtype="U16")
    for row in rows.values():
        for place in map(tuple, row["places"] if row.get("layout") else ()):
            names[place], layouts[place] = row["name"], row["layout"]

    def stacked(where: Mapping[str, int]) -> xr.Dataset:
        inner = names[tuple(where.get(dimension, slice(None)) for dimension in dimensions)]
        members = _members(folder, inner, [name for name in dimensions if name not in where], rows)
        return whole.isel(where).merge(members, combine_attrs="override")

    telling = [dimensions[axis] for axis in _telling(layouts)]
    if not telling:
        return stacked({})
    places = itertools.product(*(range(whole.sizes[name]) for name in telling))
    groups = [dict(zip(telling, place, strict=True)) for place in places]
    return xr.DataTree.from_dict({"/": whole, **{_title(whole, where): stacked(where) for where in groups}})


def _title(whole: xr.Dataset, where: Mapping[str, int]) -> str:
    """The name of a group: the values that its members share."""
    return ", ".join(f"{name}={_told(whole, name, index)}" for name, index in where.items()).replace("/", "|")


def _told(whole: xr.Dataset, name: str, index: int) -> str:
    value = whole[name].values[index].item() if name in whole.coords else index
    return f"{value:.12g}" if isinstance(value, int | float) else str(value)


def _telling(layouts: Names) -> tuple[int, ...]:
    """The fewest axes whose places tell the layout of each member; none where all have one."""
    axes = range(layouts.ndim)
    for count in axes:
        for chosen in itertools.combinations(axes, count):
            first = np.moveaxis(layouts, chosen, range(count)).reshape(*(layouts.shape[axis] for axis in chosen), -1)
            if all(len(set(first[place]) - {""}) < 2 for place in np.ndindex(first.shape[:-1])):
                return chosen
    return tuple(axes)


def _members(folder: Path, names: Names, dimensions: Sequence[str], rows: Mapping[str, Row]) -> xr.Dataset:
    """The variables of members that have one layout, along the axes of the plan."""
    import xarray as xr

    try:
        import dask.array as da
    except ImportError:
        raise InputError("A sweep is opened with Dask; install it: pip install 'mol_compactons[dask]'.") from None
    known = [str(name) for name in names.flat if name]
    if not known:
        return xr.Dataset()
    # Others may have stopped early.
    longest = max(known, key=lambda name: int(rows[name]["sizes"]["t"]))
    with open_result(result_path(folder, longest)) as dataset:
        pattern = dataset.drop_attrs(deep=False)
        coordinates = {name: (one.dims, one.values, one.attrs) for name, one in pattern.coords.items()}
    each = da.from_array(names, chunks=1)  # type: ignore[no-untyped-call]
    variables = {}
    for name, one in pattern.data_vars.items():
        values = each.map_blocks(
            _values,
            folder=str(folder),
            variable=str(name),
            shape=one.shape,
            dtype=float,
            chunks=(*((1,) * length for length in names.shape), *((length,) for length in one.shape)),
            new_axis=list(range(names.ndim, names.ndim + one.ndim)),
            meta=np.empty((0,) * (names.ndim + one.ndim)),
        )
        variables[name] = ([*dimensions, *one.dims], values, one.attrs)
    return xr.Dataset(variables, coordinates)


def _values(names: Names, folder: str, variable: str, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """A variable of one member; NaN where it has none, or stopped early."""
    values = np.full(shape, math.nan)
    name = str(names.item())
    if name:
        with open_result(result_path(Path(folder), name)) as dataset:
            own = np.asarray(dataset[variable].values)
        values[tuple(slice(length) for length in own.shape)] = own
    return values.reshape((1,) * names.ndim + shape)
