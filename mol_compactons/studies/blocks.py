"""Many small members in one file: a block, so that the file system is not the limit of a study."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mol_compactons.analysis.drift import scale_of
from mol_compactons.configuration import decode, hints_of
from mol_compactons.errors import InputError
from mol_compactons.results.places import written_whole
from mol_compactons.results.recorder import MemoryRecorder
from mol_compactons.results.schema import CONSERVED, describe
from mol_compactons.running import recorded
from mol_compactons.runtime.netcdf import open_netcdf
from mol_compactons.simulation import Simulation
from mol_compactons.studies import modules
from mol_compactons.studies.members import FAILED, Task, asked_of, attempted, carry_out, costs_of, layout_digest
from mol_compactons.studies.plan import digest
from mol_compactons.studies.store import Row

if TYPE_CHECKING:
    import xarray as xr

MANY = 1000
"""From more members than this on, members share files unless told otherwise."""

PER_FILE = 100
"""How many share one."""

MOST_BYTES = 2**25
"""About how large the fields of a block may be."""

MEMBER = "member"
"""The dimension along which a block has its members."""

MAGNITUDE = "magnitude"
"""The attribute of a conserved quantity that differs from member to member."""

ATTRIBUTES = "attributes"
"""The variable that holds, for each member, the attributes of its result as JSON."""


@dataclass(frozen=True)
class Block:
    """Members that go into one file; their grids, times and variables are the same.

    Parameters
    ----------
    tasks : tuple of Task
        The members.
    path : str
        The file.
    """

    tasks: tuple[Task, ...]
    path: str


def units_of(tasks: Sequence[Task], per_file: int, folder: Path) -> Iterator[Task | Block]:
    """What an engine is given: members in blocks, or by themselves where they are large."""
    if per_file == 1:
        yield from tasks
        return
    alike = defaultdict(list)
    for task in tasks:
        tree = task.tree
        frames = [tree.get(name) for name in ("t_end", "frames", "output_times", "series_per_frame")]
        alike[json.dumps([tree["equation"], tree["grid"], frames])].append(task)
    for group in alike.values():
        tree = group[0].tree
        few = tree.get("series_per_frame", 1) != 1  # what is recorded more often has no place in a block
        count = 1 if few else min(per_file, max(1, MOST_BYTES // _bytes_of(tree)))
        for first in range(0, len(group), count):
            own = tuple(group[first : first + count])
            name = digest([task.name for task in own])
            yield Block(own, str((folder / f"block_{name}.nc").resolve())) if len(own) > 1 else own[0]


def _bytes_of(tree: dict[str, Any]) -> int:
    """About how long the result of a simulation is; what cannot be told fails when it is run."""
    try:
        return max(1, 8 * int(tree["grid"]["size"]) * int(tree.get("frames") or 1))
    except (TypeError, ValueError, KeyError, OverflowError):
        return 1


def carry_out_all(unit: Task | Block) -> list[Row]:
    """Run one member, or those of a block, and say what they came to."""
    return carry_out_block(unit) if isinstance(unit, Block) else [carry_out(unit)]


def carry_out_block(block: Block) -> list[Row]:
    """Run the members of a block, write those that ran to their end into its file, and say what they came to."""
    kept: list[MemoryRecorder] = []

    def result(task: Task) -> Row:
        modules.load(task.modules)
        recorder = recorded(_decoded(task.tree))
        own = _measured(recorder, task)
        kept.append(recorder)
        return own | {"file": Path(block.path).name, "place": len(kept) - 1}

    rows = [attempted(task, lambda task=task: result(task)) for task in block.tasks]  # type: ignore[misc]
    if kept:
        try:
            with written_whole(Path(block.path)) as part:
                stacked(kept, [row["name"] for row in rows if row["status"] != FAILED]).to_netcdf(part, engine="scipy")
        except InputError as error:
            return [
                task.row(FAILED, str(error)) | {"seconds": row["seconds"]} for task, row in zip(block.tasks, rows, strict=True)
            ]
    return rows


def _decoded(tree: dict[str, Any]) -> Simulation:
    """A simulation from JSON-ready data, whose parts are made once where many members share them."""
    hints = hints_of(Simulation)
    fields = {name: _part(name, json.dumps(value)) for name, value in tree.items() if name in hints}
    return Simulation(**fields) if len(fields) == len(tree) - 1 else decode(Simulation, tree)


@lru_cache(maxsize=1000)
def _part(name: str, text: str) -> Any:
    return decode(hints_of(Simulation)[name], json.loads(text))


def _measured(recorder: MemoryRecorder, task: Task) -> Row:
    """What is read from a recording, as part of a row."""
    layout, numbers = recorder.layout, {}
    for index, (name, own) in enumerate(layout.series.items(), start=1):
        if own["role"] == CONSERVED:
            values = recorder.numbers[:, index]
            numbers[f"{name}_drift"] = float(
                np.abs(values - values[0]).max() / (scale_of(values, own.get(MAGNITUDE))[0] or 1.0)
            )
    numbers |= costs_of(recorder.attributes)
    if task.tracked or task.quantities:
        numbers |= asked_of(recorder.dataset(), task)
    dims = dict.fromkeys(layout.fields, ("t", layout.space)) | dict.fromkeys(layout.series, ("t",))
    times = recorder.numbers[:, 0]
    sizes = {"t": recorder.frames, layout.space: layout.coordinates.size}
    return {
        "status": str(recorder.attributes["status"]),
        "quantities": numbers,
        "sizes": sizes,
        "layout": layout_digest(list(dims.items()), times, [layout.coordinates]),
    }


def stacked(recorders: Sequence[MemoryRecorder], names: Sequence[str]) -> xr.Dataset:
    """Recordings of one layout as one Dataset along ``member``.

    Parameters
    ----------
    recorders : sequence of MemoryRecorder
        The recordings.
    names : sequence of str
        The names of the members.
    """
    import xarray as xr

    first = recorders[0].layout
    states = np.stack([recorder.states for recorder in recorders])
    numbers = np.stack([recorder.numbers for recorder in recorders])
    fields = {
        name: ((MEMBER, "t", first.space), states[:, :, index], own) for index, (name, own) in enumerate(first.fields.items())
    }
    series = {
        name: ((MEMBER, "t"), numbers[:, :, index], {key: value for key, value in own.items() if key != MAGNITUDE})
        for index, (name, own) in enumerate(first.series.items(), start=1)
    }
    own = np.array([json.dumps(_attributes(recorder)) for recorder in recorders], dtype=object)
    words = {ATTRIBUTES: (MEMBER, own, {"long_name": "the attributes of the result of each member, as JSON"})}
    coordinates = {
        MEMBER: (MEMBER, np.array(names, dtype=object)),
        "t": ("t", numbers[0, :, 0], describe("t")),
        first.space: (first.space, first.coordinates, first.coordinate_attributes),
    }
    return xr.Dataset({**fields, **series, **words}, coordinates, {"title": "Members of a sweep that share a file"})


def _attributes(recorder: MemoryRecorder) -> dict[str, Any]:
    """The attributes of a result, and those of its numbers that are its own."""
    magnitudes = {name: own[MAGNITUDE] for name, own in recorder.layout.series.items() if MAGNITUDE in own}
    return recorder.attributes | {f"{MAGNITUDE}s": magnitudes}


def open_block(path: Path) -> xr.Dataset:
    """The file of a block, opened lazily; raises `InputError` if it cannot be read."""
    try:
        return open_netcdf(path)
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error}); run the same sweep again.") from None


def unstacked(block: xr.Dataset, place: int) -> xr.Dataset:
    """A member of a block, as `mol_compactons.run` returns it.

    Parameters
    ----------
    block : xarray.Dataset
        The file, opened.
    place : int
        Which member.
    """
    attributes = json.loads(str(block[ATTRIBUTES].values[place]))
    magnitudes = attributes.pop(f"{MAGNITUDE}s")
    member = block.drop_vars([ATTRIBUTES, MEMBER]).isel({MEMBER: place}).load()
    for name, magnitude in magnitudes.items():
        member[name].attrs[MAGNITUDE] = magnitude
    return member.assign_attrs(attributes)
