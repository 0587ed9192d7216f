"""One member of a sweep: its run into a file, and the numbers that are read from its result."""

from __future__ import annotations

import hashlib
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.collisions import first_collision
from mol_compactons.analysis.drift import largest_drifts
from mol_compactons.analysis.tracking import track
from mol_compactons.configuration import decode
from mol_compactons.errors import InputError, IntegrationError
from mol_compactons.results.running_file import is_claimed
from mol_compactons.results.schema import COMPLETE
from mol_compactons.running import run
from mol_compactons.simulation import Simulation
from mol_compactons.studies import modules
from mol_compactons.studies.plan import NAME_DIGITS
from mol_compactons.studies.store import FAILED, Row

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

Quantity = Callable[["xr.Dataset"], float]
"""A number that is read from the result of a member; a function of a module, which another process can load."""

OF_WAVES = ("speed_before", "speed_after", "height_before", "height_after", "phase_shift")
"""What the table says of each wave, see `first_collision`."""

LEFT = ("mass_left", "momentum_left", "height_left")
"""What it says of what the waves left behind: of the first collision, or of the last frame."""

COSTS = ("solver_steps", "solver_evaluations", "solver_failures", "solver_warnings", "cpu_seconds")

ORPHAN_PATIENCE = 5.0
"""How long the run of a study that was killed may still hold the file of a member, in seconds."""


@dataclass(frozen=True)
class Task:
    """What a process needs to run one member.

    Parameters
    ----------
    name, label : str
        Of the member.
    places : list of list of int
        Where it stands along the axes of the plan; in several places where these come to one simulation.
    changes : dict
        What it changes, JSON-ready.
    tree : dict
        Its simulation as JSON-ready data.
    path : str
        Where its result goes.
    modules : dict
        What the process has to load first.
    quantities : mapping
        What is read from the result besides.
    tracked : bool
        Whether its waves are followed.
    """

    name: str
    label: str
    places: list[list[int]]
    changes: dict[str, Any]
    tree: dict[str, Any]
    path: str
    modules: modules.Modules = field(default_factory=dict)
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    tracked: bool = True

    def row(self, status: str, reason: str) -> Row:
        """What it came to, without any number."""
        known = {"name": self.name, "label": self.label, "changes": self.changes, "places": self.places}
        return {**known, "status": status, "reason": reason, "quantities": {}, "sizes": {}}


def carry_out(task: Task) -> Row:
    """Run a member, or go on with it where an earlier attempt was cut off, and say what it came to."""
    path = Path(task.path)

    def result() -> Row:
        with run(simulation_of(task), path, resume=True, progress=False) as dataset:
            return _measured(dataset, task)

    started = time.monotonic()
    while is_claimed(path) and time.monotonic() - started < ORPHAN_PATIENCE:
        time.sleep(0.1)
    return attempted(task, result)


def simulation_of(task: Task) -> Simulation:
    """The simulation of a member; raises `InputError` where its settings do not fit together."""
    modules.load(task.modules)
    return cast(Simulation, decode(Simulation, task.tree))


def attempted(task: Task, result: Callable[[], Row]) -> Row:
    """The row of a member: what it came to or, where that raises an error, why there is nothing."""
    started = time.monotonic()
    row = task.row(COMPLETE, "")
    try:
        row |= result()
    except (IntegrationError, InputError) as error:
        row |= {"status": FAILED, "reason": str(error)}
    except Exception as error:  # what the user's own classes raise
        row |= {"status": FAILED, "reason": f"{type(error).__name__}: {error}"}
    row["seconds"] = round(time.monotonic() - started, 4)
    return row


def _measured(dataset: xr.Dataset, task: Task) -> Row:
    """What is read from a result, as part of a row."""
    numbers: dict[str, Any] = {f"{name}_drift": size for name, size in largest_drifts(dataset).items()}
    numbers |= costs_of(dataset.attrs) | asked_of(dataset, task)
    sizes = {str(dimension): size for dimension, size in dataset.sizes.items()}
    variables = [(str(name), tuple(map(str, one.dims))) for name, one in dataset.data_vars.items()]
    points = [one.values for _, one in sorted(dataset.coords.items(), key=str) if "t" not in one.dims]
    times = Simulation.from_json(str(dataset.attrs["simulation"])).times
    layout = layout_digest(variables, times, points)
    return {"status": str(dataset.attrs["status"]), "quantities": numbers, "sizes": sizes, "layout": layout}


def costs_of(attributes: Mapping[str, Any]) -> dict[str, float]:
    """What a run has cost, from its attributes."""
    return {name: float(attributes[name]) for name in COSTS if name in attributes}


def asked_of(dataset: xr.Dataset, task: Task) -> dict[str, Any]:
    """The numbers of the waves, and those that the user wants."""
    numbers = _of_waves(dataset) if task.tracked else {}
    for name, quantity in task.quantities.items():
        try:
            numbers[name] = float(quantity(dataset))
        except Exception as error:
            raise InputError(
                f"The quantity {name} cannot be read from the result ({type(error).__name__}: {error}); correct the function."
            ) from None
    return numbers


def layout_digest(variables: Sequence[tuple[str, tuple[str, ...]]], times: Array, points: Sequence[Array]) -> str:
    """A digest of the variables, the times and the points of a result: members with one can be stacked."""
    digest = hashlib.sha256(repr(sorted(variables)).encode())
    for values in (times, *points):
        digest.update(np.ascontiguousarray(values).tobytes())
    return digest.hexdigest()[:NAME_DIGITS]


def _of_waves(dataset: xr.Dataset) -> dict[str, Any]:
    """Heights, speeds, phase shifts and what is left; nothing where there are no waves to follow."""
    try:
        tracks = track(dataset, newborn=False)
    except InputError:
        return {}
    collision = first_collision(tracks)
    numbers: dict[str, Any] = {name: _list(collision[name]) for name in OF_WAVES}
    for name in LEFT:
        value = float(collision[name])
        numbers[name] = value if math.isfinite(value) else float(tracks[name][-1])
    return numbers


def _list(values: xr.DataArray) -> list[float]:
    return [float(value) for value in np.atleast_1d(values.values)]
