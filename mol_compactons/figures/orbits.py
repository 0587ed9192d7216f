"""Pictures of the orbit of a wave."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def orbit_overview(dataset: xr.Dataset) -> Figure:
    """The Floquet multipliers about the unit circle, beside the wave and the mode of the largest.

    Parameters
    ----------
    dataset : xarray.Dataset
        What `mol_compactons.analysis.wave_orbits.orbit` returns.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    angle = np.linspace(0, 2 * np.pi, 361)
    left.plot(np.cos(angle), np.sin(angle), color="grey", linewidth=0.5)
    left.plot(dataset["multiplier_real"], dataset["multiplier_imag"], ".", color="#1f4e79", markersize=4)
    left.set(aspect="equal", xlabel=r"Re $\mu$", ylabel=r"Im $\mu$", title=f"multipliers: {dataset.attrs['verdict']}")
    left.locator_params(nbins=5)
    name = str(dataset["component"].values[0])
    wave, mode = dataset[name], dataset["mode_real"].isel(shown=0, component=0)
    space = str(wave.dims[0])
    scaled = mode * float(abs(wave).max()) / (float(abs(mode).max()) or 1.0)
    right.plot(dataset[space], wave, color="#1f4e79", label=name)
    right.plot(dataset[space], scaled, color="#c05020", linewidth=0.7, linestyle="--", label="mode of the largest")
    right.set(xlabel=space, title=rf"the wave and the mode of $|\mu|$ = {float(dataset['modulus'][0]):.6g}")
    figure.legend(*right.get_legend_handles_labels(), loc="outside lower right", ncols=2, frameon=False)
    figure.suptitle(str(dataset.attrs["title"]), fontsize="medium", parse_math=False)
    return figure
