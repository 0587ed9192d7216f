from __future__ import annotations

import threading
from pathlib import Path

import numpy as np
import xarray as xr

from mol_compactons.runtime.locks import library_lock


def test_it_is_the_lock_that_xarray_waits_for(tmp_path: Path) -> None:
    xr.Dataset({"a": ("x", np.arange(5.0))}).to_netcdf(tmp_path / "a.nc", engine="netcdf4")
    dataset = xr.open_dataset(tmp_path / "a.nc", engine="netcdf4")
    read: list[float] = []
    thread = threading.Thread(target=lambda: read.append(float(dataset.a.sum())))
    with library_lock():
        thread.start()
        thread.join(0.3)
        assert read == []
    thread.join(30)
    assert read == [10.0]


def test_it_is_free_again_after_an_error() -> None:
    for _ in range(2):
        try:
            with library_lock():
                raise ZeroDivisionError
        except ZeroDivisionError:
            continue
