"""Many small members in one file: a block, so that the file system is not the limit of a study."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from mol_compactons.analysis.drift import largest_drift
from mol_compactons.configuration import decode, hints_of
from mol_compactons.errors import InputError
from mol_compactons.results import checkpoint
from mol_compactons.results.places import written_whole
from mol_compactons.results.recorder import MemoryRecorder
from mol_compactons.results.running_file import is_claimed
from mol_compactons.results.schema import CONSERVED, describe
from mol_compactons.running import recorded
from mol_compactons.runtime.netcdf import open_netcdf
from mol_compactons.simulation import Simulation
from mol_compactons.studies import modules
from mol_compactons.studies.members import Task, asked_of, attempted, carry_out, costs_of, layout_digest
from mol_compactons.studies.plan import digest
from mol_compactons.studies.store import FAILED, Row

if TYPE_CHECKING:
    import xarray as xr

MANY = 1000
"""From more members than this on, members share files unless told otherwise."""

PER_FILE = 100
"""How many share one."""

MOST_BYTES = 2**25
"""About how large the fields of a block may be."""

WITH_ONE_SHAPE = ("grid", "t_end", "frames", "output_times", "series_per_frame")
"""Members that have these fields in common are put into one block; their files are told apart by what comes out."""

MEMBER = "member"
"""The dimension along which a block has its members."""

MAGNITUDE = "magnitude"
"""The attribute of a conserved quantity that differs from member to member."""

ATTRIBUTES = "attributes"
"""The variable that holds, for each member, the attributes of its result as JSON."""


@dataclass(frozen=True)
class Block:
    """Members that run together; those that have the same variables go into one file.

    Parameters
    ----------
    tasks : tuple of Task
        The members.
    path : str
        Its file; where the variables differ, others beside it.
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
        alike[json.dumps([tree.get(name) for name in WITH_ONE_SHAPE])].append(task)
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
    """Run the members of a block, write those that ran to their end into its files, and say what they came to."""
    recorders: dict[str, MemoryRecorder] = {}
    parts: dict[tuple[str, str], Any] = {}

    def result(task: Task) -> Row:
        modules.load(task.modules)
        recorder = recorded(_decoded(task.tree, parts))
        own = _measured(recorder, task)
        recorders[task.name] = recorder
        return own

    rows = {task.name: attempted(task, lambda task=task: result(task)) for task in block.tasks}  # type: ignore[misc]
    groups = defaultdict(list)
    for name, recorder in recorders.items():
        groups[_shape(recorder)].append(name)
    for number, names in enumerate(groups.values()):
        path = Path(block.path)
        path = path.with_stem(f"{path.stem}_{number}") if number else path
        try:
            with written_whole(path) as part:
                stacked([recorders[name] for name in names], names).to_netcdf(part, engine="scipy")
        except Exception as error:  # of names and attributes of the user's own, too
            reason = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
            tasks = {task.name: task for task in block.tasks}
            rows |= {name: tasks[name].row(FAILED, reason) | {"seconds": rows[name]["seconds"]} for name in names}
            continue
        for place, name in enumerate(names):
            rows[name] |= {"file": path.name, "place": place}
    for task in block.tasks:
        if "file" in rows[task.name]:
            _remove_what_was_cut_off(Path(task.path))
    return list(rows.values())


def _remove_what_was_cut_off(path: Path) -> None:
    """Remove what an earlier attempt, with a file of its own, left of a member that is in a block now."""
    if path.is_file() and not is_claimed(path):
        checkpoint.discard(path)
        path.unlink(missing_ok=True)


def _shape(recorder: MemoryRecorder) -> str:
    """What recordings have in common that can stand in one file."""
    layout = recorder.layout
    own = [
        {name: {key: value for key, value in one.items() if key != MAGNITUDE} for name, one in variables.items()}
        for variables in (layout.fields, layout.series)
    ]
    return json.dumps([*own, layout.space, layout.coordinate_attributes, recorder.frames], default=str)


def _decoded(tree: dict[str, Any], parts: dict[tuple[str, str], Any]) -> Simulation:
    """A simulation from JSON-ready data, whose parts are made once where members of a block share them."""
    hints = hints_of(Simulation)
    if tree.keys() - hints.keys() != {"type"}:
        return cast(Simulation, decode(Simulation, tree))
    fields = {}
    for name in tree.keys() & hints.keys():
        key = name, repr(tree[name])  # which tells all JSON-ready data apart, and is quicker than JSON
        if key not in parts:
            parts[key] = decode(hints[name], tree[name])
        fields[name] = parts[key]
    return Simulation(**fields)


def _measured(recorder: MemoryRecorder, task: Task) -> Row:
    """What is read from a recording, as part of a row."""
    layout = recorder.layout
    numbers: dict[str, Any] = {
        f"{name}_drift": largest_drift(recorder.numbers[:, index], own.get(MAGNITUDE))
        for index, (name, own) in enumerate(layout.series.items(), start=1)
        if own["role"] == CONSERVED
    }
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
