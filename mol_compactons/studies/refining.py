"""Adaptive refinement: where, between two values of a field, the outcome of a simulation changes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mol_compactons.assignment import Importer, hint_at, import_nothing
from mol_compactons.configuration import alternatives, encode
from mol_compactons.errors import require, shown
from mol_compactons.results.opening import write_tree
from mol_compactons.results.schema import COMPLETE
from mol_compactons.runtime.signals import stopping_on_signals
from mol_compactons.simulation import Simulation
from mol_compactons.studies.criterion import Criterion
from mol_compactons.studies.engine import Engine, Here
from mol_compactons.studies.members import Quantity
from mol_compactons.studies.plan import product
from mol_compactons.studies.store import LOST, Row, Store
from mol_compactons.studies.sweep import TABLE, Tell, attributes_of, run_missing, tasks_of, tell_nobody, telling
from mol_compactons.studies.table import REFINED, laid_out, table

if TYPE_CHECKING:
    import xarray as xr

UNFINISHED = "unfinished"
"""The attribute of a table that says why a refinement ended before the accuracy was reached."""

MOST_VALUES = 1000
"""The largest number of values that a refinement tries."""

WIDE = 2.0
"""Two positive values whose ratio is larger are divided by their logarithms."""


def refine(
    simulation: Simulation,
    path: str,
    values: Sequence[float],
    folder: str | Path,
    *,
    outcome: str | Criterion = "status",
    accuracy: float = 0.01,
    parts: int = 2,
    engine: Engine | None = None,
    quantities: Mapping[str, Quantity] | None = None,
    tracked: bool = True,
    importing: Importer = import_nothing,
    tell: Tell = tell_nobody,
    progress: bool | None = None,
) -> xr.Dataset:
    """Find where, between values of a field, the outcome of a simulation changes.

    The values are tried; between two neighbours whose outcome differs the interval is divided, until it is short enough. So
    every change of the outcome between two values that were tried is found, and none that lies hidden between two with one
    outcome. The same call again goes on.

    Parameters
    ----------
    simulation : Simulation
        What is varied.
    path : str
        A field with numbers, by its path as in ``--set``; of one with whole numbers the neighbours are found.
    values : sequence of float
        Two or more, growing.
    folder : str or Path
        Where the results go, as for `sweep`.
    outcome : str or Criterion
        "status", whether the run is complete, or a quantity of the table and a number, as "momentum_drift > 0.01" and
        "height_after[1] < 0.9", which is that of wave 1.
    accuracy : float
        How long an interval may be in which the outcome changes, relative to the larger of the sizes of its ends; with zero in
        it, relative to the range of the values.
    parts : int
        Into how many parts an interval is divided at once; more keep more processes busy, and need more members.
    engine, quantities, tracked, tell, progress
        As for `sweep`.
    importing : callable, optional
        As for `Plan`.

    Returns
    -------
    xarray.Dataset
        The table as of `sweep` along the values that were tried, growing, with ``outcome``: "complete", "failed" or "stopped",
        or "yes" and "no"; "unknown" where a member does not have the quantity. It changes between neighbours that are close;
        if it does so in too many places, the attribute ``unfinished`` says that some are not.

    Raises
    ------
    InputError
        If a value is out of range, members do not have the quantity, or as for `sweep`.
    """
    asked = outcome if isinstance(outcome, Criterion) else Criterion.from_text(outcome)
    require(1e-12 <= accuracy < 1, f"accuracy = {accuracy:g} must lie between 1e-12 and 1.")
    require(2 <= parts <= 100, f"parts = {parts} must lie between 2 and 100.")
    tried = _checked(values, _kind_of(simulation, path), path)
    own = dict(quantities or {})
    first = product(simulation, {path: tried}, importing)
    refined = {"field": path, "name": first.short(path), "values": tried, "accuracy": accuracy, "parts": parts}
    described = {
        REFINED: refined | {"criterion": asdict(asked)},
        "simulation": first.described()["simulation"],
        "quantities": sorted(own),
        "tracked": tracked,
    }
    store = Store(Path(folder), described)
    try:
        with telling(tell, progress) as told, stopping_on_signals(lambda t: None) as report:
            more, full = tried, False
            while more and not full:
                tried = sorted({*tried, *more})
                plan = product(simulation, {path: tried}, importing)
                tasks = tasks_of(plan, store, own, tracked)
                run_missing(store, tasks, engine or Here(), lambda: report(0.0), told, failed_too=False)
                rows = store.rows()
                _check_rows([rows[task.name] for task in tasks], asked)
                more = _parts_of(tried, [asked.of(rows[task.name]) for task in tasks], refined)
                full = len(tried) + len(more) > MOST_VALUES
    finally:
        rows = store.rows()
        store.close()
    result = table(*laid_out(described, rows.values())).assign_attrs(attributes_of(plan, rows))
    if full:
        result.attrs[UNFINISHED] = f"ended at {len(tried)} values, before the accuracy was reached: {MOST_VALUES} are allowed"
    write_tree(result, Path(folder) / TABLE)
    return result


def _kind_of(simulation: Simulation, path: str) -> type[int] | type[float]:
    """Whether a field has whole numbers or any; raises `InputError` if it has none, or does not exist."""
    kinds = alternatives(hint_at(Simulation, encode(simulation), path))
    require(int in kinds or float in kinds, f"{shown(path)} is no number, and cannot be refined; refine one that is.")
    return float if float in kinds else int


def _check_rows(rows: Sequence[Row], asked: Criterion) -> None:
    """Refuse to go on where a member's outcome is not known, or the quantity is not there at all."""
    lost = [row for row in rows if row.get(LOST)]
    require(
        not lost,
        f"{len(lost)} members have no outcome, the first because {lost[0]['reason'] if lost else ''}; run the same "
        "refinement again.",
    )
    complete = [row for row in rows if row["status"] == COMPLETE]
    known = sorted({name for row in complete for name in row["quantities"]})
    require(
        not complete or any(asked.is_known(row) for row in complete),
        f"The outcome asks for {asked.quantity}, which no member has; they have {', '.join(known)}. Correct it, and choose "
        "another folder.",
    )


