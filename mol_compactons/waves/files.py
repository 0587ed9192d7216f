"""Reading initial data from CSV and NetCDF files."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import InputError, require
from mol_compactons.runtime.netcdf import open_netcdf

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]


def read_csv(path: Path) -> tuple[Array, Array]:
    """Places, shape (K,), and the columns after them, shape (columns - 1, K), of a file with or without a header.

    Raises
    ------
    InputError
        If the file does not exist, or a line is not as long as the first or holds what is no number.
    """
    require(path.is_file(), f"There is no file {path}; give a CSV file with the columns x, u.")
    try:
        lines = [line for line in csv.reader(path.read_text(encoding="utf-8-sig").splitlines()) if "".join(line).strip()]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path} cannot be read ({error}); give a CSV file with the columns x, u.") from None
    numbers: list[list[float]] = []
    for index, line in enumerate(lines):
        try:
            numbers.append([float(cell) for cell in line])
        except ValueError:
            if index:
                raise InputError(
                    f"Line {index + 1} of {path}, {', '.join(line)[:60]!r}, holds what is no number; correct it."
                ) from None
    widths = {len(line) for line in numbers}
    require(
        len(widths) == 1 and min(widths, default=0) >= 2,
        f"{path} must have the same columns in each line, x and u (and v) in numbers; it has {sorted(widths)} columns.",
    )
    table = np.array(numbers).T
    return table[0], table[1:]


def read_netcdf(path: Path, variable: str, t: float | None) -> tuple[Array, Array]:
    """Places, shape (K,), and fields, shape (components, K), of one frame of a NetCDF file.

    Parameters
    ----------
    path : Path
        The file.
    variable : str
        Which variable; empty for all fields of a result.
    t : float or None
        Which frame, the nearest; None for the last.

    Raises
    ------
    InputError
        If the file or the variable does not exist, or has no dimension in space.
    """
    require(path.is_file(), f"There is no file {path}; give a CSV or a NetCDF file.")
    try:
        dataset = open_netcdf(path)
    except (OSError, ValueError) as error:
        raise InputError(f"{path} is neither a CSV file (.csv) nor a NetCDF file that can be read ({error}).") from None
    with dataset:
        fields = [dataset[name] for name in _names(dataset, path, variable)]
        if "t" in fields[0].dims:
            require(fields[0].sizes["t"] > 0, f"{path} holds no frame; give a file that has one.")
            fields = [field.isel(t=-1) if t is None else field.sel(t=t, method="nearest") for field in fields]
        require(
            all(field.ndim == 1 and field.dims == fields[0].dims for field in fields),
            f"{path} must hold functions of one coordinate in space; {fields[0].name} has the dimensions {fields[0].dims}.",
        )
        places = fields[0][fields[0].dims[0]].values
        return np.asarray(places, dtype=float), np.array([field.values for field in fields], dtype=float)


def _names(dataset: xr.Dataset, path: Path, variable: str) -> list[str]:
    if variable:
        require(
            variable in dataset.data_vars,
            f"{path} has no variable {variable!r}; it has {', '.join(map(str, dataset.data_vars))}.",
        )
        return [variable]
    fields = [str(name) for name, one in dataset.data_vars.items() if one.attrs.get("role") == "field"]
    fields = fields or [str(name) for name, one in dataset.data_vars.items() if set(one.dims) - {"t"}]
    require(len(fields) > 0, f"{path} holds no function of a coordinate in space; name another file.")
    return fields
