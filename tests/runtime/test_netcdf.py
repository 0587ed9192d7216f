from __future__ import annotations

import pickle
import subprocess
import sys
from dataclasses import replace
from io import FileIO
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mol_compactons import run
from mol_compactons.runtime import netcdf as runtime_netcdf
from mol_compactons.runtime.netcdf import _Target, new_netcdf, open_netcdf
from tests.systems import one_compacton

FORMATS: dict[str, tuple[str, str]] = {
    "scipy": ("netcdf4", "NETCDF3_64BIT"),
    "scipy, small": ("netcdf4", "NETCDF3_CLASSIC"),
    "h5netcdf": ("netcdf4", "NETCDF4"),
    "h5netcdf, its own": ("h5netcdf", "NETCDF4"),
}


@pytest.mark.parametrize(("engine", "form"), FORMATS.values(), ids=FORMATS)
def test_every_format_reads_as_by_xarray(engine: Any, form: Any, tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    xr.Dataset({"a": ("x", np.arange(5.0))}, attrs={"title": "näh"}).to_netcdf(path, engine=engine, format=form)
    with open_netcdf(path) as dataset, xr.open_dataset(path) as plain:
        xr.testing.assert_identical(dataset, plain)
        assert float(pickle.loads(pickle.dumps(dataset)).a.sum()) == 10


def test_a_format_of_others_is_read_too(tmp_path: Path) -> None:
    import netCDF4

    with netCDF4.Dataset(tmp_path / "a.nc", "w", format="NETCDF3_64BIT_DATA") as file:
        file.createDimension("x", 3)
        file.createVariable("a", "f8", ("x",))[:] = [1, 2, 4]
    assert open_netcdf(tmp_path / "a.nc").a.values.tolist() == [1, 2, 4]


def test_what_is_not_there_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No such file"):
        open_netcdf(tmp_path / "nothing.nc")
    for form in ("NETCDF3_64BIT", "NETCDF4"):
        xr.Dataset({"a": ("x", np.arange(5.0))}).to_netcdf(tmp_path / "a.nc", format=form)
        with pytest.raises(OSError, match=r"group"):
            open_netcdf(tmp_path / "a.nc", group="nothing")


PROGRAM = """
import sys
from dataclasses import replace
from io import FileIO
from itertools import count
from pathlib import Path
from mol_compactons import open_result, run
from tests.systems import one_compacton
path = Path(sys.argv[1])
run(one_compacton(t_end=0.3, frames=4), path).load()
open_result(path).load()
run(one_compacton(t_end=0.6, frames=7), path, resume=True).load()
print("netCDF4" in sys.modules)
"""


def test_a_run_and_its_reading_never_call_netcdf4(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM, str(tmp_path / "a.nc")], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_texts_are_the_characters_that_every_reader_of_netcdf_knows(tmp_path: Path) -> None:
    import netCDF4

    run(replace(one_compacton(t_end=0.3, frames=4), title="näh"), tmp_path / "a.nc").close()
    with netCDF4.Dataset(tmp_path / "a.nc") as file:
        assert file.title.startswith("näh: ")
        assert (file["t"].units, file["W"].units, file.solver_first_warning) == ("1", "1", "")
        assert np.isnan(file["W"]._FillValue)
    with xr.open_dataset(tmp_path / "a.nc") as plain, xr.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as other:
        xr.testing.assert_identical(plain, other)
        assert plain.encoding["unlimited_dims"] == {"t"}


@pytest.mark.parametrize("fault", [OSError(28, "No space left on device"), KeyboardInterrupt(), MemoryError()], ids=repr)
@pytest.mark.parametrize("at", [1, 7, 40])
def test_what_fails_in_a_write_is_raised_at_the_end(
    fault: BaseException, at: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It goes through a library in C that knows no exceptions."""
    calls = count(1)

    class Failing(FileIO):
        def write(self, content: Any) -> int:
            if next(calls) == at:
                raise fault
            return super().write(content)

    def replaced(self: _Target, path: Path) -> None:
        begin(self, path)
        self._file.close()
        self._file = Failing(path, "rb+")

    begin = _Target.__init__
    monkeypatch.setattr(_Target, "__init__", replaced)

    def write_much() -> None:
        with new_netcdf(tmp_path / "a.nc") as file:
            file.dimensions = {"x": 50_000}
            for number in range(40):
                file.create_variable(f"v{number}", ("x",), data=np.arange(50_000.0))

    with pytest.raises(type(fault)):
        write_much()
    assert next(calls) > at


def test_a_damaged_file_is_an_error_of_one_kind(tmp_path: Path) -> None:
    chance = np.random.default_rng(0)
    for form in ("NETCDF3_64BIT", "NETCDF4"):
        xr.Dataset({"a": ("x", np.arange(5.0))}, attrs={"title": "a"}).to_netcdf(tmp_path / "a.nc", format=form)
        whole = (tmp_path / "a.nc").read_bytes()
        damaged, refused = tmp_path / "b.nc", 0
        for _ in range(60):
            content = bytearray(whole)
            for place in chance.integers(4, len(content), len(content) // 100):
                content[place] ^= int(chance.integers(1, 256))
            damaged.write_bytes(content)
            try:
                open_netcdf(damaged).close()
            except OSError:
                refused += 1
        assert refused > 5


def test_a_file_that_is_replaced_by_one_of_another_format_while_it_is_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by a run that ends just then."""
    path, final = tmp_path / "a.nc", tmp_path / "final.nc"
    xr.Dataset({"a": ("x", np.arange(3.0))}).to_netcdf(path, format="NETCDF3_64BIT")
    xr.Dataset({"a": ("x", np.arange(5.0))}).to_netcdf(final, format="NETCDF4")
    looked = runtime_netcdf._engine_of

    def look_and_replace(path: Path) -> str | None:
        engine = looked(path)
        if final.exists():
            final.replace(path)
        return engine

    monkeypatch.setattr(runtime_netcdf, "_engine_of", look_and_replace)
    with open_netcdf(path) as dataset:
        assert dataset.a.values.tolist() == [0, 1, 2, 3, 4]
