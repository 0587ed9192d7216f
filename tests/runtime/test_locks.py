from __future__ import annotations

import pickle
import threading
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from mol_compactons.runtime.locks import library_lock, open_netcdf


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


def test_a_thread_may_take_it_again_and_others_wait(tmp_path: Path) -> None:
    lock, taken = library_lock(), []
    thread = threading.Thread(target=lambda: taken.append(lock.acquire(False)))
    with lock, lock:
        assert lock.locked()
        thread.start()
        thread.join()
    assert taken == [False]
    assert not lock.locked()
    assert pickle.loads(pickle.dumps(lock)) is lock


def test_a_file_is_opened_under_it_and_reads_as_by_xarray(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    xr.Dataset({"a": ("x", np.arange(5.0))}, attrs={"title": "näh"}).to_netcdf(path, engine="netcdf4")
    with open_netcdf(path) as dataset, xr.open_dataset(path) as plain:
        xr.testing.assert_identical(dataset, plain)
        assert float(pickle.loads(pickle.dumps(dataset)).a.sum()) == 10
    with pytest.raises(OSError, match="No such file"):
        open_netcdf(tmp_path / "nothing.nc")


def test_it_is_free_again_after_an_error() -> None:
    for _ in range(2):
        try:
            with library_lock():
                raise ZeroDivisionError
        except ZeroDivisionError:
            continue
