"""Running a family of a simulation, to see how much of its result is real."""

from __future__ import annotations

import contextlib
import json
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from mol_compactons.analysis.tracking import track
from mol_compactons.configuration import encode
from mol_compactons.errors import InputError, IntegrationError, require
from mol_compactons.results.reading import conserved_names, field_names
from mol_compactons.results.schema import attributes
from mol_compactons.running import run
from mol_compactons.simulation import Simulation
from mol_compactons.studies.family import Family, Member, Notice
from mol_compactons.studies.judgement import judge

if TYPE_CHECKING:
    import xarray as xr


def converge(simulation: Simulation, family: Family | None = None, notice: Notice = lambda line: None) -> xr.DataTree:
    """Run a family of a simulation, and judge what of its result is converged.

    Parameters
    ----------
    simulation : Simulation
        An equation on a Grid.
    family : Family, optional
        What to vary; by default what suits the simulation.
    notice : callable, optional
        Called with one line about each member that has run.

    Returns
    -------
    xarray.DataTree
        ``summary``: along limit and quantity the ``value``, its ``error``, the budget ``space``, ``time``, ``viscosity``,
        ``scheme``, ``settling`` and ``reading``, the observed ``rate``, the ``scale`` that errors are relative to, ``verdict``
        and ``reason``, and along limit how many of its ``members`` ``failed``;
        ``ladder``: the distance of each member from what its scheme and viscosity tend to for h -> 0, along limit, scheme,
        viscosity, size and quantity; ``members``: a group for each member that ran to its end, with its last frame, tracks
        and conserved quantities. The attribute ``failed`` names those that did not; they are counted nowhere.

    Raises
    ------
    InputError
        If the family has a single member, or the simulation no grid to refine.
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
    results, failed = _run_all(members, notice)
    if not results:
        raise IntegrationError(f"No member of the family ran to its end; the first: {failed[0]}", 0.0)
    root = attributes(simulation) | {
        "title": f"Convergence of {simulation.headline}",
        "family": json.dumps(encode(family)),
        "failed": "\n".join(failed),
        "status": "complete",
    }
    groups = {f"/members/{index:03d}": result for index, result in enumerate(results)}
    return judge(xr.DataTree.from_dict({"/": xr.Dataset(attrs=root), "/members": xr.Dataset(), **groups}))


def _run_all(members: Sequence[Member], notice: Notice) -> tuple[list[xr.Dataset], list[str]]:
    results, failed = [], []
    for index, member in enumerate(members):
        started = time.monotonic()
        try:
            results.append(_result(member, run(member.simulation)))
            end = "done"
        except (IntegrationError, InputError) as error:
            failed.append(f"{member.label}: {error}")
            end = f"failed: {error}"
        notice(f"{index + 1}/{len(members)} {member.label}: {end} after {time.monotonic() - started:.1f} s")
    return results, failed


def _result(member: Member, dataset: xr.Dataset) -> xr.Dataset:
    """What is kept of a run: its last frame, its conserved quantities and its tracks."""
    import xarray as xr

    name = field_names(dataset)[0]
    last = dataset[name].isel(t=-1, drop=True).to_dataset(name=name)
    result = xr.merge([dataset[conserved_names(dataset)], last])
    with contextlib.suppress(InputError):
        result = result.merge(track(dataset, newborn=False), combine_attrs="override")
    result.attrs = dataset.attrs | {
        name: getattr(member, name) for name in ("label", "limit", "scheme", "viscosity", "tolerance")
    }
    return result
