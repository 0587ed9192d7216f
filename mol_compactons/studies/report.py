"""A convergence study in words: a table for each limit, the worst verdict on each, and where the limits differ."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from mol_compactons.notebook import html_of_tables
from mol_compactons.results.schema import COMPLETE
from mol_compactons.studies.judgement import BUDGET, CONVERGED, CONVERGING, NOT_CONVERGED

if TYPE_CHECKING:
    import xarray as xr


UNKNOWN = ("unbounded", "not known")
"""What is said for infinity and for NaN."""


class Report(list[str]):
    """What a study says, a line each; printed as lines, and in a notebook as tables.

    Parameters
    ----------
    lines : sequence of str
        The lines.
    tree : xarray.DataTree
        The study.
    """

    def __init__(self, lines: Sequence[str], tree: xr.DataTree) -> None:
        super().__init__(lines)
        self._tree = tree

    def __str__(self) -> str:
        return "\n".join(self)

    def _repr_html_(self) -> str:
        """What a notebook shows: for each limit the values, their errors, and the verdicts with their reasons."""
        differences = differences_of_limits(self._tree["summary"].to_dataset())
        return html_of_tables(tables_of(self._tree), [*differences, *_side_by_side(self._tree), *_failures(self._tree)])


def tables_of(tree: xr.DataTree) -> list[tuple[str, list[str], list[list[str]]]]:
    """For each limit of a study its headline, and the headings and rows of a table of its quantities."""
    summary = tree["summary"].to_dataset()
    headings = ["quantity", "value", "error", "error / scale", "rate", "verdict", "reason"]
    names = summary["quantity"].values
    return [
        (headline(summary, str(limit)), headings, [_cells(summary.sel(limit=limit, quantity=name)) for name in names])
        for limit in summary["limit"].values
    ]


def _cells(row: xr.Dataset) -> list[str]:
    value, error, scale, rate = (float(row[name]) for name in ("value", "error", "scale", "rate"))
    numbers = [(value, ".6g"), (error, ".1e"), (error / scale, ".1e"), (rate, ".2f")]
    told = [f"{number:{form}}" if math.isfinite(number) else UNKNOWN[math.isnan(number)] for number, form in numbers]
    return [str(row["quantity"].item()), *told, str(row["verdict"].item()), str(row["reason"].item())]


def report(tree: xr.DataTree) -> Report:
    """What a study says, a line each: a table for each limit, where the limits differ, and the members that failed.

    Parameters
    ----------
    tree : xarray.DataTree
        What `converge` returned, or its file.
    """
    summary = tree["summary"].to_dataset()
    lines: list[str] = []
    # A study stored before the budget had a part does not know it.
    known = [part for part in BUDGET if part in summary]
    titles = " + ".join(f"{part:>9}" for part in known)
    for limit in summary["limit"].values:
        table = summary.sel(limit=limit)
        lines.append(headline(summary, str(limit)))
        lines.append(f"  {'quantity':18} {'value':>12} {'error':>9} = {titles}   rate  error / scale, verdict")
        for name in table["quantity"].values:
            row = table.sel(quantity=name)
            parts = " + ".join(f"{float(row[part]):9.1e}" for part in known)
            lines.append(
                f"  {name:18} {float(row['value']):12.6g} {float(row['error']):9.1e} = {parts} {float(row['rate']):6.2f}  "
                f"{float(row['error'] / row['scale']):.1e} {row['verdict'].item()}: {row['reason'].item()}"
            )
    lines += differences_of_limits(summary)
    return Report([*lines, *_side_by_side(tree), *_failures(tree)], tree)


def _side_by_side(tree: xr.DataTree) -> list[str]:
    return side_by_side(tree["schemes"].to_dataset()) if "schemes" in tree.children else []


def _failures(tree: xr.DataTree) -> list[str]:
    return [f"failed and not counted: {line}" for line in str(tree.attrs["failed"]).splitlines()]


def side_by_side(table: xr.Dataset) -> list[str]:
    """The schemes of a study on its finest grid, a line each; none if there is a single one."""
    if table.sizes["scheme"] < 2:
        return []
    table = table.squeeze("n") if "n" in table.dims else table
    finest = table.isel(size=-1)
    lines = [f"schemes on {int(finest['size'])} points; errors against {finest['reference'].item()}:"]
    for scheme in finest["scheme"].values:
        own = finest.sel(scheme=scheme)
        if own["status"].item() == COMPLETE:
            drifts = [f"{name} {float(one):.1e}" for name, one in own.data_vars.items() if str(name).endswith("_drift")]
            lines.append(
                f"  {scheme}: error {float(own['error']):.1e}, order {float(own['fitted_order']):.2f}, "
                f"{float(own['cpu_seconds']):.3g} s; {', '.join(drifts).replace('_', ' ')}"
            )
        else:
            lines.append(f"  {scheme}: {own['status'].item()}")
    return lines


def headline(summary: xr.Dataset, limit: str) -> str:
    """The worst verdict on any quantity in a limit, and how many members failed."""
    failed = int(summary["failed"].sel(limit=limit)) if "failed" in summary else 0
    members = f"; {failed} of {int(summary['members'].sel(limit=limit))} members failed" if failed else ""
    return f"{limit} limit: {verdict(summary, limit)}{members}"


def verdict(summary: xr.Dataset, limit: str) -> str:
    """The worst verdict on any quantity in a limit."""
    verdicts = set(summary["verdict"].sel(limit=limit).values.tolist())
    return next(word for word in (NOT_CONVERGED, CONVERGING, CONVERGED) if word in verdicts)


def differences_of_limits(summary: xr.Dataset) -> list[str]:
    """What differs between the first two limits of a summary by more than twice the error bars, a line each."""
    if summary.sizes["limit"] < 2:
        return []
    lines = []
    for name in summary["quantity"].values:
        pair = summary.sel(quantity=name)
        apart = abs(float(pair["value"][0] - pair["value"][1]))
        bars = float(pair["error"].sum())
        if apart > 2 * bars and name != "profile":
            first, second = pair["limit"].values[:2]
            lines.append(
                f"{name}: the {first} and the {second} limit differ by {apart:.2g}, and their error bars add up to {bars:.1g}"
            )
    return lines
