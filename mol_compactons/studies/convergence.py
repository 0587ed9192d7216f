"""Running a family of a simulation, to see how much of its result is real."""

from __future__ import annotations

import contextlib
import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from mol_compactons.analysis.tracking import track
from mol_compactons.configuration import decode, encode
from mol_compactons.errors import InputError, IntegrationError, require
from mol_compactons.progress import MEMBERS, Show, showing_progress
from mol_compactons.results.opening import write_tree
from mol_compactons.results.reading import conserved_names, field_names
from mol_compactons.results.schema import COMPLETE, attributes
from mol_compactons.running import run
from mol_compactons.runtime.netcdf import open_netcdf
from mol_compactons.runtime.signals import stopping_on_signals
from mol_compactons.simulation import Simulation
from mol_compactons.studies import modules
from mol_compactons.studies.engine import Engine, Here, Lost, Watch
from mol_compactons.studies.family import Family, Member, Notice
from mol_compactons.studies.judgement import judge
from mol_compactons.studies.plan import digest
from mol_compactons.studies.store import FAILED, Store

if TYPE_CHECKING:
    import xarray as xr


LONGEST_NAME = 200
"""How many bytes of its label the name of a group has; NetCDF allows 256."""


def converge(
    simulation: Simulation,
    family: Family | None = None,
    notice: Notice = lambda line: None,
    *,
    engine: Engine | None = None,
    folder: str | Path | None = None,
    progress: bool | None = None,
) -> xr.DataTree:
    """Run a family of a simulation, and judge what of its result is converged.

    Parameters
    ----------
    simulation : Simulation
        An equation on a Grid.
    family : Family, optional
        What to vary; by default what suits the simulation.
    notice : callable, optional
        Called with one line about each member that has run.
    engine : Engine, optional
        Where members run; by default in this process. The numbers are the same everywhere, bit for bit.
    folder : str or Path, optional
        Where members are kept that have run: the same call again does only what is missing or has failed.
    progress : bool, optional
        Whether to show how many members have ended, as for `mol_compactons.run`.

    Returns
    -------
    xarray.DataTree
        ``summary``: along limit and quantity the ``value``, its ``error``, the budget ``space``, ``time``, ``viscosity``,
        ``scheme``, ``settling`` and ``reading``, the observed ``rate``, the ``scale`` that errors are relative to, ``verdict``
        and ``reason``, and along limit how many of its ``members`` ``failed``;
        ``ladder``: the distance of each member from what its scheme and viscosity tend to for h -> 0, along limit, scheme,
        viscosity, size and quantity; ``profile``: the last profile to which the members tend, along limit and x, on the
        points of the coarsest grid; ``schemes``: the discretisations side by side, see `compare_schemes`; ``members``: a
        group for each member that ran to its end, under its label, with its last frame, tracks and conserved quantities. The
        attribute ``failed`` names those that did not; they are counted nowhere.

    Raises
    ------
    InputError
        If the family has a single member, the simulation no grid to refine, or the folder holds another study.
    IntegrationError
        If no member ran to its end.
    """
    import xarray as xr

    family = (family or Family()).completed(simulation)
    members = list(family.members(simulation))
    require(
        len(members) > 1,
        "The family has a single member, from which nothing can be learnt; vary sizes, schemes, viscosities or tolerances.",
    )
    with contextlib.ExitStack() as stack:
        store = Store(Path(folder), plan_of_study(simulation, family)) if folder is not None else None
        if store:
            stack.callback(store.close)
        show = stack.enter_context(showing_progress(len(members), MEMBERS, progress))
        report = stack.enter_context(stopping_on_signals(lambda t: None))
        tasks = [_task(member, store) for member in members]
        ended = _run_all(tasks, engine or Here(), lambda: report(0.0), store, notice, show)
    results = [one.result for one in ended if one.result is not None]
    failed = [f"{one.label}: {one.reason}" for one in ended if one.result is None]
    if not results:
        raise IntegrationError(f"No member of the family ran to its end; the first: {failed[0]}", 0.0)
    root = attributes(simulation) | {
        "title": f"Convergence of {simulation.headline}",
        "family": json.dumps(encode(family)),
        "failed": "\n".join(failed),
        "status": "complete",
    }
    groups: dict[str, xr.Dataset] = {}
    for result in results:
        name = group_name(str(result.attrs["label"]))
        taken = f"/members/{name}" in groups
        groups[f"/members/{name} {len(groups)}" if taken else f"/members/{name}"] = result
    return judge(xr.DataTree.from_dict({"/": xr.Dataset(attrs=root), "/members": xr.Dataset(), **groups}))


