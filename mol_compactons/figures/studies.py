"""Pictures of studies."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def convergence_overview(tree: xr.DataTree) -> Figure:
    """For each quantity of a study the distance of each member from its limit for h -> 0, against h.

    Solid lines have the slopes 1, 2 and 4, broken ones are the error bars of the limits.

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
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False, fontsize=8)
    figure.suptitle(str(tree.attrs["title"]), fontsize="medium", wrap=True, parse_math=False)
    return figure


def _ladder_panel(ladder: xr.Dataset, summary: xr.Dataset, axes: Axes) -> None:
    spacing = ladder["spacing"].values
    lines = ladder["distance"].stack(line=("limit", "scheme", "viscosity")).transpose("line", "size")
    known = np.isfinite(lines.values).any(axis=1)
    for color, (line, values) in enumerate(zip(lines["line"].values[known], lines.values[known], strict=True)):
        label = f"{line[0]}, {line[1]}, viscosity {line[2]:g}"
        axes.loglog(
            spacing, np.where(values > 0, values, np.nan), "o-", color=f"C{color % 10}", markersize=3, linewidth=1, label=label
        )
    for name, marker in zip(summary["limit"].values, (":", "--", "-."), strict=False):
        bar = float((summary["error"] / summary["scale"]).sel(limit=name))
        if np.isfinite(bar) and bar > 0:
            axes.axhline(bar, color="grey", linestyle=marker, linewidth=0.8)
    top = np.nanmax(lines.values) if known.any() else 1.0
    for slope in (1, 2, 4):
        axes.loglog(spacing, max(top, 1e-16) * (spacing / spacing.max()) ** slope, color="lightgrey", linewidth=0.6, zorder=0)
    verdicts = ", ".join(str(word) for word in summary["verdict"].values)
    axes.set_title(f"{ladder['quantity'].item()}: {verdicts}", fontsize=9)
    axes.set_xlabel("h", fontsize=8)
    axes.set_xticks(spacing, [f"{h:.3g}" for h in spacing])
    axes.minorticks_off()
    axes.tick_params(labelsize=7)
