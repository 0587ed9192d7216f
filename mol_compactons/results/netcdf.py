"""Results on disk: a file that grows frame by frame, can be read meanwhile, and becomes compressed NetCDF-4 at the end."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import InputError, IntegrationError, require
from mol_compactons.results import checkpoint
from mol_compactons.results.places import check_target, keep_mode, leftovers, new_part, sync_folder, why, written_whole
from mol_compactons.results.recorder import Watch, in_one_row
from mol_compactons.results.running_file import RunningFile, is_claimed, is_wanted
from mol_compactons.results.schema import COMPLETE, SERIES_TIME, Layout, describe
from mol_compactons.runtime.netcdf import new_netcdf, open_netcdf

if TYPE_CHECKING:
    import xarray as xr

RESTART, CHECKPOINT = "restart", "checkpoint"
"""The group of a result, and the variable in it, that hold a checkpoint with which the run can go on beyond its end."""

QUICK_BYTES = 2**25
"""A run that was interrupted leaves a longer file as it is, to end at once."""

CHUNK_BYTES = 2**19
"""About how much of a field is compressed as one piece."""


class NetCDFRecorder:
    """A `Recorder` that streams the frames into a NetCDF file.

    While the run goes on it is a `RunningFile`. It is made under a hidden name, and takes its place at once where no file is
    there. A file that is to be replaced stays until the first frame beyond the initial one is safe.

    Parameters
    ----------
    layout : Layout
        What the result looks like.
    path : Path
        The file.
    overwrite : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    InputError
        If the folder does not exist, the file exists, another run writes it, or it cannot be written.
    """

    def __init__(self, layout: Layout, path: Path, overwrite: bool) -> None:
        check_target(path, overwrite)
        self.layout, self._path, self._place = layout, path, path
        self._t = 0.0
        self._replaces = path.exists()
        self._replaced = _signature(path)
        self._part = new_part(path)
        require(not is_wanted(path), f"Another run is writing {path}; wait for its end, or choose another name.")
        self._published = self._goes_on = False
        self._ended: xr.Dataset | None = None
        try:
            self._file = RunningFile(self._part, layout)
        except (OSError, RuntimeError) as error:
            self._part.unlink(missing_ok=True)
            raise InputError(f"{path} cannot be written: {why(error, path.parent)}.") from None
        if self._replaces and is_wanted(path, self._part):
            self._give_up()
            raise InputError(f"Another run is about to write {path}; wait for its end, or choose another name.")

    @property
    def is_published(self) -> bool:
        """Whether the file has its name, and no other is there any more."""
        return self._published

    @property
    def frames(self) -> int:
        """How many frames are safe on disk."""
        return self._file.frames

    def take_over(self, dataset: xr.Dataset, frames: int) -> None:
        """Begin with the first frames of an earlier result, which may be the one that is to be replaced."""
        self._goes_on = True
        try:
            self._copy(dataset, frames)
        except BaseException:
            self._give_up()
            raise
        self.publish()

    def _copy(self, dataset: xr.Dataset, frames: int) -> None:
        parts = self.layout.series_per_frame
        for name in (*self.layout.fields, *self.layout.series, *self.layout.often):
            whole = name in dataset and (name not in self.layout.often or dataset[name].size > (frames - 1) * parts)
            require(whole, f"{self._path} lacks {name}, or a part of it, to go on from; run again with --overwrite.")
        rows = max(1, CHUNK_BYTES // (8 * self.layout.coordinates.size))
        series = np.stack([dataset[name].values for name in ("t", *self.layout.series)], axis=1)
        often = np.stack([dataset[name].values for name in self.layout.often], axis=1) if self.layout.often else None
        for first in range(0, frames, rows):
            block = dataset[list(self.layout.fields)].isel(t=slice(first, min(first + rows, frames))).load()
            fields = np.stack([block[name].values for name in self.layout.fields], axis=1)
            for index, state in enumerate(fields, start=first):
                last = index * parts + 1
                between = series[index : index + 1] if often is None else often[max(last - parts, 0) : last]
                self._file.append(state, between)
            with self._writing(float(block["t"].values[-1])):
                self._file.sync()

    def _give_up(self) -> None:
        self._file.close()
        self._part.unlink(missing_ok=True)

    def append(self, state: NDArray[np.float64], between: NDArray[np.float64]) -> None:
        """Add a frame; raises `IntegrationError` where the file cannot be written any further."""
        self._t = t = float(between[-1][0])
        self._file.append(state, between)
        if self._file.due or self._file.frames == 0:
            self.sync(t)

    def sync(self, t: float) -> None:
        """Make all frames safe on disk; raises `IntegrationError` where that fails."""
        with self._writing(t):
            self._file.sync()
        if not self._published:
            if not self._replaces or self._file.frames > 1:
                self.publish()
        elif not self._is_in_place():
            self._rescue()
            raise IntegrationError(
                f"Another program replaced or removed {self._path}; the frames so far were {self._saved}.", t
            )

    def alive(self) -> None:
        """Show that the run goes on, also where no frame has come for a while."""
        self._file.touch()

    def publish(self) -> None:
        """Give the file its name; raises `InputError`, and gives it up, where another run or program has taken that."""
        if self._published:
            return
        if self._replaces and _signature(self._path) != self._replaced:
            self._rescue()
            raise IntegrationError(f"Another program changed {self._path}; the frames so far were {self._saved}.", self._t)
        if self._replaces:
            keep_mode(self._path, self._part)
        try:
            require(not is_claimed(self._path), f"Another run has begun to write {self._path}; choose another name.")
            self._take_the_name()
        except InputError:
            self._give_up()
            raise
        self._published = True
        if not self._goes_on:
            checkpoint.discard(self._path)
        sync_folder(self._path.parent)
        for leftover in leftovers(self._path):
            if not is_claimed(leftover):
                leftover.unlink(missing_ok=True)

    def _take_the_name(self) -> None:
        try:
            if self._replaces:
                self._part.replace(self._path)
            else:
                _name_once(self._part, self._path)
        except FileExistsError:
            raise InputError(f"Another program has made {self._path}; choose another name.") from None
        except OSError as error:
            raise InputError(f"{self._path} cannot be written: {why(error, self._path.parent)}.") from None

    def _is_in_place(self) -> bool:
        try:
            return os.path.samestat(self._path.stat(), os.fstat(self._file.descriptor))
        except OSError:
            return False

    @contextlib.contextmanager
    def _writing(self, t: float) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            reason = why(error, self._path.parent)
            raise IntegrationError(f"{self._path} cannot be written any further: {reason}.", t) from None

    def close(self, attributes: dict[str, Any], memory: bytes = b"", watch: Watch = lambda: None) -> bool:
        """End the recording: the file becomes compressed NetCDF-4, or stays as it is where there is no room for that.

        Parameters
        ----------
        attributes : dict
            Those of a run that has ended.
        memory : bytes
            A checkpoint with which the run can go on from the end.
        watch : callable
            Called between parts of the work; what it raises leaves the file as it is, with all its frames.

        Returns
        -------
        bool
            Whether the memory is in the file.

        Raises
        ------
        IntegrationError
            If the last frames could not be written, or the file was replaced or removed; the sentence says where they are.
        """
        if self._file.is_closed:
            return False
        try:
            return self._end(attributes, memory, watch)
        finally:
            self._file.close()
            if not self._published:
                self._part.unlink(missing_ok=True)

    def _end(self, attributes: dict[str, Any], memory: bytes, watch: Watch) -> bool:
        trouble = None
        try:
            self.sync(self._t)
        except IntegrationError as error:
            trouble = error
            if attributes["status"] == COMPLETE:
                attributes = attributes | {"status": f"failed at t = {self._t:.6g}: {error}"}
        with contextlib.suppress(OSError):
            self._file.set_status(str(attributes["status"]))
        if trouble:
            raise trouble
        if not self._published:
            self._keep_in_memory(attributes)
            return False
        if str(attributes["status"]).startswith("interrupted") and self._file.size > QUICK_BYTES:
            return False
        try:
            with written_whole(self._path) as part:
                _compress(self._file, part, self.layout, attributes, memory, watch)
        except InputError:
            return False
        return True

    def _keep_in_memory(self, attributes: dict[str, Any]) -> None:
        """A run that got nowhere leaves the earlier file as it is."""
        with open_netcdf(self._part) as dataset:
            self._ended = in_one_row(dataset.load()).assign_attrs(attributes)

    @property
    def _saved(self) -> str:
        return f"saved as {self._place}" if self._place != self._path else "lost"

    def _rescue(self) -> None:
        """Save the frames in another place."""
        if self._place != self._path:
            return
        for folder in (self._path.parent, Path.cwd(), Path(tempfile.gettempdir())):
            target = folder / f"{self._path.stem}.rescued-{os.getpid()}{self._path.suffix}"
            with contextlib.suppress(OSError):
                self._file.copy_to(target)
                self._place = target
                return

    def dataset(self) -> xr.Dataset:
        """The file, opened lazily."""
        if self._ended is not None:
            return self._ended
        try:
            return in_one_row(open_netcdf(self._place))
        except (OSError, ValueError):
            raise InputError(f"Another program replaced or removed {self._path} while the run went on.") from None


def _signature(path: Path) -> tuple[int, int, int] | None:
    """What changes when a file is replaced or written; None where there is none."""
    try:
        known = path.stat()
    except OSError:
        return None
    return known.st_ino, known.st_mtime_ns, known.st_size


def _name_once(part: Path, path: Path) -> None:
    """Rename a file to a name that is free; raises FileExistsError where it is not."""
    try:
        os.link(part, path)
    except FileExistsError:
        raise
    except OSError:  # a file system without links
        if path.exists():
            raise FileExistsError(path) from None
        part.rename(path)
    else:
        part.unlink()


def _compress(file: RunningFile, part: Path, layout: Layout, attributes: dict[str, Any], memory: bytes, watch: Watch) -> None:
    """Write what a running file holds as compressed NetCDF-4, block by block."""
    rows = max(1, min(CHUNK_BYTES // (8 * layout.coordinates.size), file.frames))
    parts = layout.series_per_frame
    with new_netcdf(part) as target:
        _lay_out(target, layout, attributes, rows)
        if memory:
            group = target.create_group(RESTART)
            group.dimensions["byte"] = len(memory)
            group.create_variable(CHECKPOINT, ("byte",), data=np.frombuffer(memory, "u1"))
        target.resize_dimension("t", file.frames)
        if layout.often:
            target.resize_dimension(SERIES_TIME, max((file.frames - 1) * parts + 1, 0))
        for first in range(0, file.frames, rows):
            watch()
            count = min(rows, file.frames - first)
            series, often, fields = file.rows(first, count)
            for name, values in zip(("t", *layout.series), series, strict=True):
                target[name][first : first + count] = values
            for name, values in zip(layout.fields, fields, strict=True):
                target[name][first : first + count] = values
            before, after = max(first * parts - parts + 1, 0), (first + count - 1) * parts + 1
            for name, values in zip(layout.often, often, strict=True):
                target[name][before:after] = values.reshape(-1)[count * parts - (after - before) :]


def _lay_out(target: Any, layout: Layout, attributes: dict[str, Any], rows: int) -> None:
    """The dimensions, variables and attributes of a result."""
    parts = layout.series_per_frame
    _describe(target, layout.attributes | attributes)
    target.dimensions = {"t": None, layout.space: layout.coordinates.size}
    points = target.create_variable(layout.space, (layout.space,), data=layout.coordinates)
    _describe(points, layout.coordinate_attributes)
    if layout.often:
        target.dimensions[SERIES_TIME] = None
    lines = [("t", "t", describe("t")), *(("t", *one) for one in layout.series.items())]
    for along, name, own in (*lines, *((SERIES_TIME, *one) for one in layout.often.items())):
        length = min(layout.frames * (parts if along == SERIES_TIME else 1), 1024)
        missing = None if name == along else np.nan
        _describe(target.create_variable(name, (along,), "f8", fillvalue=missing, chunks=(length,)), own)
    packed = {"chunks": (rows, layout.coordinates.size), "compression": "gzip", "compression_opts": 1, "shuffle": True}
    for name, own in layout.fields.items():
        _describe(target.create_variable(name, ("t", layout.space), "f8", fillvalue=np.nan, **packed), own)


def _describe(target: Any, attributes: dict[str, Any]) -> None:
    """Give a file, a group or a variable its attributes; texts as NetCDF's characters, which every reader knows."""
    from h5py import string_dtype

    for name, value in attributes.items():
        if isinstance(value, str):
            content = value.encode()
            # Of a single byte a reader cannot tell whether it is a text.
            target.attrs[name] = np.array(content, string_dtype("utf-8", max(2, len(content))))
        else:
            target.attrs[name] = value
