"""Sweeps: a simulation with some of its fields varied, each member run once, here or elsewhere, and their table."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mol_compactons.errors import require
from mol_compactons.progress import MEMBERS as MEMBERS_DONE
from mol_compactons.progress import showing_progress
from mol_compactons.results.opening import write_tree
from mol_compactons.results.schema import COMPLETE, attributes
from mol_compactons.runtime.signals import stopping_on_signals
from mol_compactons.simulation import Simulation
from mol_compactons.studies.blocks import MANY, PER_FILE, Block, carry_out_all, units_of
from mol_compactons.studies.engine import Engine, Here, Lost, Watch
from mol_compactons.studies.members import Quantity, Task
from mol_compactons.studies.modules import modules_of
from mol_compactons.studies.plan import Plan, encoded, product
from mol_compactons.studies.store import FAILED, LOST, MEMBERS, Row, Store, file_of, result_path
from mol_compactons.studies.table import table

if TYPE_CHECKING:
    import xarray as xr

TABLE = "table.nc"
"""The table of a study in its folder, a NetCDF file."""


@dataclass(frozen=True)
class Progress:
    """How far a study is.

    Parameters
    ----------
    done, total : int
        Members that have ended, and all.
    failed : int
        How many of those that have ended failed.
    label : str
        The member that ended last.
    outcome : str
        What became of it.
    """

    done: int
    total: int
    failed: int
    label: str
    outcome: str


Tell = Callable[[Progress], None]
"""Called when a member has ended, and once at the beginning."""


def tell_nobody(progress: Progress) -> None:
    """The `Tell` of a study that nobody watches."""


@contextmanager
def telling(tell: Tell, wanted: bool | None) -> Iterator[Tell]:
    """A `Tell` that shows the progress besides, if that is wanted."""
    with showing_progress(0, MEMBERS_DONE, wanted) as show:

        def both(progress: Progress) -> None:
            show(progress.done, progress.total, f"{progress.failed} failed" if progress.failed else "")
            tell(progress)

        yield both


def sweep(
    simulation: Simulation | Plan,
    varied: Mapping[str, Sequence[Any]] | None = None,
    folder: str | Path = "sweep",
    *,
    engine: Engine | None = None,
    quantities: Mapping[str, Quantity] | None = None,
    tracked: bool = True,
    per_file: int | None = None,
    tell: Tell = tell_nobody,
    progress: bool | None = None,
) -> xr.Dataset:
    """Run a simulation with some of its fields varied, and return the table of what came out.

    Each member is run once: the same call again does only what is missing or has failed, also after a crash. A member that
    fails is a row with its reason.

    Parameters
    ----------
    simulation : Simulation or Plan
        What is varied, or a plan of it.
    varied : mapping of str to sequence
        For each field, by its path as in ``--set``, its values; all combinations are run. Not with a plan.
    folder : str or Path
        Where the results go: a NetCDF file for each member, and the table.
    engine : Engine, optional
        Where members run; by default in this process. `Processes()` takes all cores, `Cluster(address)` a Dask cluster.
    quantities : mapping of str to callable, optional
        Numbers of one's own, each a function of the Dataset of a member; for other processes, a function of a module.
    tracked : bool
        Whether the waves of the members are followed.
    per_file : int, optional
        How many small members share a file at most; by default each has its own, and of more than a thousand 100 share one.
        What shares a file is lost together where its process is killed, and runs again from its beginning.
    tell : callable, optional
        Called with the progress when a member has ended.
    progress : bool, optional
        Whether to show how many members have ended, as for `mol_compactons.run`.

    Returns
    -------
    xarray.Dataset
        See `mol_compactons.studies.table.table`; also in the folder, as ``table.nc``.

    Raises
    ------
    InputError
        If nothing is varied, a field does not exist, the folder holds another study or is in use, or the engine cannot begin.
    """
    require(per_file is None or per_file >= 1, f"per_file = {per_file} must be at least 1.")
    require(isinstance(simulation, Plan) == (varied is None), "Give a plan, or a simulation and what is varied of it.")
    plan = simulation if isinstance(simulation, Plan) else product(simulation, varied or {})
    own = dict(quantities or {})
    described = {**plan.described(), "quantities": sorted(own), "tracked": tracked}
    store = Store(Path(folder), described)
    try:
        with telling(tell, progress) as told, stopping_on_signals(lambda t: None) as report:
            tasks = tasks_of(plan, store, own, tracked)
            per_file = per_file or (PER_FILE if len(tasks) > MANY else 1)
            run_missing(store, tasks, engine or Here(), lambda: report(0.0), told, per_file)
    finally:
        rows = store.rows()
        store.close()
    result = table(described, rows.values()).assign_attrs(attributes_of(plan, rows))
    write_tree(result, Path(folder) / TABLE)
    return result


def tasks_of(plan: Plan, store: Store, quantities: Mapping[str, Quantity], tracked: bool) -> list[Task]:
    """The members of a plan, each once, however many places it has."""
    tasks: dict[str, Task] = {}
    loaded, folder = modules_of(plan.described()), store.folder.resolve()
    for variant in plan:
        if variant.name in tasks:
            tasks[variant.name].places.append(list(variant.index))
        else:
            path = str(result_path(folder, variant.name))
            changes = {field: encoded(value) for field, value in variant.changes.items()}
            tasks[variant.name] = Task(
                variant.name, variant.label, [list(variant.index)], changes, variant.tree, path, loaded, quantities, tracked
            )
    return list(tasks.values())


def run_missing(
    store: Store,
    tasks: Sequence[Task],
    engine: Engine,
    watch: Watch,
    tell: Tell,
    per_file: int = 1,
    failed_too: bool = True,
) -> None:
    """Run what has no complete result yet; members whose block lost its process, each by itself."""
    missing = _missing(store, tasks, failed_too)
    done, failed = len(tasks) - len(missing), 0
    tell(Progress(done, len(tasks), failed, "", ""))
    units = list(units_of(missing, per_file, store.folder / MEMBERS))
    while units:
        lost: list[Task] = []
        for number, made in engine.results(carry_out_all, units, watch):
            unit = units[number]
            if isinstance(unit, Block) and isinstance(made, Lost):
                lost += unit.tasks
                continue
            rows = (
                made
                if not isinstance(made, Lost)
                else [unit.row(FAILED, str(made)) | {LOST: True}]
                if isinstance(unit, Task)
                else []
            )
            store.add(*rows)
            done, failed = done + len(rows), failed + sum(row["status"] == FAILED for row in rows)
            tell(Progress(done, len(tasks), failed, rows[-1]["label"], rows[-1]["reason"] or rows[-1]["status"]))
        units = list(lost)


def _missing(store: Store, tasks: Sequence[Task], failed_too: bool) -> list[Task]:
    """The members that have no complete result yet; those that failed by themselves only if these are to run again."""
    there = {path.name for path in (store.folder / MEMBERS).iterdir()}

    def is_done(row: Row) -> bool:
        if row["status"] == FAILED:
            return not failed_too and not row.get(LOST)
        return file_of(row) in there

    done = {name for name, row in store.rows().items() if is_done(row)}
    return [task for task in tasks if task.name not in done]


def attributes_of(plan: Plan, rows: Mapping[str, Row]) -> dict[str, Any]:
    """The attributes of a table."""
    ended = {name: row for name, row in rows.items() if row["status"] == COMPLETE}
    about = attributes(plan.simulation)
    varied = ", ".join(path for axis in plan.axes for path in axis.changes)
    about |= {"title": f"Sweep over {varied}: {plan.simulation.headline}", "status": COMPLETE}
    return about | {"members": len(rows), "failed": len(rows) - len(ended)}
