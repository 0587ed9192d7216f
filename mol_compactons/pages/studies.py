"""The page of a convergence study: its verdicts, where their errors come from, and how its members approach their limit."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from mol_compactons.pages.document import Page, Picture, Section, Table
from mol_compactons.pages.plots import COLOURS, SYMBOLS, add_line, cleaned, figure, plain
from mol_compactons.pages.result import citation
from mol_compactons.results.form import settings_of
from mol_compactons.results.schema import COMPLETE
from mol_compactons.studies.judgement import BUDGET, CONVERGED, CONVERGING, NOT_CONVERGED
from mol_compactons.studies.report import differences_of_limits, headline, report, tables_of, verdict

if TYPE_CHECKING:
    import xarray as xr


def page_of_study(tree: xr.DataTree) -> Page:
    """The page of a study of `mol_compactons.converge`."""
    summary = tree["summary"].to_dataset()
    told = [headline(summary, str(limit)) for limit in summary["limit"].values]
    sections = [
        Section("verdicts", "Verdicts", differences_of_limits(summary), [], [Table(*one) for one in tables_of(tree)]),
        Section("budget", "Where the errors come from", [], list(_budgets(summary))),
        *_ladder(tree),
        Section("members", "Members", str(tree.attrs["failed"]).splitlines(), [], [_members(tree)]),
        _settings(tree),
        Section("words", "In words", code=str(report(tree))),
        Section("origin", "Origin and citation", [str(tree.attrs.get("source", "")), *citation(dict(tree.attrs))]),
    ]
    worst = [verdict(summary, str(limit)) for limit in summary["limit"].values]
    status = next(word for word in (NOT_CONVERGED, CONVERGING, CONVERGED) if word in worst)
    return Page(str(tree.attrs["title"]), status, told, sections)


def _budgets(summary: xr.Dataset) -> Iterator[Picture]:
    """For each limit the parts of each error, relative to its scale."""
    known = [part for part in BUDGET if part in summary]
    for number, limit in enumerate(summary["limit"].values):
        one = summary.sel(limit=limit)
        names = [plain(name) for name in one["quantity"].values]
        drawn = figure("part of the error / scale", "", log="x")
        for index, part in enumerate(["error", *known]):
            share = (one[part] / one["scale"]).values
            drawn.add_scatter(
                name="whole" if part == "error" else part,
                x=cleaned(np.where(share > 0, share, np.nan)),
                y=names,
                mode="markers",
                marker={
                    "symbol": "line-ns-open" if part == "error" else SYMBOLS[index % len(SYMBOLS)],
                    "size": 14 if part == "error" else 8,
                    "color": COLOURS[index % len(COLOURS)],
                },
            )
        drawn.update_layout(yaxis={"autorange": "reversed"})
        caption = f"The {limit} limit: the parts of the error of each quantity, relative to its scale."
        yield Picture(f"budget{number}", drawn, caption, height=26 * len(names) + 170)


def _ladder(tree: xr.DataTree) -> Iterator[Section]:
    """How the members approach what they tend to."""
    ladder = tree["ladder"].to_dataset()
    drawn, spacing = figure("h", "distance from the limit", log="xy"), ladder["spacing"].values
    choices: dict[str, list[int]] = {}
    for name in ladder["quantity"].values:
        lines = ladder["distance"].sel(quantity=name).stack(line=("limit", "scheme", "viscosity")).transpose("line", "size")
        shown = []
        for number, (line, values) in enumerate(zip(lines["line"].values, lines.values, strict=True)):
            if np.isfinite(values).any():
                shown.append(len(drawn.data))
                label = f"{line[0]}, {line[1]}, viscosity {line[2]:g}"
                first = not choices
                distances = np.where(values > 0, values, np.nan)
                add_line(drawn, label, spacing, distances, marks=True, number=number, visible=first)
                drawn.data[-1].name = plain(label).replace(", viscosity", "<br>viscosity")
        if shown:
            choices[str(name)] = shown
    if not choices:
        return
    drawn.update_layout(showlegend=True)
    caption = "The distance of each member from what its scheme and viscosity tend to, against the spacing of the grid."
    drawn.update_xaxes(tickvals=spacing.tolist(), ticktext=[f"{h:.3g}" for h in spacing], tickmode="array")
    height = 320 + 36 * max(map(len, choices.values()))
    picture = Picture("ladder-picture", drawn, caption, choices, height)
    yield Section("ladder", "How the members approach their limit", [], [picture])


def _members(tree: xr.DataTree) -> Table:
    rows = [
        [str(one.attrs["label"]), COMPLETE, f"{one.attrs['cpu_seconds']:.3g}" if "cpu_seconds" in one.attrs else "not known"]
        for one in tree["members"].children.values()
    ]
    return Table("What ran to its end", ["member", "status", "CPU time [s]"], rows)


def _settings(tree: xr.DataTree) -> Section:
    both: dict[str, Any] = {
        "simulation": settings_of(str(tree.attrs["simulation"])),
        "family": json.loads(str(tree.attrs["family"])),
    }
    return Section("settings", "Settings", ["What was varied, and of which simulation."], code=json.dumps(both, indent=1))
