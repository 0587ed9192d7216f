"""The lock of the NetCDF and HDF5 libraries, which are not safe in threads, and opening a file under it."""

from __future__ import annotations

import threading
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr


class SharedLock:
    """The lock that xarray takes for netCDF4, which a thread may take again while it holds it."""

    def __init__(self) -> None:
        from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK

        self._lock: Any = NETCDF4_PYTHON_LOCK
        self._owner = 0
        self._depth = 0

    def acquire(self, blocking: bool = True) -> bool:
        """Take it, and wait for it where `blocking`."""
        own = threading.get_ident()
        if self._owner != own:
            if not self._lock.acquire(blocking):
                return False
            self._owner = own
        self._depth += 1
        return True

    def release(self) -> None:
        """Give it back."""
        self._depth -= 1
        if not self._depth:
            self._owner = 0
            self._lock.release()

    def locked(self) -> bool:
        """Whether a thread holds it through this object."""
        return self._depth > 0

    def __enter__(self) -> None:
        self.acquire()

    def __exit__(self, *error: object) -> None:
        self.release()

    def __reduce__(self) -> tuple[Any, ...]:
        return library_lock, ()


@cache
def library_lock() -> SharedLock:
    """The one lock to hold while netCDF4 is called."""
    return SharedLock()


def open_netcdf(path: Path, group: str | None = None, decode_cf: bool = True) -> xr.Dataset:
    """A NetCDF file, opened lazily with the lock held: xarray asks for the variables of a file without it."""
    import xarray as xr
    from xarray.backends import NetCDF4DataStore

    lock = library_lock()
    open_store: Any = NetCDF4DataStore.open
    with lock:
        store = open_store(str(path), mode="r", group=group, lock=lock)
        try:
            return xr.open_dataset(store, decode_cf=decode_cf)
        except BaseException:
            store.close()
            raise
