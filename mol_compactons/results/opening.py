"""Opening results and studies, those of runs that go on or were killed among them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mol_compactons.errors import InputError, require
from mol_compactons.results.places import written_whole
from mol_compactons.results.recorder import in_one_row
from mol_compactons.results.running_file import is_claimed
from mol_compactons.runtime.netcdf import new_netcdf, open_netcdf

if TYPE_CHECKING:
    import xarray as xr


def open_result(path: str | Path) -> xr.Dataset:
    """A result file, opened lazily; that of a run which goes on may be read meanwhile.

    Parameters
    ----------
    path : str or Path
        That of the file.

    Raises
    ------
    InputError
        If the file does not exist, cannot be read, or is no result of this program.
    """
    path = Path(path)
    try:
        require(path.is_file(), f"There is no file {path}; give one that mol-compactons wrote.")
        dataset = in_one_row(open_netcdf(path))
    except InputError:
        raise
    except Exception as error:  # what the libraries raise for a damaged file has no end
        raise InputError(f"{path} is not a NetCDF file that can be read ({error}).") from None
    missing = [name for name in ("simulation", "status", "title") if name not in dataset.attrs]
    if missing:
        dataset.close()
    require(not missing, f"{path} is not a result of mol_compactons: it has no attribute {', '.join(map(repr, missing))}.")
    return dataset


def status_of(dataset: xr.Dataset, path: str | Path) -> str:
    """The status of a result, which says "running" also where its run was killed: then that, and the last time."""
    status = str(dataset.attrs["status"])
    if status != "running" or is_claimed(Path(path)):
        return status
    last = float(dataset["t"][-1]) if dataset.sizes["t"] else 0.0
    return f"killed after t = {last:.6g}"


def open_study(path: str | Path) -> xr.DataTree:
    """A study of `mol_compactons.converge` from its file, opened lazily.

    Parameters
    ----------
    path : str or Path
        That of the file.

    Raises
    ------
    InputError
        If the file does not exist, cannot be read, or is no study of this program.
    """
    import xarray

    with open_result(path) as root:
        require("family" in root.attrs, f"{path} is no convergence study; make one with mol-compactons converge.")
    return xarray.open_datatree(path, engine="h5netcdf")


def write_tree(tree: xr.DataTree | xr.Dataset, path: str | Path) -> None:
    """Write a tree, or a Dataset, into a NetCDF file, whole or not at all.

    Parameters
    ----------
    tree : xarray.DataTree or xarray.Dataset
        What is written.
    path : str or Path
        The file; one that exists is replaced.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    import xarray
    from xarray.backends import H5NetCDFStore

    nodes = (
        {node.path: node.to_dataset(inherit=False) for node in tree.subtree}
        if isinstance(tree, xarray.DataTree)
        else {"/": tree}
    )
    with written_whole(Path(path)) as part, new_netcdf(part) as file:
        for place, dataset in nodes.items():
            dataset.dump_to_store(H5NetCDFStore(file if place == "/" else file.create_group(place)))
