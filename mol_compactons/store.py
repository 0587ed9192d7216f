"""Results on disk: a NetCDF file that grows frame by frame and can be read while the run goes on."""

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

from mol_compactons.dataset import attributes, describe
from mol_compactons.errors import InputError, IntegrationError, require

if TYPE_CHECKING:
    import xarray as xr

    from mol_compactons.simulation import Simulation

SYNC_FRAMES = 16
SYNC_SECONDS = 1.0
"""The file is brought up to date on disk after so many frames or seconds, whichever comes first."""


class NetCDFRecorder:
    """A `Recorder` that streams the frames into a NetCDF-4 file.

    One chunk holds one frame, so that whatever was synchronised survives a crash. The status attribute says "running" until
    `close`.

    Parameters
    ----------
    simulation : Simulation
        What is run.
    conserved : list of str
        The names of the conserved quantities.
    path : Path
        The file.
    overwrite : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    InputError
        If the folder does not exist, the file exists, or it cannot be written.
    """

    def __init__(self, simulation: Simulation, conserved: list[str], path: Path, overwrite: bool) -> None:
        # Without this HDF5 locks the file against readers while the run goes on. It is read when the library is loaded.
        os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")
        import netCDF4

        check_target(path, overwrite)
        self._path = path
        self._names = simulation.equation.variables
        self._frames = 0
        self._synced = time.monotonic()
        try:
            path.unlink(missing_ok=True)
            self._file = netCDF4.Dataset(path, "w", format="NETCDF4", clobber=False)
        except OSError as error:
            raise InputError(f"{path} cannot be written ({error.strerror or error}); choose another place.") from None
        self._file.setncatts(attributes(simulation))
        self._file.createDimension("t", None)
        space, size = simulation.grid.dimension, simulation.grid.size
        self._file.createDimension(space, size)
        series_chunk = min(simulation.frames, 1024)
        for name in ("t", *conserved):
            self._create(name, ("t",), (series_chunk,), compressed=False)
        self._create(space, (space,), (size,), compressed=False)[:] = simulation.grid.coordinates
        for name in self._names:
            self._create(name, ("t", space), (1, size), compressed=True)
        self._file.sync()

    def _create(self, name: str, dimensions: tuple[str, ...], chunks: tuple[int, ...], compressed: bool) -> Any:
        fill = False if name in dimensions else np.nan
        variable = self._file.createVariable(
            name, "f8", dimensions, chunksizes=chunks, zlib=compressed, complevel=1, shuffle=compressed, fill_value=fill
        )
        variable.setncatts(describe(name))
        return variable

    def append(self, t: float, state: NDArray[np.float64], conserved: dict[str, float]) -> None:
        """Add a frame; raises `IntegrationError` where the file cannot be written any further."""
        index = self._frames
        with self._writing(t):
            for name, values in zip(self._names, state, strict=True):
                self._file[name][index] = values
            for name, value in conserved.items():
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


def write_tree(tree: xr.DataTree, path: str | Path) -> None:
    """Write a tree into a NetCDF file, whole or not at all."""
    path = Path(path)
    part = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        tree.to_netcdf(part, engine="netcdf4")
        part.replace(path)
    except OSError as error:
        raise InputError(f"{path} cannot be written ({error.strerror or error}); choose another place.") from None
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
