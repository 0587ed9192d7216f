"""The page of a sweep: its quantities along what was varied, its members, and why some failed."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from mol_compactons.figures.sweeps import spans_decades
from mol_compactons.pages.document import Page, Picture, Section, Table
from mol_compactons.pages.plots import add_line, cleaned, figure, plain
from mol_compactons.pages.result import citation
from mol_compactons.results.schema import COMPLETE

if TYPE_CHECKING:
    import xarray as xr

MOST_ROWS = 500
"""How many members a page lists."""

MOST_LINES = 12
"""How many lines of one quantity are drawn."""

FEWEST_FOR_A_MAP = 3
"""How many values two varied fields need for a map."""


def page_of_sweep(table: xr.Dataset, plan: Mapping[str, Any]) -> Page:
    """The page of a sweep.

    Parameters
    ----------
    table : xarray.Dataset
        What `mol_compactons.sweep` returns, or what there is of it so far.
    plan : mapping
        Its plan.
    """
    statuses = Counter(map(str, table["status"].values.ravel()))
    reasons = Counter(filter(None, map(str, table["reason"].values.ravel())))
    told = f"{table['status'].size} members: {', '.join(f'{count} {status}' for status, count in sorted(statuses.items()))}"
    failures = [[str(count), reason] for reason, count in reasons.most_common()]
    reasons_of = Table("Reasons", ["times", "reason"], failures)
    sections = [
        Section("quantities", "What came out", [], [*_lines(table), *_maps(table)]),
        *([Section("failures", "Why members failed", [], [], [reasons_of])] if failures else []),
        _members(table),
        Section("plan", "Plan", ["What was varied, and of which simulation."], code=json.dumps(dict(plan), indent=1)),
        Section(
            "origin",
            "Origin and citation",
            [str(table.attrs.get("source", "The source is not stated.")), *citation(dict(table.attrs))],
        ),
    ]
    done = set(statuses) == {COMPLETE}
    varied = ", ".join(path for axis in plan["axes"] for path in axis["fields"])
    of_what = str(plan["simulation"].get("title") or plan["simulation"]["equation"]["type"])
    title = f"Sweep over {varied}: {of_what}"
    return Page(title, COMPLETE if done else "not all members are complete", [told], sections)


def _numbers(table: xr.Dataset) -> list[str]:
    """The quantities that are known of any member."""
    return [str(name) for name, one in table.data_vars.items() if one.dtype.kind == "f" and bool(one.notnull().any())]


def _lines(table: xr.Dataset) -> Iterator[Picture]:
    """Each quantity along the first axis, a line for each member of the other axes and each wave."""
    first = str(table["status"].dims[0])
    along = table[first].values if first in table.coords else np.arange(table.sizes[first])
    numeric = np.asarray(along).dtype.kind in "fiu"
    log = numeric and spans_decades(along)
    drawn = figure(str(table[first].attrs.get("field", first)) if first in table.coords else first, "", log="x" if log else "")
    choices: dict[str, list[int]] = {}
    for name in _numbers(table):
        others = [str(dimension) for dimension in table[name].dims if dimension != first]
        quantity = table[name].stack(line=others) if others else table[name].expand_dims("line", 1)
        values = quantity.transpose(first, "line").values
        known = [index for index in range(values.shape[1]) if np.isfinite(values[:, index]).any()][:MOST_LINES]
        shown = []
        for number, index in enumerate(known):
            shown.append(len(drawn.data))
            place = np.atleast_1d(np.asarray(quantity["line"].values[index], dtype=object)) if others else ()
            label = ", ".join(f"{other} {_told(value)}" for other, value in zip(others, place, strict=True)) or name
            add_line(drawn, label, along, values[:, index], marks=True, number=number, visible=not choices)
        choices[str(table[name].attrs.get("long_name", name))] = shown
    if choices:
        drawn.update_layout(showlegend=True)
        yield Picture("lines", drawn, f"One quantity of all members against {first}; which, the list above chooses.", choices)


def _maps(table: xr.Dataset) -> Iterator[Picture]:
    """Each quantity over two varied fields, where both have several values."""
    names = [str(name) for name in table["status"].dims]
    if len(names) != 2 or min(table.sizes[name] for name in names) < FEWEST_FOR_A_MAP:
        return
    labels = [str(table[name].attrs.get("field", name)) if name in table.coords else name for name in names]
    drawn = figure(labels[0], labels[1])
    drawn.update_layout(xaxis={"type": "category"}, yaxis={"type": "category"})
    choices: dict[str, list[int]] = {}
    places = [table[name].values if name in table.coords else np.arange(table.sizes[name]) for name in names]
    words = [[plain(_told(value)) for value in one.tolist()] for one in places]
    hover = f"{plain(labels[0])} = %{{{{x}}}}<br>{plain(labels[1])} = %{{{{y}}}}<br>{{}} = %{{{{z:.5g}}}}<extra></extra>"
    for name in [one for one in _numbers(table) if table[one].ndim == 2]:
        values = table[name].transpose(*names[::-1]).values
        choices[str(table[name].attrs.get("long_name", name))] = [len(drawn.data)]
        drawn.add_heatmap(
            x=words[0],
            y=words[1],
            z=[cleaned(row) for row in values],
            colorscale="Cividis",
            colorbar={"thickness": 12, "exponentformat": "power"},
            visible=len(choices) == 1,
            hovertemplate=hover.format(plain(name)),
        )
    if choices:
        yield Picture("maps", drawn, f"One quantity of all members over {labels[0]} and {labels[1]}.", choices)


def _members(table: xr.Dataset) -> Section:
    """The members, a row each."""
    dimensions = [str(name) for name in table["status"].dims]
    along = [str(name) for name in table.coords if set(table[name].dims) <= set(dimensions) and table[name].ndim == 1]
    numbers = [name for name in _numbers(table) if list(table[name].dims) == dimensions]
    rows = []
    for index in list(np.ndindex(*table["status"].shape))[:MOST_ROWS]:
        one = table.isel(dict(zip(dimensions, index, strict=True)))
        rows.append([*(_told(one[name].item()) for name in (*along, "status", "reason", *numbers))])
    count = table["status"].size
    said = [f"The first {MOST_ROWS} of {count}; all are in table.nc of the folder."] if count > MOST_ROWS else []
    headings = [*along, "status", "reason", *(name.replace("_", " ") for name in numbers)]
    return Section(
        "members", "Members", said, [], [Table("All members" if not said else "Members", headings, rows, sortable=True)]
    )


def _told(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.5g}" if np.isfinite(value) else ""
    return str(value)