def _checked(values: Sequence[float], kind: type[int] | type[float], path: str) -> list[float]:
    """The values, if a refinement can begin with them, as what the field has."""
    numbers = [one.item() if isinstance(one, np.generic) else one for one in values]
    right = all(isinstance(one, int | float) and not isinstance(one, bool) and math.isfinite(one) for one in numbers)
    require(
        2 <= len(numbers) <= MOST_VALUES and right and all(low < high for low, high in pairwise(numbers)),
        f"A refinement begins with two numbers or more that grow, not with {shown(', '.join(map(str, values)) or 'none')}.",
    )
    whole = all(float(one).is_integer() for one in numbers)
    require(kind is float or whole, f"{shown(path)} has whole numbers; {shown(', '.join(map(str, numbers)))} are others.")
    return [kind(one) for one in numbers]


def _parts_of(tried: Sequence[float], outcomes: Sequence[str], refined: Mapping[str, Any]) -> list[float]:
    """The values that divide the intervals in which the outcome changes; none if these are short enough.

    An interval with zero in it is measured by the range of all values: relative to its ends it never becomes short.
    """
    whole, accuracy = isinstance(tried[0], int), refined["accuracy"]
    more: list[float] = []
    for (low, high), (before, after) in zip(pairwise(tried), pairwise(outcomes), strict=True):
        size = tried[-1] - tried[0] if low <= 0 <= high else max(abs(low), abs(high))
        if before != after and high - low > (1 if whole else accuracy * size):
            more += _divided(low, high, refined["parts"], whole)
    return more


def _divided(low: float, high: float, parts: int, whole: bool) -> list[float]:
    """The values that divide an interval into equal parts, by their logarithms where its ends are far apart."""
    wide = low > 0 and high > WIDE * low
    inner = (np.geomspace(low, high, parts + 1) if wide else np.linspace(low, high, parts + 1))[1:-1]
    values = [round(value) for value in inner] if whole else [float(value) for value in inner]
    return sorted({value for value in values if low < value < high})
