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
from mol_compactons.studies.blocks import open_block, unstacked
from mol_compactons.studies.store import FAILED, MEMBERS, Row, file_of, plan_of, result_path, rows_of
from mol_compactons.studies.table import laid_out, table

if TYPE_CHECKING:
    import xarray as xr

Names = NDArray[np.str_]
"""The file of the member at each place of the plan, and its place in it; empty where there is none with a result."""

BETWEEN = ":"
"""What stands between the two."""

PER_CHUNK = 64
"""How many small members are read at once."""


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
    plan, rows = laid_out(plan_of(folder), rows_of(folder).values())
    whole = table(plan, rows)
    dimensions = [str(name) for name in whole["status"].dims]
    names, layouts = np.full(whole["status"].shape, "", dtype="U40"), np.full(whole["status"].shape, "", dtype="U16")
    for row in rows:
        for place in map(tuple, row["places"] if row.get("layout") else ()):
            names[place], layouts[place] = f"{file_of(row)}{BETWEEN}{row.get('place', '')}", row["layout"]
    # Others may have stopped early.
    longest = {row["layout"]: row for row in sorted((row for row in rows if row.get("layout")), key=_frames)}

    def stacked(where: Mapping[str, int]) -> xr.Dataset:
        inner = tuple(where.get(dimension, slice(None)) for dimension in dimensions)
        known = [longest[layout] for layout in set(np.ravel(layouts[inner])) if layout]
        along = [name for name in dimensions if name not in where]
        members = _members(folder, names[inner], along, max(known, key=_frames)) if known else xr.Dataset()
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


def _frames(row: Row) -> int:
    return int(row["sizes"]["t"])


def _members(folder: Path, names: Names, dimensions: Sequence[str], pattern: Row) -> xr.Dataset:
    """The variables of members that have one layout, that of a row, along the axes of the plan."""
    import xarray as xr

    try:
        import dask.array as da
    except ImportError:
        raise InputError("A sweep is opened with Dask; install it: pip install 'mol_compactons[dask]'.") from None
    one = open_member(folder, pattern["name"], pattern).drop_attrs(deep=False)
    coordinates = {name: (own.dims, own.values, own.attrs) for name, own in one.coords.items()}
    each = da.from_array(names, chunks=_chunks(names.shape, PER_CHUNK if "file" in pattern else 1))  # type: ignore[no-untyped-call]
    variables = {}
    for name, own in one.data_vars.items():
        values = each.map_blocks(
            _values,
            folder=str(folder),
            variable=str(name),
            shape=own.shape,
            dtype=float,
            chunks=(*each.chunks, *((length,) for length in own.shape)),
            new_axis=list(range(names.ndim, names.ndim + own.ndim)),
            meta=np.empty((0,) * (names.ndim + own.ndim)),
        )
        variables[name] = ([*dimensions, *own.dims], values, own.attrs)
    one.close()
    return xr.Dataset(variables, coordinates)


def _chunks(shape: Sequence[int], together: int) -> tuple[int, ...]:
    """How long the chunks are along each axis, so that some members that follow each other are in one."""
    chunks: list[int] = []
    for length in reversed(shape):
        chunks.insert(0, max(1, min(length, together)))
        together //= max(length, 1)
    return tuple(chunks)


def open_member(folder: str | Path, name: str, row: Row | None = None) -> xr.Dataset:
    """The result of a member of a sweep, as `mol_compactons.run` returns it.

    Parameters
    ----------
    folder : str or Path
        That of the sweep.
    name : str
        The name of the member, as in the table.
    row : dict, optional
        What it came to, where that is known.

    Raises
    ------
    InputError
        If it has no result, or that cannot be read.
    """
    folder = Path(folder)
    row = row or rows_of(folder).get(name, {})
    if row.get("status", FAILED) == FAILED and not result_path(folder, name).is_file():
        raise InputError(f"{folder} has no result of a member {name!r}; the variable name of its table has those that it has.")
    if "file" not in row:
        return open_result(result_path(folder, name))
    with open_block(folder / MEMBERS / file_of(row)) as block:
        return unstacked(block, row["place"])


def _values(names: Names, folder: str, variable: str, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """A variable of some members; NaN where one has none, or stopped early."""
    values = np.full((names.size, *shape), math.nan)
    files: dict[str, list[tuple[int, str]]] = {}
    for index, name in enumerate(names.flat):
        file, _, place = str(name).rpartition(BETWEEN)
        if file:
            files.setdefault(file, []).append((index, place))
    for file, members in files.items():
        path = Path(folder) / MEMBERS / file
        in_block = bool(members[0][1])
        with open_block(path) if in_block else open_result(path) as dataset:
            own = np.asarray(dataset[variable].values)
        for index, place in members:
            one = own[int(place)] if in_block else own
            values[index][tuple(slice(length) for length in one.shape)] = one
    return values.reshape(names.shape + shape)
