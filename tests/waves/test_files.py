from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import InputError, run
from mol_compactons.waves.files import read_csv, read_netcdf
from tests.systems import one_compacton

numbers = st.floats(allow_nan=False, allow_infinity=False)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("files")


@given(st.lists(st.tuples(numbers, numbers, numbers), min_size=1, max_size=6), st.booleans(), st.sampled_from(["\n", "\r\n"]))
def test_numbers_are_read_to_the_last_bit(
    folder: Path, rows: list[tuple[float, float, float]], header: bool, newline: str
) -> None:
    lines = [", ".join(map(repr, row)) for row in rows]
    path = folder / "table.csv"
    path.write_bytes(newline.join(["x, u, v", *lines] if header else lines).encode())
    places, values = read_csv(path)
    assert places.tolist() == [row[0] for row in rows]
    assert values.T.tolist() == [list(row[1:]) for row in rows]


def test_empty_lines_and_the_mark_of_a_spreadsheet_do_not_count(tmp_path: Path) -> None:
    path = tmp_path / "marked.csv"
    path.write_text("\n0,1\n\n,\n1,2\n", encoding="utf-8-sig")
    places, values = read_csv(path)
    assert (places.tolist(), values.tolist()) == ([0.0, 1.0], [[1.0, 2.0]])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"0,1\nx,u\n", "Line 2 of .*table.csv, 'x, u', holds what is no number; correct it"),
        (b"0\n1\n", r"must have the same columns in each line, .*; it has \[1\] columns"),
        (b"x,u\n", r"it has \[\] columns"),
        (b"\xff\xfe0,1", "cannot be read"),
    ],
)
def test_a_table_that_is_none_is_named(content: bytes, words: str, tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_bytes(content)
    with pytest.raises(InputError, match=words):
        read_csv(path)


def test_fields_of_a_result_are_known_by_their_role(tmp_path: Path) -> None:
    path = tmp_path / "result.nc"
    dataset = run(one_compacton(), path).load()
    places, values = read_netcdf(path, "", None)
    assert np.array_equal(places, dataset.x.values)
    assert np.array_equal(values, dataset.W.values[-1:])
    assert np.array_equal(read_netcdf(path, "W", 0.4)[1], dataset.W.sel(t=0.5).values[None])


def test_of_other_files_what_depends_on_space_is_read(tmp_path: Path) -> None:
    path = tmp_path / "foreign.nc"
    xr.Dataset({"depth": ("s", [1.0, 2.0, 3.0]), "count": ("t", [1.0])}, {"s": [0.0, 0.5, 1.0]}).to_netcdf(path)
    places, values = read_netcdf(path, "", None)
    assert (places.tolist(), values.tolist()) == ([0.0, 0.5, 1.0], [[1.0, 2.0, 3.0]])


@pytest.mark.parametrize(
    ("variables", "variable", "words"),
    [
        ({"u": ("x", [1.0])}, "v", "has no variable 'v'; it has u"),
        ({"u": 1.0}, "", "holds no function of a coordinate in space"),
        ({"u": (("x", "y"), [[1.0]])}, "", r"must hold functions of one coordinate in space; u has the dimensions"),
        ({"u": (("t", "x"), np.empty((0, 3)))}, "", "holds no frame"),
    ],
)
def test_a_file_without_a_function_of_space_is_named(variables: object, variable: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "file.nc"
    xr.Dataset(variables).to_netcdf(path)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=words):
        read_netcdf(path, variable, None)


def test_what_is_no_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"There is no file .*none\.csv; give a CSV file with the columns x, u"):
        read_csv(tmp_path / "none.csv")
    with pytest.raises(InputError, match="There is no file"):
        read_csv(tmp_path)
    with pytest.raises(InputError, match="There is no file"):
        read_netcdf(tmp_path / "none.nc", "", None)
    (tmp_path / "text.nc").write_text("text")
    with pytest.raises(InputError, match="is neither a CSV file"):
        read_netcdf(tmp_path / "text.nc", "", None)
