"""What the members of a sweep came to, as one Dataset along what was varied."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from mol_compactons.studies.criterion import Criterion
from mol_compactons.studies.store import Row

if TYPE_CHECKING:
    import xarray as xr

WAVE = "wave"
"""The dimension of what the table says of each wave."""

MEANINGS = {
    "status": "how the run of the member ended",
    "outcome": "how the member came out, as the refinement asks",
    "reason": "why a member has no complete result",
    "name": "the name of the member, and of its file",
    "seconds": "how long the member took",
    "cpu_seconds": "CPU time of the run",
    "speed_before": "speed before the first collision",
    "speed_after": "speed after the first collision",
    "height_before": "height before the first collision",
    "height_after": "height after the first collision",
    "phase_shift": "phase shift of the first collision",
    "mass_left": "mass outside of the waves",
    "momentum_left": "momentum outside of the waves",
    "height_left": "largest size of the field outside of the waves",
}
"""The long names of the variables of a table."""

SECONDS = ("seconds", "cpu_seconds")

REFINED = "refined"
"""Where the plan of a refinement says what it refines: its axis grows."""

MISSING = "not run yet"
"""The status of a member without a row."""


def laid_out(plan: Mapping[str, Any], rows: Iterable[Row]) -> tuple[Mapping[str, Any], list[Row]]:
    """A plan with its axes, and rows with their places along them: those of a refinement, as far as it has come.

    Parameters
    ----------
    plan : mapping
        What stands in the folder of a study.
    rows : iterable
        What the members came to.
    """
    known = list(rows)
    if REFINED not in plan:
        return plan, known
    refined = plan[REFINED]
    path = refined["field"]
    values = sorted({row["changes"][path] for row in known} | set(refined["values"]))
    field = {"name": refined["name"], "values": values, "told": [f"{value:.12g}" for value in values]}
    criterion = Criterion(**refined["criterion"])
    own = [row | {"places": [[values.index(row["changes"][path])]], "outcome": criterion.of(row)} for row in known]
    return {**plan, "axes": [{"dimension": refined["name"], "fields": {path: field}}]}, own


def table(plan: Mapping[str, Any], rows: Iterable[Row]) -> xr.Dataset:
    """The table of a sweep.

    Parameters
    ----------
    plan : mapping
        What `Plan.described` or `laid_out` returned.
    rows : iterable
        What the members came to, as far as they have run.

    Returns
    -------
    xarray.Dataset
        Along each axis of the plan, with the varied values as coordinates: ``status``, ``reason``, ``name``, ``seconds``,
        and each quantity of the members; along ``wave`` too where it is one of a wave. NaN for what is not known.
    """
    import xarray as xr

    dimensions = [axis["dimension"] for axis in plan["axes"]]
    coordinates = {
        one["name"]: (axis["dimension"], values_of(one), {"field": path})
        for axis in plan["axes"]
        for path, one in axis["fields"].items()
    }
    shape = tuple(len(next(iter(axis["fields"].values()))["values"]) for axis in plan["axes"])
    words = ("status", "reason", "name", *(("outcome",) if REFINED in plan else ()))
    texts = {name: np.full(shape, "", dtype=object) for name in words}
    texts["status"][...] = MISSING
    known = list(rows)
    of_waves, numbers = _columns(known, shape)
    for row in known:
        for place in map(tuple, row["places"]):
            for word in words:
                texts[word][place] = row[word]
            numbers["seconds"][place] = row.get("seconds", math.nan)
            for name, value in row["quantities"].items():
                if isinstance(value, list):
                    numbers[name][place][: len(value)] = value
                elif name in of_waves:
                    numbers[name][place][0] = value
                else:
                    numbers[name][place] = value
    variables = {name: (dimensions, values.astype(str), _attributes(name)) for name, values in texts.items()}
    for name, values in numbers.items():
        variables[name] = ([*dimensions, WAVE] if name in of_waves else dimensions, values, _attributes(name))
    return xr.Dataset(variables, coordinates)


def values_of(field: Mapping[str, Any]) -> Any:
    """The values of a field along its axis as a coordinate: numbers, or what distinguishes parts in a few characters."""
    values = field["values"]
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return np.array(values)
    try:
        return np.array([float(value) for value in values if isinstance(value, str)] or None).reshape(len(values))
    except (ValueError, TypeError):
        return np.array(field["told"], dtype=str)


def _columns(rows: list[Row], shape: tuple[int, ...]) -> tuple[set[str], dict[str, Any]]:
    """The quantities that members have for each wave, and an array of NaN for each quantity, with room for all waves."""
    lengths: dict[str, int] = {}
    for row in rows:
        for name, value in row["quantities"].items():
            lengths[name] = max(lengths.get(name, 0), len(value) if isinstance(value, list) else 0)
    most = max(lengths.values(), default=0)
    of_waves = {name for name, length in lengths.items() if length}
    columns = {name: np.full((*shape, most) if name in of_waves else shape, np.nan) for name in lengths}
    return of_waves, columns | {"seconds": np.full(shape, np.nan)}


def _attributes(name: str) -> dict[str, str]:
    """What a variable of a table is."""
    meaning = MEANINGS.get(name, f"largest {name.replace('_', ' ')}" if name.endswith("_drift") else name.replace("_", " "))
    return {"long_name": meaning} | ({"units": "s"} if name in SECONDS else {})
