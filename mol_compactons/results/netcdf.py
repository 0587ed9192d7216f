"""Results on disk: a NetCDF file that grows frame by frame and can be read while the run goes on, and how it is read."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import InputError, IntegrationError, require
from mol_compactons.results.schema import Layout, describe

if TYPE_CHECKING:
    import xarray as xr

OPENING_ATTEMPTS = 15
"""How often a result is tried that cannot be opened at once."""

SYNC_FRAMES = 16
SYNC_SECONDS = 1.0
"""The file is brought up to date on disk after so many frames or seconds, whichever comes first."""


class NetCDFRecorder:
    """A `Recorder` that streams the frames into a NetCDF-4 file.

    One chunk holds one frame, so that whatever was synchronised survives a crash. The status attribute says "running" until
    `close`.

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
        If the folder does not exist, the file exists, or it cannot be written.
    """

    def __init__(self, layout: Layout, path: Path, overwrite: bool) -> None:
        # Without this HDF5 locks the file against readers while the run goes on. It is read when the library is loaded.
        os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")
        import netCDF4

        check_target(path, overwrite)
        self._path = path
        self._names = tuple(layout.fields)
        self._frames = 0
        self._synced = time.monotonic()
        try:
            path.unlink(missing_ok=True)
            self._file = netCDF4.Dataset(path, "w", format="NETCDF4", clobber=False)
        except OSError as error:
            raise InputError(f"{path} cannot be written ({error.strerror or error}); choose another place.") from None
        self._file.setncatts(layout.attributes)
        self._file.createDimension("t", None)
        space, size = layout.space, layout.coordinates.size
        self._file.createDimension(space, size)
        series_chunk = min(layout.frames, 1024)
        for name, own in {"t": describe("t"), **layout.series}.items():
            self._create(name, ("t",), (series_chunk,), own)
        self._create(space, (space,), (size,), layout.coordinate_attributes)[:] = layout.coordinates
        for name, own in layout.fields.items():
            self._create(name, ("t", space), (1, size), own)
        self._file.sync()

    def _create(self, name: str, dimensions: tuple[str, ...], chunks: tuple[int, ...], attributes: dict[str, Any]) -> Any:
        fill, compressed = False if name in dimensions else np.nan, len(dimensions) == 2
        variable = self._file.createVariable(
            name, "f8", dimensions, chunksizes=chunks, zlib=compressed, complevel=1, shuffle=compressed, fill_value=fill
        )
        variable.setncatts(attributes)
        return variable

    def append(self, t: float, state: NDArray[np.float64], numbers: dict[str, float]) -> None:
        """Add a frame; raises `IntegrationError` where the file cannot be written any further."""
        index = self._frames
        with self._writing(t):
            for name, values in zip(self._names, state, strict=True):
                self._file[name][index] = values
            for name, value in numbers.items():
                self._file[name][index] = value
            self._file["t"][index] = t
            self._frames += 1
            if index % SYNC_FRAMES == 0 or time.monotonic() - self._synced > SYNC_SECONDS:
                self._file.sync()
                self._synced = time.monotonic()

    def close(self, attributes: dict[str, Any]) -> None:
        """End the recording and close the file."""
        with self._writing(math.nan):
            self._file.setncatts(attributes)
            self._file.close()

    @contextmanager
    def _writing(self, t: float) -> Iterator[None]:
        try:
            yield
        except (OSError, RuntimeError) as error:
            raise IntegrationError(f"{self._path} cannot be written any further ({error}); is the disk full?", t) from None

    def dataset(self) -> xr.Dataset:
        """The file, opened lazily."""
        import xarray as xr

        try:
            return xr.open_dataset(self._path)
        except OSError:
            raise InputError(f"{self._path} was replaced by another program while the run went on.") from None


def write_tree(tree: xr.DataTree | xr.Dataset, path: str | Path) -> None:
    """Write a tree, or a Dataset, into a NetCDF file, whole or not at all."""
    path = Path(path)
    part = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        tree.to_netcdf(part, engine="netcdf4")
        part.replace(path)
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path} cannot be written ({reason}); choose another place.") from None
    finally:
        part.unlink(missing_ok=True)


def check_target(path: Path, overwrite: bool) -> None:
    """Raise `InputError` unless a file can be written at `path`."""
    try:
        path.exists()
    except OSError as error:
        raise InputError(f"{path} cannot be the name of a file ({error.strerror}); choose another.") from None
    require(not path.is_dir(), f"{path} is a folder; give the name of a file.")
    ordinary = path.is_file() and not path.is_symlink()
    require(ordinary or not os.path.lexists(path), f"{path} is not an ordinary file and is not replaced; choose another name.")
    require(path.parent.is_dir(), f"The folder {path.parent} does not exist; create it, or choose another.")
    require(os.access(path.parent, os.W_OK), f"The folder {path.parent} cannot be written; choose another.")
    require(
        overwrite or not path.exists(),
        f"{path} exists; allow overwriting (--overwrite, in Python overwrite=True) or choose another name.",
    )


def open_result(path: str | Path) -> xr.Dataset:
    """A result file, opened lazily; tried again for a while, since a run may be in the middle of writing it.

    Raises
    ------
    InputError
        If the file does not exist, cannot be read, or is no result of this program.
    """
    import xarray

    path = Path(path)
    require(path.is_file(), f"There is no file {path}; give one that mol-compactons wrote.")
    for attempt in range(OPENING_ATTEMPTS):
        try:
            dataset = xarray.open_dataset(path, engine="netcdf4")
            break
        except (OSError, ValueError) as error:
            if attempt == OPENING_ATTEMPTS - 1 or not _is_hdf5(path):
                raise InputError(f"{path} is not a NetCDF file that can be read ({error}).") from None
        time.sleep(0.2)
    missing = [name for name in ("simulation", "status", "title") if name not in dataset.attrs]
    if missing:
        dataset.close()
    require(not missing, f"{path} is not a result of mol_compactons: it has no attribute {', '.join(map(repr, missing))}.")
    return dataset


def open_study(path: str | Path) -> xr.DataTree:
    """A study of `mol_compactons.converge` from its file, opened lazily.

    Raises
    ------
    InputError
        If the file does not exist, cannot be read, or is no study of this program.
    """
    import xarray

    with open_result(path) as root:
        require("family" in root.attrs, f"{path} is no convergence study; make one with mol-compactons converge.")
    return xarray.open_datatree(path, engine="netcdf4")


def _is_hdf5(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(4) == b"\x89HDF"
