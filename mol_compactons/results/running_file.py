"""The file of a run that goes on: NetCDF in its classic format, to which whole frames are added.

In the classic format with 64-bit offsets a frame, with all its numbers, is one block at the end of the file, and how many
there are is one number in its header. There is no index that could be left half written: a frame counts when that number does,
and that is written after the frame is safe on disk. What of the header changes later has its room from the start. Appending
takes no library, so that threads do not meet in it.
"""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import socket
import time
import weakref
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.results.places import parts_of
from mol_compactons.results.recorder import PART
from mol_compactons.results.schema import Layout, describe

Array = NDArray[np.float64]

_fcntl: ModuleType | None
try:
    import fcntl as _fcntl
except ImportError:  # a system without it has no claims
    _fcntl = None

SYNC_SECONDS = 1.0
SYNC_BYTES = 2**22
"""Frames become safe on disk after so many seconds or bytes, whichever comes first."""

STATUS_ROOM = 1024
"""How many bytes the status has in the header."""

COUNT_PLACE, COUNT_SIZE = 4, 4
"""Where the header has the number of frames, and in how many bytes, the highest first."""

PLACEHOLDER = "@" * STATUS_ROOM

_open_files: weakref.WeakSet[RunningFile] = weakref.WeakSet()
"""Those of this process; a process that is forked from it would keep their claims."""


def _let_go() -> None:
    for file in list(_open_files):
        file.close()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_let_go)

_NUMBERS = {int: ("i4",), float: ("f8",)}


