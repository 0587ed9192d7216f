"""Pictures of one result."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mol_compactons.analysis.drift import drift
from mol_compactons.results.reading import arranged, field_names, space_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PROFILES = 40
"""How many profiles a waterfall shows at most."""


def profiles(dataset: xr.Dataset, variable: str | None = None) -> xr.DataArray:
    """What pictures show of a result, along t and space: a component or, of a chain in displacements, its stresses.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    variable : str, optional
        Which component; by default the first one, and of displacements R_k = Q_(k-1) - Q_k.
    """
    dataset = arranged(dataset)
    name = variable or field_names(dataset)[0]
    return (-dataset[name].diff(space_of(dataset))).rename("R") if name == "Q" else dataset[name]


def waterfall(dataset: xr.Dataset, axes: Axes, variable: str | None = None) -> None:
    """Draw the profiles in space-time as in the paper's Figs 1 and 2: each is lifted by its time.

    Of a chain in displacements the stresses R_k = Q_(k-1) - Q_k are drawn.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    axes : matplotlib.axes.Axes
        Where to draw.
    variable : str, optional
        Which component; by default the first one.
    """
    field = profiles(dataset, variable)
    name, space = field.name, space_of(dataset)
    frames = field.isel(t=np.unique(np.linspace(0, dataset.sizes["t"] - 1, PROFILES).round().astype(int)))
    times, x = frames["t"].values, frames[space].values
    height = float(np.abs(frames.isel(t=0)).max()) or 1.0
    scale = 0.12 * max(float(times[-1] - times[0]), 1e-300) / height
    for order, (t, profile) in enumerate(zip(times, frames.values, strict=True)):
        base = np.full_like(x, t)
        curve = t + scale * profile
        axes.fill_between(x, base, np.maximum(base, curve), color="white", zorder=len(times) - order, linewidth=0)
        axes.plot(x, curve, color="#1f4e79", linewidth=0.8, zorder=len(times) - order)
    axes.set(xlim=(x[0], x[-1]), xlabel=str(space), ylabel="t", title=f"{name}(t, {space}), lifted by its time")


def drifts(dataset: xr.Dataset, axes: Axes) -> None:
    """Draw how the conserved quantities drift, on a logarithmic scale."""
    changes = drift(dataset)
    for name, change in changes.data_vars.items():
        axes.semilogy(changes["t"][1:], np.maximum(np.abs(change[1:]), 1e-17), label=str(name), linewidth=1)
    axes.set(xlabel="t", ylabel="|relative drift|", title="conserved quantities")
    if changes.data_vars:
        axes.legend(frameon=False)
    else:
        axes.text(0.5, 0.5, "nothing is conserved", ha="center", transform=axes.transAxes)


def overview(dataset: xr.Dataset) -> Figure:
    """The waterfall of a result beside the drift of what it should conserve.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.

    Returns
    -------
    matplotlib.figure.Figure
        Save it with ``overview(dataset).savefig("result.png")``.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 5.5), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(2, 1))
    waterfall(dataset, left)
    drifts(dataset, right)
    figure.suptitle(str(dataset.attrs.get("title", "")), fontsize="medium", wrap=True, parse_math=False)
    return figure
