"""Pictures of a stability report."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def stability_overview(dataset: xr.Dataset) -> Figure:
    """The functional of the scaling test beside the lowest eigenvalues of the second variation at each resolution.

    Parameters
    ----------
    dataset : xarray.Dataset
        What `mol_compactons.analysis.stability.report` returns.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(dataset["factor"], dataset["functional"], color="#1f4e79")
    left.axvline(1, color="grey", linewidth=0.5)
    left.set(xlabel=r"$\lambda$", ylabel=r"$\Lambda(\lambda)$", title="the paper's scaling test")
    for name, style in (("free", "o-"), ("constrained", "s--")):
        for mode in dataset["mode"].values:
            values = dataset["eigenvalue"].sel(constraint=name, mode=mode)
            label = f"{name} perturbations" if mode == 0 else None
            right.plot(values["resolution"], values, style, color="#1f4e79" if name == "free" else "#c05020", label=label)
    right.axhline(0, color="grey", linewidth=0.5)
    right.set(xscale="log", xlabel="points in the support", ylabel="eigenvalue", title="second variation")
    right.set_xticks(dataset["resolution"].values, [f"{size:g}" for size in dataset["resolution"].values])
    right.minorticks_off()
    figure.legend(*right.get_legend_handles_labels(), loc="outside lower right", ncols=2, frameon=False)
    figure.suptitle(str(dataset.attrs["title"]), parse_math=False)
    return figure
