"""Pictures of studies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import require
from mol_compactons.figures.style import told_apart

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def convergence_overview(tree: xr.DataTree) -> Figure:
    """For each quantity of a study the distance of each member from its limit for h -> 0, against h.

    Pale lines have the slopes 1, 2 and 4, broken ones without marks are the error bars of the limits.

    Parameters
    ----------
    tree : xarray.DataTree
        What `mol_compactons.converge` returns.
    """
    from matplotlib.figure import Figure

    ladder, summary = tree["ladder"].to_dataset(), tree["summary"].to_dataset()
    quantities = ladder["quantity"].values
    rows = -(-quantities.size // 4)
    figure = Figure(figsize=(14, 2.8 * rows + 0.8), layout="constrained")
    panels = figure.subplots(rows, 4, squeeze=False).ravel()
    for axes, quantity in zip(panels, quantities, strict=False):
        _ladder_panel(ladder.sel(quantity=quantity), summary.sel(quantity=quantity), axes)
    for axes in panels[quantities.size :]:
        axes.axis("off")
    for axes in panels[::4]:
        axes.set_ylabel("relative distance from the limit", fontsize=8)
    handles = {label: handle for axes in panels for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=2, frameon=False, fontsize=8)
    figure.suptitle(str(tree.attrs["title"]), fontsize="medium", wrap=True, parse_math=False)
    return figure


def _ladder_panel(ladder: xr.Dataset, summary: xr.Dataset, axes: Axes) -> None:
    spacing = ladder["spacing"].values
    lines = ladder["distance"].stack(line=("limit", "scheme", "viscosity")).transpose("line", "size")
    known = np.isfinite(lines.values).any(axis=1)
    for number, (line, values) in enumerate(zip(lines["line"].values[known], lines.values[known], strict=True)):
        label = f"{line[0]}, {line[1]}, viscosity {line[2]:g}"
        axes.loglog(spacing, np.where(values > 0, values, np.nan), label=label, **told_apart(number))
    for name, dash in zip(summary["limit"].values, (":", "--", "-."), strict=False):
        bar = float((summary["error"] / summary["scale"]).sel(limit=name))
        if np.isfinite(bar) and bar > 0:
            axes.axhline(bar, color="grey", linestyle=dash, linewidth=0.8, label=f"error bar of the limit, {name}")
    _guides(spacing, lines.values, axes)
    verdicts = ", ".join(str(word) for word in summary["verdict"].values)
    axes.set_title(f"{ladder['quantity'].item()}: {verdicts}", fontsize=9)
    axes.set_xlabel("h", fontsize=8)
    axes.set_xticks(spacing, [f"{h:.3g}" for h in spacing])
    axes.minorticks_off()
    axes.tick_params(which="both", labelsize=7)


def _guides(spacing: NDArray[np.float64], values: NDArray[np.float64], axes: Axes) -> None:
    """The slopes 1, 2 and 4, which leave the heights of the axes to what is measured."""
    measured = values[np.isfinite(values) & (values > 0)]
    if not measured.size:
        axes.text(0.5, 0.5, "no distance is known", ha="center", transform=axes.transAxes, fontsize=8)
    bars = [float(np.asarray(line.get_ydata())[0]) for line in axes.lines if line.get_color() == "grey"]
    seen = [*measured.tolist(), *bars] or [1.0]
    for slope in (1, 2, 4) if measured.size else ():
        axes.loglog(spacing, measured.max() * (spacing / spacing.max()) ** slope, color="lightgrey", linewidth=0.6, zorder=0)
    axes.set(xscale="log", yscale="log", ylim=(0.5 * min(seen), 2 * max(seen)))
    axes.set_xlim(0.9 * spacing.min(), 1.1 * spacing.max())


def schemes_overview(table: xr.Dataset) -> Figure:
    """Discretisations beside each other: error against the number of points, error against CPU time, and drift.

    Parameters
    ----------
    table : xarray.Dataset
        What `mol_compactons.studies.compare_schemes` returns, or several along ``problem``; a row for each problem and n.
    """
    from matplotlib.figure import Figure

    rows = _rows_of(table)
    conserved = [str(name) for name in table.data_vars if str(name).endswith("_drift") and bool((table[name] > 0).any())]
    first = sorted(conserved, key=lambda name: name != "momentum_drift")[:1]
    figure = Figure(figsize=(8 + 4 * len(first), 3.1 * len(rows) + 0.9), layout="constrained")
    panels = figure.subplots(len(rows), 2 + len(first), squeeze=False)
    for (title, row), (errors, costs, *drifts) in zip(rows, panels, strict=True):
        _error_panel(row, errors)
        _scheme_lines(row["cpu_seconds"], row["error"], costs)
        labels = [(errors, "points", "error"), (costs, "CPU time [s]", "error")]
        for axes, name in zip(drifts, first, strict=True):
            _scheme_lines(row["size"], row[name], axes)
            labels.append((axes, "points", name.replace("_", " ")))
        for axes, across, up in labels:
            axes.set(xlabel=across, ylabel=up)
            axes.set_title(title, fontsize=9)
            axes.tick_params(which="both", labelsize=8)
    lines, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    figure.suptitle(str(table.attrs.get("title", "")), fontsize="medium", wrap=True, parse_math=False)
    return figure


def _rows_of(table: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    """The parts of a comparison that have one panel each, with their titles, without grids on which nothing ran."""
    others = [str(name) for name in table["error"].dims if name not in ("scheme", "size")]
    parts = [table] if not others else [part for _, part in table.stack(row=others).groupby("row", squeeze=False)]
    rows = []
    for part in parts:
        one = part.squeeze("row") if others else part
        told = [f"{one[name].item():g}" if name != "problem" else one[name].item() for name in others]
        title = ", ".join(
            value if name == "problem" else f"{name} = {value}" for name, value in zip(others, told, strict=True)
        )
        row = one.dropna("size", how="all", subset=["error"])
        if row.sizes["size"]:
            rows.append((title, row))
    require(bool(rows), "No member of the study has an error that is known, so that there is nothing to draw.")
    return rows


def _scheme_lines(across: xr.DataArray, up: xr.DataArray, axes: Axes) -> None:
    """A line for each scheme; what is zero has no place on a logarithmic axis."""
    for number, scheme in enumerate(up["scheme"].values):
        x: Any = across.sel(scheme=scheme) if "scheme" in across.dims else across
        y = up.sel(scheme=scheme).values
        axes.loglog(x.values, np.where(y > 0, y, np.nan), label=str(scheme), **told_apart(number))
    if "scheme" not in across.dims:
        axes.set_xticks(across.values, [f"{value:g}" for value in across.values])
        axes.minorticks_off()


def scheme_errors(table: xr.Dataset) -> Figure:
    """The errors of discretisations alone: a row for each problem, a column for each n.

    Parameters
    ----------
    table : xarray.Dataset
        As for `schemes_overview`, along ``problem`` and ``n``.
    """
    from matplotlib.figure import Figure

    rows = _rows_of(table)
    across = table.sizes["n"]
    figure = Figure(figsize=(3.6 * across, 3 * -(-len(rows) // across) + 0.8), layout="constrained")
    panels = figure.subplots(-(-len(rows) // across), across, squeeze=False).ravel()
    for (title, row), axes in zip(rows, panels, strict=False):
        _error_panel(row, axes)
        axes.set_title(title, fontsize=9)
        axes.tick_params(which="both", labelsize=8)
    for axes in panels[::across]:
        axes.set_ylabel("relative L2 error")
    for axes in panels[-across:]:
        axes.set_xlabel("points")
    lines, labels = panels[0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside lower center", ncols=4, frameon=False, fontsize=8)
    return figure


def _error_panel(row: xr.Dataset, axes: Axes) -> None:
    """The error of each scheme against the number of points."""
    _slopes(row, axes)
    _scheme_lines(row["size"], row["error"], axes)
    positive = row["error"].where(row["error"] > 0)
    if not bool(positive.notnull().any()):
        return
    limits = 0.5 * float(positive.min()), 2 * float(positive.max())
    axes.set_ylim(limits)
    if float(row["reference_error"]) > limits[0]:
        axes.axhspan(limits[0], float(row["reference_error"]), color="0.93", zorder=0)


def _slopes(row: xr.Dataset, axes: Axes) -> None:
    """The slopes of the orders 2, 4 and 6."""
    sizes = row["size"].values
    for order in (2, 4, 6) if float(row["error"].max()) > 0 else ():
        slope = float(row["error"].max()) * (sizes[0] / sizes) ** float(order)
        axes.loglog(sizes, slope, color="lightgrey", linewidth=0.7, zorder=0)
