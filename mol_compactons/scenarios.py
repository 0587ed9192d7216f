"""Finding and loading scenarios: a Python script that defines `simulation`, or a result, which carries its own."""

from __future__ import annotations

import ast
import runpy
import time
from pathlib import Path
from typing import TYPE_CHECKING

from mol_compactons.configuration import did_you_mean
from mol_compactons.errors import InputError, require
from mol_compactons.simulation import Simulation

if TYPE_CHECKING:
    import xarray as xr

OPENING_ATTEMPTS = 15
"""How often a result is tried that cannot be opened at once."""


def folder() -> Path:
    """Where the scenarios that come with the package are."""
    installed = Path(__file__).parent / "scenario_scripts"
    return installed if installed.is_dir() else Path(__file__).parent.parent / "scenarios"


def listing() -> dict[str, str]:
    """The scenarios that come with the package: name and first line of the docstring."""
    lines = {}
    for path in sorted(folder().glob("*.py")):
        docstring = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        lines[path.stem] = docstring.splitlines()[0] if docstring else ""
    return lines


def load(target: str) -> Simulation:
    """The simulation of a scenario script, of a scenario of the package by its name, or of a result.

    Parameters
    ----------
    target : str
        ``scenarios/two_bright.py``, ``two_bright`` or ``two_bright.nc``.

    Raises
    ------
    InputError
        If there is no such file, or it does not define a simulation.
    """
    path = Path(target)
    if path.suffix.lower() == ".nc":
        return from_result(path)
    if not path.is_file() and len(path.parts) == 1:
        path = folder() / f"{path.stem}.py"
    if not path.is_file():
        raise InputError(f"There is no scenario {target!r}; {did_you_mean(Path(target).stem, list(listing()))}")
    require(path.suffix == ".py", f"{path} is neither a script (.py) nor a result (.nc); give one of these.")
    try:
        simulation = runpy.run_path(str(path)).get("simulation")
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        raise InputError(f"{path} could not be run ({type(error).__name__}: {error}); correct the script.") from error
    if not isinstance(simulation, Simulation):
        raise InputError(f"{path} does not define a Simulation under the name 'simulation'; add one.")
    return simulation


def open_result(path: Path) -> xr.Dataset:
    """A result file, opened lazily; tried again for a while, since a run may be in the middle of writing it.

    Raises
    ------
    InputError
        If the file does not exist, cannot be read, or is no result of this program.
    """
    import xarray

    require(path.is_file(), f"There is no file {path}; give one that mol-compactons wrote.")
    for attempt in range(OPENING_ATTEMPTS):
        try:
            dataset = xarray.open_dataset(path, engine="netcdf4")
            break
        except (OSError, ValueError) as error:
            if attempt == OPENING_ATTEMPTS - 1 or not _is_hdf5(path):
                raise InputError(f"{path} is not a NetCDF file that can be read ({error}).") from None
        time.sleep(0.2)
    missing = [name for name in ("simulation", "status", "title") if name not in dataset.attrs]
    require(not missing, f"{path} is not a result of mol_compactons: it has no attribute {', '.join(map(repr, missing))}.")
    return dataset


def open_study(path: Path) -> xr.DataTree:
    """A study of `mol_compactons.convergence.converge` from its file, opened lazily.

    Raises
    ------
    InputError
        If the file does not exist, cannot be read, or is no study of this program.
    """
    import xarray

    with open_result(path) as root:
        require("family" in root.attrs, f"{path} is no convergence study; make one with mol-compactons converge.")
    return xarray.open_datatree(path, engine="netcdf4")


def _is_hdf5(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(4) == b"\x89HDF"


def from_result(path: Path) -> Simulation:
    """The simulation that a result file carries."""
    with open_result(path) as dataset:
        return Simulation.from_json(str(dataset.attrs["simulation"]))