class RunningFile:
    """A NetCDF file that grows by whole frames.

    Parameters
    ----------
    path : Path
        Where it is made; no file is there.
    layout : Layout
        What the result looks like. A frame holds the time, the series, what is recorded more often, and the fields.

    Raises
    ------
    OSError, RuntimeError
        If it cannot be written.
    """

    def __init__(self, path: Path, layout: Layout) -> None:
        self._layout = layout
        self._numbers = len(layout.series) + 1
        self._blocks = self._numbers + len(layout.often) * layout.series_per_frame
        self._row_size = 8 * (self._blocks + len(layout.fields) * layout.coordinates.size)
        header = header_of(layout, self._row_size)
        self._first, self._status_place = len(header), header.index(PLACEHOLDER.encode())
        self._waiting: list[bytes] = []
        self._synced = time.monotonic()
        self.frames = 0
        self._file = path.open("xb+", buffering=0)
        claim(self._file.fileno())
        _open_files.add(self)
        self._write(0, header)
        self.set_status("running")

    @property
    def size(self) -> int:
        """How many bytes it has."""
        return self._first + self.frames * self._row_size

    @property
    def is_closed(self) -> bool:
        """Whether it was closed."""
        return self._file.closed

    @property
    def descriptor(self) -> int:
        """The number of the open file."""
        return self._file.fileno()

    def append(self, state: Array, between: Array) -> None:
        """Add a frame; it is in the file after the next `sync`."""
        row = np.empty(self._row_size // 8, ">f8")
        row[: self._numbers] = between[-1]
        row[self._numbers : self._blocks] = self._layout.block(between).reshape(-1)
        row[self._blocks :] = state.reshape(-1)
        self._waiting.append(row.tobytes())

    @property
    def due(self) -> bool:
        """Whether it is time for a `sync`."""
        return time.monotonic() - self._synced > SYNC_SECONDS or len(self._waiting) * self._row_size > SYNC_BYTES

    def sync(self) -> None:
        """Make all frames safe on disk, and count them.

        Raises
        ------
        OSError
            If they cannot be written; those counted before stay.
        """
        if self._waiting:
            try:
                self._write(self._first + self.frames * self._row_size, b"".join(self._waiting))
                os.fsync(self._file.fileno())
            except OSError:
                with contextlib.suppress(OSError):
                    self._file.truncate(self._first + self.frames * self._row_size)
                raise
            self._count(self.frames + len(self._waiting))
            self._waiting.clear()
            os.fsync(self._file.fileno())
        self._synced = time.monotonic()

    def set_status(self, status: str) -> None:
        """Write the status into its room."""
        # All readers take the zeros at the end away.
        text = status.encode()[: STATUS_ROOM - 1].decode(errors="ignore").encode()
        self._write(self._status_place, text.ljust(STATUS_ROOM, b"\0"))

    def touch(self) -> None:
        """Show that the run is alive: the file was changed now."""
        with contextlib.suppress(OSError):
            os.utime(self._file.fileno())

    def rows(self, first: int, count: int) -> tuple[Array, Array, Array]:
        """Frames that are counted: time and series (1 + names, count), what is more often (names, count, times), fields."""
        self._file.seek(self._first + first * self._row_size)
        content = bytearray(count * self._row_size)
        rest = memoryview(content)
        while rest:
            rest = rest[self._file.readinto(rest) :]
        rows = np.frombuffer(content, ">f8").reshape(count, self._row_size // 8).astype(float)
        often = rows[:, self._numbers : self._blocks].reshape(count, len(self._layout.often), self._layout.series_per_frame)
        fields = rows[:, self._blocks :].reshape(count, len(self._layout.fields), self._layout.coordinates.size)
        return rows[:, : self._numbers].T, often.swapaxes(0, 1), fields.swapaxes(0, 1)

    def copy_to(self, target: Path) -> None:
        """Copy all that is counted to a new file."""
        self._file.seek(0)
        with target.open("xb") as copy:
            shutil.copyfileobj(self._file, copy)
            copy.truncate(self.size)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _count(self, frames: int) -> None:
        self._write(COUNT_PLACE, frames.to_bytes(COUNT_SIZE, "big"))
        self.frames = frames

    def _write(self, place: int, content: bytes) -> None:
        self._file.seek(place)
        rest = memoryview(content)
        while rest:
            rest = rest[self._file.write(rest) :]


def header_of(layout: Layout, row_size: int) -> bytes:
    """The beginning of the file, up to its first frame, with the points and no frame.

    It is made with one frame, which is cut off: scipy takes the length of a frame from it.
    """
    from scipy.io import netcdf_file

    content = io.BytesIO()
    owner = {"process": f"{os.getpid()} on {socket.gethostname()}"}
    with netcdf_file(content, "w", version=2) as file:
        _describe(file, layout.attributes | owner | {"status": PLACEHOLDER})
        file.createDimension("t", None)
        file.createDimension(layout.space, layout.coordinates.size)
        _create(file, layout.space, (layout.space,), layout.coordinate_attributes)[:] = layout.coordinates
        for name, own in {"t": describe("t"), **layout.series}.items():
            _create(file, name, ("t",), own)[0] = 0.0
        if layout.often:
            file.createDimension(PART, layout.series_per_frame)
        for name, own in layout.often.items():
            _create(file, name, ("t", PART), own)[0] = 0.0
        for name, own in layout.fields.items():
            _create(file, name, ("t", layout.space), own)[0] = 0.0
        file.flush()
        whole = bytearray(content.getvalue())
    del whole[-row_size:]
    whole[COUNT_PLACE : COUNT_PLACE + COUNT_SIZE] = bytes(COUNT_SIZE)
    return bytes(whole)


def _create(file: Any, name: str, dimensions: tuple[str, ...], attributes: dict[str, Any]) -> Any:
    variable = file.createVariable(name, "f8", dimensions)
    _describe(variable, attributes if name in dimensions else {"_FillValue": np.nan, **attributes})
    return variable


def _describe(target: Any, attributes: dict[str, Any]) -> None:
    for name, value in attributes.items():
        setattr(target, name, value.encode() if isinstance(value, str) else np.asarray(value, *_NUMBERS.get(type(value), ())))


def claim(descriptor: int) -> None:
    """Claim an open file until it is closed or the process ends, however it ends.

    Raises
    ------
    BlockingIOError
        If another process has claimed it.
    """
    if _fcntl is None:
        return
    try:
        _fcntl.flock(descriptor, _fcntl.LOCK_EX | _fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError:  # a file system without claims
        return


def is_wanted(path: Path, own: Path | None = None) -> bool:
    """Whether a run that is alive, other than the one that writes its own part, writes the file or is going to replace it."""
    return is_claimed(path) or any(is_claimed(part) for part in parts_of(path) if part != own)


def is_claimed(path: Path) -> bool:
    """Whether a run that is alive writes the file."""
    if _fcntl is None:
        return False
    try:
        with path.open("rb") as file:
            _fcntl.flock(file.fileno(), _fcntl.LOCK_SH | _fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False
