from __future__ import annotations

from pathlib import Path
from typing import Any

import dask.array
import numpy as np
import pytest
import xarray as xr

from mol_compactons import InputError, run
from mol_compactons.studies.opening import open_sweep
from mol_compactons.studies.sweep import sweep
from tests.studies.sweeps import BAD_SIZE, small


def test_members_of_one_layout_are_one_lazy_dataset(tmp_path: Path) -> None:
    speeds, centers = [1.0, 0.5, 0.25], [9, 10]
    sweep(small(), {"initial.0.speed": speeds, "initial.0.center": centers}, tmp_path / "sweep", tracked=False)
    whole = open_sweep(tmp_path / "sweep")
    assert isinstance(whole, xr.Dataset)
    assert dict(whole.W.sizes) == {"speed": 3, "center": 2, "t": 3, "x": 60}
    assert isinstance(whole.W.data, dask.array.Array)
    assert whole.W.data.numblocks == (3, 2, 1, 1)
    heights = whole.W.isel(t=0).max("x").compute()
    assert (heights.diff("speed") < 0).all()
    one = run(small())
    np.testing.assert_array_equal(whole.W.sel(speed=1, center=10).values, one.W.values)
    np.testing.assert_array_equal(whole.mass.sel(speed=1, center=10).values, one.mass.values)
    assert whole.W.attrs["units"] == one.W.attrs["units"]
    assert (whole.status == "complete").all()


def test_members_whose_grids_differ_are_a_tree(tmp_path: Path) -> None:
    varied: dict[str, list[Any]] = {"grid.size": [60, 80, BAD_SIZE], "initial.0.speed": [1, 0.5]}
    table = sweep(small(), varied, tmp_path / "sweep", tracked=False)
    tree = open_sweep(tmp_path / "sweep")
    assert isinstance(tree, xr.DataTree)
    assert set(tree.children) == {"size=60", "size=80", f"size={BAD_SIZE}"}
    assert dict(tree["size=80"].W.sizes) == {"speed": 2, "t": 3, "x": 80}
    np.testing.assert_array_equal(tree["size=80"].W.sel(speed=1).values, run(small(80)).W.values)
    assert "W" not in tree[f"size={BAD_SIZE}"].data_vars
    xr.testing.assert_equal(tree.to_dataset(), table)


def test_members_that_failed_are_nan(tmp_path: Path) -> None:
    sweep(small(), {"initial.0.speed": [1, -1]}, tmp_path / "sweep", tracked=False)
    whole = open_sweep(tmp_path / "sweep")
    assert np.isfinite(whole.W.sel(speed=1).values).all()
    assert np.isnan(whole.W.sel(speed=-1).values).all()


def test_what_is_no_sweep_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no study"):
        open_sweep(tmp_path)
