"""The lock of the NetCDF and HDF5 libraries, which are not safe in threads."""

from __future__ import annotations

from typing import Any


def library_lock() -> Any:
    """The lock to hold while netCDF4 is called: a context manager, not re-entrant, the same as that of xarray."""
    from xarray.backends.locks import HDF5_LOCK, NETCDFC_LOCK, combine_locks

    return combine_locks([NETCDFC_LOCK, HDF5_LOCK])
