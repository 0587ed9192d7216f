"""Pictures of one result."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.drift import drift
from mol_compactons.figures.style import LINE
from mol_compactons.results.reading import arranged, field_names, space_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PROFILES = 40
"""How many profiles a waterfall shows at most."""

LIFT = 0.12
"""The height of the first profile in a waterfall, relative to the time shown."""

DEEPEST_GAP = 0.5
"""How far below zero a stress is shown, relative to the largest one."""


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
    name, space = str(field.name), space_of(dataset)
    frames = field.isel(t=np.unique(np.linspace(0, dataset.sizes["t"] - 1, PROFILES).round().astype(int)))
    times, x, values = frames["t"].values, frames[space].values, shown(frames)
    height = float(np.abs(values[0]).max()) or float(np.abs(values).max()) or 1.0
    scale = LIFT * max(float(times[-1] - times[0]), 1e-300) / height
    curves = times[:, None] + scale * values
    bottom, top = float(curves.min()), float(curves.max())
    # What is nearer hides what is behind: seen from above, or from below where the waves point down.
    below = float(-values.min()) > float(values.max())
    for order, curve in enumerate(curves):
        nearness = order if below else len(times) - order
        axes.fill_between(x, curve, top if below else bottom, color="white", zorder=nearness, linewidth=0)
        axes.plot(x, curve, color=LINE, linewidth=0.8, zorder=nearness)
    room = 0.02 * (top - bottom or 1.0)
    axes.set(xlim=(x[0], x[-1]), ylim=(bottom - room, top + room), xlabel=space, ylabel="t")
    axes.set_title(f"{name}(t, {space}), lifted by its time")
    axes.set_yticks([tick for tick in axes.get_yticks() if times[0] <= tick <= times[-1]])
    _amplitude_bar(axes, name, height, scale, float(times[0]))


def _amplitude_bar(axes: Axes, name: str, height: float, scale: float, start: float) -> None:
    """A bar beside the axes as long as a round height of the profiles."""
    unit = 10.0 ** math.floor(math.log10(height))
    amount = next(factor * unit for factor in (5, 2, 1) if factor * unit <= height * (1 + 1e-9))
    across = axes.get_yaxis_transform()
    axes.plot([1.015, 1.015], [start, start + scale * amount], color="black", linewidth=2, transform=across, clip_on=False)
    axes.text(1.03, start + scale * amount / 2, f"{amount:g}", transform=across, va="center", fontsize=8)


def shown(field: xr.DataArray) -> NDArray[np.float64]:
    """The values that pictures show: a gap between grains, which has no stress and may be wide, is cut off.

    Parameters
    ----------
    field : xarray.DataArray
        What `profiles` returns.
    """
    values = np.asarray(field.values, dtype=float)
    high = float(np.nanmax(values)) if values.size else 0.0
    return np.maximum(values, -DEEPEST_GAP * high) if field.name == "R" and high > 0 else values


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
