"""Opening and writing NetCDF files without the library that netCDF4 brings, which is not safe in threads.

Results are read and written by scipy (the classic format) and by h5netcdf (NetCDF-4), whose HDF5 is called by one thread at a
time. So a run in one thread does not meet what another thread does with netCDF4, plain xarray included: in the wheels of PyPI
h5py has an HDF5 of its own. Where a distribution gives both the same one, it has to be built safe in threads.
"""

from __future__ import annotations

import io
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

ENGINES = {b"CDF\x01": "scipy", b"CDF\x02": "scipy", b"\x89HDF": "h5netcdf"}
"""Which of the engines of xarray reads a file that begins so."""

_OTHERS = threading.Lock()


def open_netcdf(path: Path, group: str | None = None, decode_cf: bool = True) -> xr.Dataset:
    """A NetCDF file, opened lazily; one of a format that only netCDF4 reads comes into memory.

    Raises
    ------
    OSError
        If it cannot be read, or has no such group.
    """
    engine = _engine_of(path)
    try:
        return _opened(path, engine, group, decode_cf)
    except Exception as error:  # what the libraries raise for damaged files has no end
        if _engine_of(path) != engine:  # a run that has just ended put its file in another format in place of this one
            return open_netcdf(path, group, decode_cf)
        if isinstance(error, OSError):
            raise
        raise OSError(f"{type(error).__name__}: {error}") from error


def _engine_of(path: Path) -> str | None:
    with path.open("rb") as file:
        return ENGINES.get(file.read(4))


def _opened(path: Path, engine: str | None, group: str | None, decode_cf: bool) -> xr.Dataset:
    import xarray as xr

    if engine == "scipy" and group is not None:
        raise OSError(f"{path} has no groups.")
    if engine == "h5netcdf":
        import h5py

        with h5py.File(path, "r") as file:  # where this fails, h5netcdf leaves an object that complains when it is forgotten
            file.attrs.get("_nc3_strict")
    if engine:
        own = {} if group is None else {"group": group}
        return xr.open_dataset(path, engine=engine, decode_cf=decode_cf, **own)  # type: ignore[arg-type]
    with _OTHERS, xr.open_dataset(path, group=group, decode_cf=decode_cf) as dataset:
        return dataset.load()


@contextmanager
def new_netcdf(path: Path) -> Iterator[Any]:
    """A new NetCDF-4 file, an `h5netcdf.File`, closed at the end.

    Raises
    ------
    OSError
        If it cannot be written; whatever else came up in a write, as KeyboardInterrupt, is raised at the end.
    """
    import h5netcdf

    target = _Target(path)
    try:
        with h5netcdf.File(target, "w") as file:
            yield file
    finally:
        target.close()
        if target.error:
            raise target.error


class _Target(io.RawIOBase):
    """What HDF5 takes for a file, and that never fails: HDF5, where a write fails, crashes when the process ends.

    After the first failure, which is kept as `error`, nothing more is written.
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._file = path.open("xb+", buffering=0)
        self.error: BaseException | None = None

    def write(self, content: Any) -> int:
        """Write all of it at the current place."""
        rest = memoryview(content)
        try:
            while rest and not self.error:
                rest = rest[self._file.write(rest) :]
        except BaseException as error:
            self.error = self.error or error
        return len(content)

    def flush(self) -> None:
        """Nothing waits here."""

    def readinto(self, room: Any) -> int:
        """Read from the current place."""
        return self._file.readinto(room) or 0

    def seek(self, place: int, whence: int = os.SEEK_SET) -> int:
        """Go to a place."""
        return self._file.seek(place, whence)

    def tell(self) -> int:
        """The current place."""
        return self._file.tell()

    def truncate(self, size: int | None = None) -> int:
        """Make the file as long as that."""
        try:
            return self._file.truncate(size)
        except BaseException as error:
            self.error = self.error or error
            return size or 0

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()
