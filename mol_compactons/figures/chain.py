"""The chain beside its continuum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from mol_compactons.analysis.chain_and_continuum import on_lattice

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


COLOURS, MARKERS = ("#c05020", "#407030", "#705090"), "ox+"
"""Of one chain after the other."""


def side_by_side(comparison: xr.Dataset | Mapping[str, xr.Dataset], continuum: xr.Dataset, times: Sequence[float]) -> Figure:
    """The chain as dots on the lines of its continuum at some times, as in the paper's Figs 3 and 4, and their distance.

    Parameters
    ----------
    comparison : xarray.Dataset, or mapping of str to these
        What `mol_compactons.compare` returns; of up to three chains beside one continuum, by what they are called.
    continuum : xarray.Dataset
        The result of the continuum.
    times : sequence of float
        When.
    """
    import xarray as xr
    from matplotlib.figure import Figure

    chains = {"chain": comparison} if isinstance(comparison, xr.Dataset) else comparison
    first = next(iter(chains.values()))
    line = on_lattice(continuum, first.attrs["simulation"])
    figure = Figure(figsize=(9, 1.7 * len(times) + 2.2), layout="constrained")
    panels = figure.subplots(len(times) + 1, 1)
    for axes, t in zip(panels, times, strict=False):
        chain_beside_continuum(chains, line, t, axes)
    for chain, colour in zip(chains.values(), COLOURS, strict=False):
        panels[-1].plot(chain.t, chain.distance, color="black" if len(chains) == 1 else colour, linewidth=1)
    panels[0].legend(frameon=False)
    panels[-2].set_xlabel("k")
    panels[-1].set(xlabel="t", ylabel="relative\nL2 distance")
    return figure


def chain_beside_continuum(chains: Mapping[str, xr.Dataset], line: xr.DataArray, t: float, axes: Axes) -> None:
    """Chains as marks on the line of their continuum at one time.

    Parameters
    ----------
    chains : mapping of str to xarray.Dataset
        What `mol_compactons.compare` returns, by what they are called.
    line : xarray.DataArray
        The continuum in sites, along t and x, from `mol_compactons.analysis.chain_and_continuum.on_lattice`.
    t : float
        When.
    axes : matplotlib.axes.Axes
        Where to draw.
    """
    axes.plot(line.x, line.interp(t=t), color="#1f4e79", linewidth=1, label="continuum")
    for (label, chain), colour, marker in zip(chains.items(), COLOURS, MARKERS, strict=False):
        axes.plot(chain.k, chain.R.sel(t=t, method="nearest"), marker, color=colour, markersize=3, label=label)
    first = next(iter(chains.values()))
    axes.set(ylabel="R", title=f"t = {t:g}", xlim=(first.k[0], first.k[-1]))
