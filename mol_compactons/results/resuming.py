"""What an earlier run left, complete or not, so that another one can go on from it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mol_compactons.configuration import encode
from mol_compactons.errors import require, shown
from mol_compactons.integrators.base import Counters
from mol_compactons.results import checkpoint
from mol_compactons.results.checkpoint import Checkpoint
from mol_compactons.results.form import check_form, reading
from mol_compactons.results.netcdf import CHECKPOINT, RESTART
from mol_compactons.results.opening import open_result
from mol_compactons.results.reading import field_names, space_of
from mol_compactons.results.running_file import is_wanted
from mol_compactons.results.schema import COMPLETE, FRAMES_BEFORE
from mol_compactons.runtime.netcdf import open_netcdf
from mol_compactons.simulation import Simulation

if TYPE_CHECKING:
    import xarray as xr

MAY_DIFFER = ("t_end", "frames", "output_times", "title")
"""The settings in which a run may differ from the one that it goes on from."""

BLOCK_SIZE = 2**19
"""About how many numbers are looked at at once."""


@dataclass(frozen=True, eq=False)
class Earlier:
    """What is there to go on from.

    Parameters
    ----------
    dataset : xarray.Dataset
        The earlier result, opened lazily.
    simulation : Simulation
        What is to be run in all: the earlier simulation, to the later of both ends.
    frames : int
        How many of its frames are whole and stand at the right times.
    checkpoint : Checkpoint or None
        Where its integrator was, no farther than the next frame; None where nothing is known but the frames.
    keeps_itself : bool
        Whether the result itself holds a checkpoint, so that none is needed beside it.
    """

    dataset: xr.Dataset
    simulation: Simulation
    frames: int
    checkpoint: Checkpoint | None
    keeps_itself: bool

    @property
    def is_enough(self) -> bool:
        """Whether nothing is left to do: it is complete, and no checkpoint beside it waits to become a part of it."""
        whole = str(self.dataset.attrs["status"]) == COMPLETE and self.frames == self.simulation.frames
        return whole and (self.keeps_itself or self.checkpoint is None)

    @property
    def frames_before(self) -> list[int]:
        """The numbers of frames with which it was asked for before it went beyond its end."""
        before = frames_before(self.dataset)
        stored = Simulation.from_json(str(self.dataset.attrs["simulation"])).frames
        return before if stored == self.simulation.frames or stored in before else [*before, stored]

    @property
    def history(self) -> str:
        """What was done so far."""
        return str(self.dataset.attrs.get("history", ""))


def look_for_earlier(path: Path, asked: Simulation) -> Earlier:
    """What a file and the checkpoints beside it hold of a simulation that is asked for.

    Raises
    ------
    InputError
        If another run is writing the file, it is no result, or its settings are others in more than the end.
    """
    require(not is_wanted(path), f"Another run is writing {path}; wait for its end, or stop it.")
    dataset = open_result(path)
    try:
        with reading(path):
            check_form(dataset, path)
        stored = Simulation.from_json(str(dataset.attrs["simulation"]))
        _insist_on_whole_rows(path, dataset, stored)
        _insist_on_the_same(path, stored, asked)
        simulation = _in_all(path, stored, asked, frames_before(dataset))
        with reading(path):
            frames = min(_whole_frames(dataset, simulation), simulation.frames)
        require(frames > 0, f"{path} holds no whole frame to go on from; run again with --overwrite.")
        inside = _stored_memory(path)
        found = [checkpoint.last(path), inside]
        usable = [one for one in found if one is not None and 0 < one.frames <= frames and _belongs(one, stored, simulation)]
        best = max(usable, key=lambda one: one.t, default=None)
        return Earlier(dataset, simulation, best.frames if best else frames, best, inside is not None)
    except BaseException:
        dataset.close()
        raise


def frames_before(dataset: xr.Dataset) -> list[int]:
    """The numbers of frames with which a result was asked for before it went beyond its end."""
    return [int(number) for number in str(dataset.attrs.get(FRAMES_BEFORE, "")).split(",") if number.strip().isdigit()]


def _in_all(path: Path, stored: Simulation, asked: Simulation, before: list[int]) -> Simulation:
    """What is to be run in all, to the later of both ends; `before` are numbers of frames that may be meant by the same."""
    if stored.output_times is not None or asked.output_times is not None:
        longer, shorter = (asked, stored) if asked.t_end > stored.t_end else (stored, asked)
        require(
            np.array_equal(longer.times[: shorter.frames], shorter.times),
            f"The output times differ from those of {path}; begin with the same, to go on beyond them.",
        )
        return longer
    simulation = stored.extended(max(stored.t_end, asked.t_end))
    require(
        asked.frames in (stored.frames, simulation.frames, *before),
        f"frames = {asked.frames} differs from {path}, whose {stored.frames} frames to t = {stored.t_end:g} set their "
        f"distance; leave it out, and their number is computed.",
    )
    return simulation


def _insist_on_the_same(path: Path, stored: Simulation, asked: Simulation) -> None:
    ours, theirs = encode(asked), encode(stored)
    for name in ours:
        require(
            name in MAY_DIFFER or ours[name] == theirs[name],
            f"The {name} differs from that of {path}, which is {_told(theirs[name])} and not {_told(ours[name])}; a run that "
            f"goes on has to keep it: run {path.name} itself with --resume, or write to another file.",
        )


def _told(setting: Any) -> str:
    return shown(json.dumps(setting))


def _insist_on_whole_rows(path: Path, dataset: xr.Dataset, stored: Simulation) -> None:
    """Refuse a result whose fields are not along t and all the points of its run, as one that was thinned or turned."""
    space = space_of(dataset)
    points, order = dataset[space].values, {dataset[name].dims for name in field_names(dataset)}
    require(
        np.array_equal(points, stored.grid.coordinates) and order == {("t", space)},
        f"{path} is not as its run wrote it: its points are other than the {stored.grid.size} of the run, or its dimensions "
        "stand in another order; only the result itself can go on.",
    )


def _belongs(found: Checkpoint, stored: Simulation, simulation: Simulation) -> bool:
    """Whether a checkpoint is one of the simulation that a result holds, with frames at the same times as far as both go."""
    ours, theirs = encode(stored), json.loads(found.simulation)
    if not all(name in MAY_DIFFER or ours[name] == theirs.get(name) for name in ours):
        return False
    times = Simulation.from_json(found.simulation).times
    shared = min(times.size, simulation.frames)
    return np.array_equal(times[:shared], simulation.times[:shared])


def _whole_frames(dataset: xr.Dataset, simulation: Simulation) -> int:
    """How many frames from the first on are finite and stand where the simulation has them."""
    count = min(dataset.sizes["t"], simulation.frames)
    whole = dataset["t"].values[:count] == simulation.times[:count]
    rows = max(1, BLOCK_SIZE // simulation.grid.size)
    for first in range(0, count, rows):
        block = slice(first, min(first + rows, count))
        for name in field_names(dataset):
            whole[block] &= np.isfinite(dataset[name].transpose("t", ...)[block].values).all(axis=1)
    return count if whole.all() else int(np.argmin(whole))


def _stored_memory(path: Path) -> Checkpoint | None:
    """What a result that is complete keeps of its integrator."""
    try:
        group = open_netcdf(path, group=RESTART, decode_cf=False)
    except OSError:  # it has no such group
        return None
    with group:
        return Checkpoint.from_bytes(group[CHECKPOINT].values.tobytes()) if CHECKPOINT in group else None


def from_last_frame(earlier: Earlier) -> Checkpoint:
    """A checkpoint that is made from the last whole frame, where there is no other."""
    frame = earlier.dataset.isel(t=earlier.frames - 1)
    state = np.stack([frame[name].values for name in field_names(earlier.dataset)]).astype(float)
    t = float(frame["t"])
    about = {"t": t, "frames": earlier.frames, "counters": Counters(), "seconds": 0.0, "simulation": "", "source": ""}
    return Checkpoint(memory={"t": np.array(t), "state": state}, **about)  # type: ignore[arg-type]
