"""The chain beside its continuum."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from mol_compactons.analysis.chain_and_continuum import on_lattice

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def side_by_side(comparison: xr.Dataset, continuum: xr.Dataset, times: Sequence[float]) -> Figure:
    """The chain as dots on the lines of its continuum at some times, as in the paper's Figs 3 and 4, and their distance.

    Parameters
    ----------
    comparison : xarray.Dataset
        What `mol_compactons.compare` returns.
    continuum : xarray.Dataset
        The result of the continuum.
    times : sequence of float
        When.
    """
    from matplotlib.figure import Figure

    line = on_lattice(continuum, comparison.attrs["simulation"])
    figure = Figure(figsize=(9, 1.7 * len(times) + 2.2), layout="constrained")
    panels = figure.subplots(len(times) + 1, 1)
    for axes, t in zip(panels, times, strict=False):
        axes.plot(line.x, line.interp(t=t), color="#1f4e79", linewidth=1, label="continuum")
        axes.plot(comparison.k, comparison.R.sel(t=t, method="nearest"), "o", color="#c05020", markersize=3, label="chain")
        axes.set(ylabel="R", title=f"t = {t:g}", xlim=(comparison.k[0], comparison.k[-1]))
    panels[0].legend(frameon=False)
    panels[-2].set_xlabel("k")
    panels[-1].plot(comparison.t, comparison.distance, color="black", linewidth=1)
    panels[-1].set(xlabel="t", ylabel="relative L2 distance")
    return figure
