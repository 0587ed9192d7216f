"""Candidates for a work item measured at matched error, in tables, as CSV and as pictures."""

from __future__ import annotations

import csv
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons import Simulation

Array = NDArray[np.float64]

REPEATS = 3


@dataclass
class Candidate:
    """Something that solves a work item: its settings from loose to tight, and how to run with one of them."""

    name: str
    ours: bool
    settings: Sequence[Any]
    solve: Callable[[Any], tuple[Array, str]]
    repeats: int = REPEATS


@dataclass
class Row:
    """One line of a table."""

    name: str
    setting: str
    seconds: float
    error: float
    counts: str
    ours: bool


def measured(candidate: Candidate, setting: Any, exact: Array) -> Row:
    """One run."""
    started = time.process_time()
    final, counts = candidate.solve(setting)
    seconds = time.process_time() - started
    error = float(np.linalg.norm(final - exact) / np.linalg.norm(exact))
    return Row(candidate.name, described(setting), seconds, error, counts, candidate.ours)


def described(setting: Any) -> str:
    """A setting in few words."""
    if isinstance(setting, Simulation):
        return setting.title
    return f"rtol {setting.rtol:g}" if hasattr(setting, "rtol") else f"{setting:g}"


def compare(
    title: str, candidates: Sequence[Candidate], exact: Array, most: float, folder: Path, beyond: int = 0
) -> list[Row]:
    """Find for each candidate the loosest setting that is accurate enough, repeat those in turns, and print the table.

    The quick ones go on with some settings beyond that one, for a picture.
    """
    tried: list[Row] = []
    rows: dict[str, Row] = {}
    chosen: list[tuple[Candidate, Any]] = []
    for candidate in candidates:
        accurate: list[tuple[Any, Row]] = []
        others: list[Row] = []
        for setting in candidate.settings:
            if len(accurate) > (beyond if candidate.repeats > 1 else 0):
                break
            try:
                row = min((measured(candidate, setting, exact) for _ in range(candidate.repeats)), key=lambda row: row.seconds)
            except Exception as failure:
                print(f"  {candidate.name} at {setting}: {type(failure).__name__}: {failure}", file=sys.stderr)
                continue
            print(f"  {row.name} at {row.setting}: {row.seconds:.2f} s, {row.error:.1e}", file=sys.stderr, flush=True)
            if row.error <= most:
                accurate.append((setting, row))
            else:
                others.append(row)
        tried += [*others, *(row for _, row in accurate)]
        if accurate:
            setting, rows[candidate.name] = accurate[0]
            if candidate.repeats > 1:
                chosen.append((candidate, setting))
        elif others:
            best = min(others, key=lambda row: row.error)
            rows[candidate.name] = replace(best, setting=f"{best.setting}: not reached")
    for _ in range(REPEATS):
        for candidate, setting in chosen:
            row = measured(candidate, setting, exact)
            rows[candidate.name] = min(row, rows[candidate.name], key=lambda row: row.seconds)
    show(f"{title}, error at most {most:g}", list(rows.values()), folder)
    return tried


def show(title: str, rows: Sequence[Row], folder: Path) -> None:
    """Print a table in Markdown, and write it as CSV."""
    best = min((row.seconds for row in rows if row.ours), default=np.nan)
    sundials = min((row.seconds for row in rows if row.ours and ("IDA" in row.name or "CVODE" in row.name)), default=np.nan)
    print(f"\n{title}\n\n| solver | setting | CPU s | / fastest of ours | / ours by SUNDIALS | error | counts |")
    print("|---|---|---|---|---|---|---|")
    for row in sorted(rows, key=lambda row: row.seconds):
        by_sundials = f"{row.seconds / sundials:.1f}" if sundials > 0 else "-"
        print(
            f"| {row.name} | {row.setting} | {row.seconds:.3f} | {row.seconds / best:.1f} | {by_sundials} | "
            f"{row.error:.1e} | {row.counts} |",
            flush=True,
        )
    write(rows, folder / f"{title.split(':')[0]}.csv")


def write(rows: Sequence[Row], path: Path) -> None:
    """What was measured, as CSV."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["solver", "setting", "cpu_seconds", "relative_l2_error", "counts"])
        writer.writerows([row.name, row.setting, row.seconds, row.error, row.counts] for row in rows)


def picture(rows: Sequence[Row], title: str, path: Path) -> None:
    """Error against processor time, a line for each name; what is drawn goes into a CSV file beside it."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    figure = Figure(figsize=(7, 5), layout="constrained")
    axes = figure.subplots()
    for name in dict.fromkeys(row.name for row in rows):
        own = sorted((row.seconds, row.error) for row in rows if row.name == name)
        axes.loglog(*zip(*own, strict=True), "o-" if name.startswith("ours") else "s--", label=name, markersize=4)
    axes.set(xlabel="CPU seconds", ylabel="relative L2 error", title=title)
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=110)
    write(rows, path.with_name(f"{path.stem}_points.csv"))
