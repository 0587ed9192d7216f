"""Opening NetCDF files without the library that netCDF4 brings, which is not safe in threads.

Results are read and written by scipy (the classic format) and by h5netcdf (NetCDF-4), whose HDF5 is called by one thread at a
time. So a run in one thread never meets whatever another thread does with netCDF4, plain xarray included.
"""

from __future__ import annotations

import threading
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

ENGINES = {b"CDF\x01": "scipy", b"CDF\x02": "scipy", b"\x89HDF": "h5netcdf"}
"""Which of the engines of xarray reads a file that begins so."""

_OTHERS = threading.Lock()


def open_netcdf(path: Path, group: str | None = None, decode_cf: bool = True) -> xr.Dataset:
    """A NetCDF file, opened lazily; one of a format that only netCDF4 reads comes into memory.

    Raises
    ------
    OSError, ValueError
        If it cannot be read, or has no such group. What the libraries raise for damaged files has no end.
    """
    import xarray as xr

    with path.open("rb") as file:
        engine = ENGINES.get(file.read(4))
    if engine == "scipy" and group is not None:
        raise OSError(f"{path} has no groups.")
    if engine:
        own = {} if group is None else {"group": group}
        return xr.open_dataset(path, engine=engine, decode_cf=decode_cf, **own)  # type: ignore[arg-type]
    with _OTHERS, xr.open_dataset(path, group=group, decode_cf=decode_cf) as dataset:
        return dataset.load()
