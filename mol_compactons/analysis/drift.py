"""How well a run kept what the equation conserves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mol_compactons.results.reading import conserved_names

if TYPE_CHECKING:
    import xarray as xr


def drift(dataset: xr.Dataset) -> xr.Dataset:
    """The change of each conserved quantity since the first frame, relative to its first value where that is not zero.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.

    Returns
    -------
    xarray.Dataset
        One variable along t for each conserved quantity, nondimensional; its attribute `scale` is the value divided by.
    """
    series = dataset[conserved_names(dataset)].load()
    result = series.copy()
    for name in series.data_vars if dataset.sizes["t"] else ():
        values = series[name]
        first = abs(float(values[0]))
        scale = first if first > 1e-12 * float(np.abs(values).max()) and first > 1e-12 else 1.0
        result[name] = (values - values[0]) / scale
        result[name].attrs = {"long_name": f"relative drift of the {name}", "units": "1", "scale": scale}
    return result
