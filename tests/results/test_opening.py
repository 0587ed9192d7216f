from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from mol_compactons import Grid, InputError, open_result, open_study, run, write_tree
from mol_compactons.results.opening import status_of
from mol_compactons.results.running_file import RunningFile
from tests.results.test_recorder import SIZE, layout
from tests.systems import one_compacton


def test_a_result_is_opened_and_anything_else_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    run(one_compacton(), path).close()
    with open_result(path) as dataset:
        assert Grid(30, 150).spacing == pytest.approx(float(dataset.x[1] - dataset.x[0]))
        assert status_of(dataset, path) == "complete"
    (tmp_path / "text.nc").write_text("no NetCDF")
    xr.Dataset({"a": 1}).to_netcdf(tmp_path / "other.nc")
    for name, words in {
        "text.nc": "is not a NetCDF file that can be read",
        "other.nc": "has no attribute 'simulation', 'status', 'title'",
        "nothing.nc": "There is no file",
    }.items():
        with pytest.raises(InputError, match=words):
            open_result(tmp_path / name)
    with pytest.raises(InputError, match="is no convergence study"):
        open_study(path)


def test_who_runs_is_told_from_who_was_killed(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    file = RunningFile(path, layout())
    for index in range(4):
        file.append(np.zeros((2, SIZE)), np.array([[0.5 * index, 0.0, 0.0]]))
    file.sync()
    with xr.open_dataset(path) as dataset:
        assert status_of(dataset, path) == "running"
    file.close()
    with xr.open_dataset(path) as dataset:
        assert status_of(dataset, path) == "killed after t = 1.5"


def test_a_tree_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    write_tree(xr.Dataset({"a": 1}), path)
    with pytest.raises(TypeError):
        write_tree(xr.Dataset({"a": 1}, attrs={"bad": object()}), path)
    with xr.open_dataset(path) as dataset:
        assert int(dataset.a) == 1
    with pytest.raises(InputError, match="cannot be written: its folder is no longer there"):
        write_tree(xr.Dataset({"a": 1}), tmp_path / "gone" / "a.nc")
    assert list(tmp_path.iterdir()) == [path]
