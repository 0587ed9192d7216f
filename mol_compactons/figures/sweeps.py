"""Pictures of sweeps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mol_compactons.figures.style import told_apart

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_LINES = 12
"""How many lines a panel shows."""

COLUMNS = 4

ALIKE = 30.0
"""Values all positive whose largest is more than so many times the smallest are drawn by their logarithms."""


def sweep_overview(table: xr.Dataset) -> Figure:
    """A panel for each quantity of a sweep: against the first axis, a line for each member of the other axes and each wave.

    Parameters
    ----------
    table : xarray.Dataset
        What `mol_compactons.sweep` returns.
    """
    from matplotlib.figure import Figure

    names = [name for name, one in table.data_vars.items() if one.dtype.kind == "f" and bool(one.notnull().any())]
    rows = -(-max(len(names), 1) // COLUMNS)
    figure = Figure(figsize=(14, 2.8 * rows + 0.8), layout="constrained")
    panels = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
    for axes, name in zip(panels, names, strict=False):
        sweep_panel(table[name], axes)
    for axes in panels[len(names) :]:
        axes.axis("off")
    handles = {label: handle for axes in panels for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    if handles:
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4, frameon=False, fontsize=8)
    figure.suptitle(str(table.attrs.get("title", "")), fontsize="medium", wrap=True, parse_math=False)
    return figure


def sweep_panel(quantity: xr.DataArray, axes: Axes) -> None:
    """One quantity of a sweep against its first axis.

    Parameters
    ----------
    quantity : xarray.DataArray
        A variable of the table.
    axes : matplotlib.axes.Axes
        Where to draw.
    """
    first = str(quantity.dims[0])
    quantity = quantity.squeeze([name for name in quantity.dims[1:] if quantity.sizes[name] == 1], drop=True)
    along, numeric = _places(quantity, first)
    others = (
        quantity.stack(line=quantity.dims[1:]).transpose(first, "line")
        if quantity.ndim > 1
        else quantity.expand_dims("line", 1)
    )
    known = [index for index in range(others.sizes["line"]) if np.isfinite(others.values[:, index]).any()]
    for number, index in enumerate(known[:MOST_LINES]):
        label = _label(others, index, quantity.dims[1:])
        axes.plot(along, others.values[:, index], label=label, **told_apart(number))
    if numeric and spans_decades(along):
        axes.set_xscale("log")
    if not numeric:
        axes.set_xticks(along, [str(value) for value in quantity[first].values], rotation=20)
    if spans_decades(others.values):
        axes.set_yscale("log")
    units = str(quantity.attrs.get("units", "1"))
    title = str(quantity.attrs.get("long_name", quantity.name)) + ("" if units == "1" else f" [{units}]")
    axes.set_title(title, fontsize=9, parse_math=False)
    axes.set_xlabel(str(quantity.coords[first].attrs.get("field", first)) if first in quantity.coords else first, fontsize=8)
    axes.tick_params(which="both", labelsize=7)


def _places(quantity: xr.DataArray, first: str) -> tuple[Any, bool]:
    """Where the members stand along an axis, and whether these are numbers."""
    numeric = first in quantity.coords and quantity[first].dtype.kind in "fiu"
    return (quantity[first].values if numeric else np.arange(quantity.sizes[first])), numeric or first not in quantity.coords


def spans_decades(values: Any) -> bool:
    """Whether values are all positive, and the largest far above the smallest; what is no number is left out."""
    finite = np.asarray(values, dtype=float)[np.isfinite(values)]
    return bool(finite.size and finite.min() > 0 and finite.max() > ALIKE * finite.min())


def _label(lines: xr.DataArray, index: int, dimensions: tuple[Any, ...]) -> str | None:
    """What tells a line from the others."""
    if not dimensions:
        return None
    values = np.atleast_1d(np.asarray(lines["line"].values[index], dtype=object))
    told = [f"{value:.4g}" if isinstance(value, float | np.floating) else str(value) for value in values]
    return ", ".join(f"{name} {value}" for name, value in zip(dimensions, told, strict=False))