def group_name(label: str) -> str:
    """The name of a member's group: its label, as far as that can be the name of one."""
    name = label.replace("/", "|")
    encoded = name.encode()
    return name if len(encoded) <= LONGEST_NAME else f"{encoded[:LONGEST_NAME].decode(errors='ignore')} {digest(name)}"


def plan_of_study(simulation: Simulation, family: Family) -> dict[str, Any]:
    """What a study runs, JSON-ready, by which it is known again."""
    return {"simulation": encode(simulation), "family": encode(family.completed(simulation))}


@dataclass(frozen=True)
class Task:
    """What a process needs to run one member of a family.

    Parameters
    ----------
    name : str
        A digest of its settings and its place.
    tree : dict
        Its simulation as JSON-ready data.
    place : dict
        Its ``label``, ``limit``, ``scheme``, ``viscosity`` and ``tolerance``.
    modules : dict
        What the process has to load first.
    path : str
        Where its result is kept; empty if nowhere.
    """

    name: str
    tree: dict[str, Any]
    place: dict[str, Any]
    modules: modules.Modules
    path: str

    @property
    def length(self) -> tuple[float, float]:
        """What tells which of two members takes longer: the finer grid, and of one grid the tighter tolerance."""
        return float(self.tree["grid"]["size"]), -float(self.place["tolerance"])


@dataclass(frozen=True)
class Ended:
    """What became of a member: its result, or the reason why it has none."""

    label: str
    result: xr.Dataset | None
    reason: str
    seconds: float = 0.0


def _task(member: Member, store: Store | None) -> Task:
    tree = encode(member.simulation)
    place = {name: getattr(member, name) for name in ("label", "limit", "scheme", "viscosity", "tolerance")}
    name = digest([tree, place])
    return Task(name, tree, place, modules.modules_of(tree), str(store.path_of(name).resolve()) if store else "")


def _run_all(
    tasks: Sequence[Task], engine: Engine, watch: Watch, store: Store | None, notice: Notice, show: Show
) -> list[Ended]:
    """What became of each member, in their order; those that are kept do not run again."""
    ended = {number: kept for number, task in enumerate(tasks) if (kept := _kept(task)) is not None}
    missing = [number for number in range(len(tasks)) if number not in ended]
    if engine.longest_first:
        missing.sort(key=lambda number: tasks[number].length, reverse=True)
    show(len(ended))
    if ended:
        notice(f"{len(ended)}/{len(tasks)} have run before")
    for index, made in engine.results(carry_out, [tasks[number] for number in missing], watch):
        number, label = missing[index], tasks[missing[index]].place["label"]
        one = Ended(label, None, str(made)) if isinstance(made, Lost) else made
        ended[number] = one
        show(len(ended))
        if store:
            status = COMPLETE if one.result is not None else FAILED
            store.add({"name": tasks[number].name, "label": label, "status": status, "reason": one.reason})
        notice(
            f"{len(ended)}/{len(tasks)} {label}: {f'failed: {one.reason}' if one.reason else 'done'} after {one.seconds:.1f} s"
        )
    return [ended[number] for number in range(len(tasks))]


def _kept(task: Task) -> Ended | None:
    """What an earlier call kept of a member; None where that is nothing, or cannot be read."""
    if not task.path or not Path(task.path).is_file():
        return None
    try:
        with open_netcdf(Path(task.path)) as dataset:
            return Ended(task.place["label"], dataset.load(), "")
    except OSError:
        return None


def carry_out(task: Task) -> Ended:
    """Run a member of a family."""
    started, result, reason = time.monotonic(), None, ""
    try:
        modules.load(task.modules)
        result = _result(task, run(cast(Simulation, decode(Simulation, task.tree)), progress=False))
    except (IntegrationError, InputError) as error:
        reason = str(error)
    if result is not None and task.path:
        write_tree(result, task.path)
    return Ended(task.place["label"], result, reason, time.monotonic() - started)


def _result(task: Task, dataset: xr.Dataset) -> xr.Dataset:
    """What is kept of a run: its last frame, its conserved quantities and its tracks."""
    import xarray as xr

    name = field_names(dataset)[0]
    last = dataset[name].isel(t=-1, drop=True).to_dataset(name=name)
    result = xr.merge([dataset[conserved_names(dataset)], last])
    with contextlib.suppress(InputError):
        result = result.merge(track(dataset, newborn=False), combine_attrs="override")
    result.attrs = dataset.attrs | task.place
    return result
