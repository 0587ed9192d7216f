"""How well a run kept what the equation conserves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.results.reading import conserved_along_t
from mol_compactons.semidiscrete import drift_scale

if TYPE_CHECKING:
    import xarray as xr


def drift(dataset: xr.Dataset) -> xr.Dataset:
    """The change of each conserved quantity since the first frame, relative to what it is.

    That is the size of its first value or, where parts of that cancel, as the mass of a bright and a dark wave, the sum of the
    sizes of these parts; in results that do not know it, the largest size on the way.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.

    Returns
    -------
    xarray.Dataset
        One variable along t for each conserved quantity, as often as it was recorded, nondimensional; its attribute `scale` is
        the value divided by, and `relative_to` says which that is. Where all is zero, so is the drift.
    """
    series = conserved_along_t(dataset)
    result = series.copy()
    for name in series.data_vars if dataset.sizes["t"] else ():
        values = series[name]
        scale, meaning = scale_of(values.values, values.attrs.get("magnitude"))
        result[name] = (values - values[0]) / (scale or 1.0)
        result[name].attrs = {
            "long_name": f"drift of the {name}, relative to {meaning}",
            "units": "1",
            "scale": scale,
            "relative_to": meaning,
        }
    return result


def largest_drifts(dataset: xr.Dataset) -> dict[str, float]:
    """The largest size of the drift of each conserved quantity of a result; NaN where the quantity is NaN at a time."""
    series = conserved_along_t(dataset)
    return {str(name): largest_drift(one.values, one.attrs.get("magnitude")) for name, one in series.data_vars.items()}


def largest_drift(values: NDArray[np.float64], magnitude: float | None) -> float:
    """The largest size of the drift of one quantity; parameters as for `scale_of`."""
    return float(np.abs(values - values[0]).max() / (scale_of(values, magnitude)[0] or 1.0))


def scale_of(values: NDArray[np.float64], magnitude: float | None) -> tuple[float, str]:
    """What the drift of a quantity is relative to, and that in words; 0 where there is nothing but zeros.

    Parameters
    ----------
    values : array, shape (times,)
        The quantity.
    magnitude : float or None
        The sum of the sizes of the parts of its first value, where that is known.
    """
    first, largest = abs(float(values[0])), float(np.abs(values).max())
    if drift_scale(first, largest if magnitude is None else float(magnitude)) == first and first > 0:
        return first, "its first value"
    if magnitude is not None and magnitude > 0:
        return float(magnitude), "the sum of the sizes of its parts"
    return largest, "its largest value"
