"""Pictures of one result."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.drift import drift
from mol_compactons.chain.chain import GranularChain
from mol_compactons.errors import InputError
from mol_compactons.figures.style import DASHES, LINE
from mol_compactons.results.reading import arranged, field_names, space_of
from mol_compactons.simulation import Simulation

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PROFILES = 40
"""How many profiles a waterfall shows at most."""

LIFT = 0.12
"""The height of the first profile in a waterfall, relative to the time shown."""

FAR = 0.1
"""A wave whose values are all beyond this, relative to the largest, stays far from zero."""

LEAST_DRIFT = 1e-17
"""No smaller drift is shown, so that none at all has a place on a logarithmic scale."""

DEEPEST_GAP = 0.5
"""How far below zero a stress is shown, relative to the largest one."""


GAPS = "negative_is_a_gap"
"""The attribute of a stress of which what is negative is the width of a gap."""


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
    field = (-dataset[name].diff(space_of(dataset))).rename("R") if name == "Q" else dataset[name]
    return field.assign_attrs({GAPS: True}) if field.name == "R" and _parts(dataset) else field


def _parts(dataset: xr.Dataset) -> bool:
    """Whether grains that have moved apart feel no force, so that a negative stress is a gap and no wave."""
    try:
        equation = Simulation.from_json(str(dataset.attrs.get("simulation", ""))).equation
    except InputError:
        return False
    apart = np.array([-1.0])
    return isinstance(equation, GranularChain) and not equation.law.force(apart, np.ones(1)).any()


def evenly(count: int, most: int) -> NDArray[np.intp]:
    """The places of at most so many of some things, evenly spread, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, max(most, 2))).round().astype(np.intp))


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
    frames = field.isel(t=evenly(dataset.sizes["t"], PROFILES))
    times, x, values = frames["t"].values, frames[space].values, shown(frames)
    base = _base(values)
    values = values - base
    height = float(np.abs(values[0]).max()) or float(np.abs(values).max()) or 1.0
    scale = LIFT * max(float(times[-1] - times[0]), 1e-300) / height
    curves = times[:, None] + scale * values
    bottom, top = float(curves.min()), float(curves.max())
    # What is nearer hides what is behind: seen from above, or from below where the waves point down.
    below = float(-values.min()) > float(values.max())
    for order, curve in enumerate(curves):
        # Below 1, so that the frame of the axes is in front of what hides.
        nearness = (order if below else len(times) - order) / (len(times) + 1)
        axes.fill_between(x, curve, top if below else bottom, color="white", zorder=nearness, linewidth=0)
        axes.plot(x, curve, color=LINE, linewidth=0.8, zorder=nearness)
    room = 0.02 * (top - bottom or 1.0)
    raised = f"{name} - {base:.3g}".replace("- -", "+ ") if base else ""
    axes.set(xlim=(x[0], x[-1]), ylim=(bottom - room, top + room), xlabel=space, ylabel=f"t, and {raised}" if base else "t")
    axes.set_title(f"{raised or f'{name}(t, {space})'}, lifted by its time")
    axes.set_yticks([tick for tick in axes.get_yticks() if times[0] <= tick <= times[-1]])
    _amplitude_bar(axes, name, height, scale, float(times[0]))


def _base(values: NDArray[np.float64]) -> float:
    """What is taken from the values of a wave that stays far from zero, so that its profiles begin at their times."""
    nearest = float(values.min() if values.min() > 0 else values.max())
    far = values.min() * values.max() > 0 and abs(nearest) > FAR * float(np.abs(values).max()) and np.ptp(values) > 0
    return nearest if far else 0.0


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
    return np.maximum(values, -DEEPEST_GAP * high) if field.attrs.get(GAPS) and high > 0 else values


def label_of(field: xr.DataArray) -> str:
    """The name of what is shown, and where it is cut off."""
    lowest = float(shown(field).min()) if field.size else 0.0
    return f"{field.name}, cut off at {lowest:.2g}" if field.size and lowest > float(field.min()) else str(field.name)


def drifts(dataset: xr.Dataset, axes: Axes) -> None:
    """Draw how the conserved quantities drift, on a logarithmic scale.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    axes : matplotlib.axes.Axes
        Where to draw.
    """
    changes = drift(dataset)
    for (name, change), dash in zip(changes.data_vars.items(), itertools.cycle(DASHES), strict=False):
        axes.semilogy(changes["t"][1:], np.maximum(np.abs(change[1:]), LEAST_DRIFT), dash, label=str(name), linewidth=1)
    axes.set(xlabel="t", ylabel="|relative drift|", title="conserved quantities")
    if changes.data_vars:
        axes.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=3)
    else:
        axes.text(0.5, 0.5, "nothing is conserved", ha="center", transform=axes.transAxes)
        axes.set(xlabel="", ylabel="", title="", xticks=[], yticks=[])


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
