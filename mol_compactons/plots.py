"""Pictures of results."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mol_compactons.dataset import field_names
from mol_compactons.invariants import drift

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PROFILES = 40
"""How many profiles a waterfall shows at most."""


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
    name = variable or field_names(dataset)[0]
    space = dataset[name].dims[1]
    field = dataset[name]
    if name == "Q":
        name, field = "R", -field.diff(space)
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
    axes.legend(frameon=False)


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
    figure.suptitle(str(dataset.attrs.get("title", "")))
    return figure


def side_by_side(comparison: xr.Dataset, continuum: xr.Dataset, times: Sequence[float]) -> Figure:
    """The chain as dots on the lines of its continuum at some times, as in the paper's Figs 3 and 4, and their distance.

    Parameters
    ----------
    comparison : xarray.Dataset
        What `mol_compactons.compare.compare` returns.
    continuum : xarray.Dataset
        The result of the continuum.
    times : sequence of float
        When.
    """
    from matplotlib.figure import Figure

    from mol_compactons.compare import on_lattice

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


def stability_overview(dataset: xr.Dataset) -> Figure:
    """The functional of the scaling test beside the lowest eigenvalues of the second variation at each resolution.

    Parameters
    ----------
    dataset : xarray.Dataset
        What `mol_compactons.stability.report` returns.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(dataset["factor"], dataset["functional"], color="#1f4e79")
    left.axvline(1, color="grey", linewidth=0.5)
    left.set(xlabel="lambda", ylabel="Lambda(lambda)", title="the paper's scaling test")
    for name, style in (("free", "o-"), ("constrained", "s--")):
        for mode in dataset["mode"].values:
            values = dataset["eigenvalue"].sel(constraint=name, mode=mode)
            label = f"{name} perturbations" if mode == 0 else None
            right.plot(values["resolution"], values, style, color="#1f4e79" if name == "free" else "#c05020", label=label)
    right.axhline(0, color="grey", linewidth=0.5)
    right.set(xscale="log", xlabel="points in the support", ylabel="eigenvalue", title="second variation")
    right.legend(frameon=False)
    figure.suptitle(str(dataset.attrs["title"]))
    return figure


def convergence_overview(tree: xr.DataTree) -> Figure:
    """For each quantity of a study the distance of each member from its limit for h -> 0, against h.

    Solid lines have the slopes 1, 2 and 4, broken ones are the error bars of the limits.

    Parameters
    ----------
    tree : xarray.DataTree
        What `mol_compactons.convergence.converge` returns.
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
    figure.suptitle(str(tree.attrs["title"]))
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
