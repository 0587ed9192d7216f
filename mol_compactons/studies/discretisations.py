"""Discretisations side by side: error, observed order, drift and cost of each scheme of a study on each of its grids."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.drift import largest_drifts
from mol_compactons.configuration import decode
from mol_compactons.errors import require
from mol_compactons.results.reading import arranged, field_names
from mol_compactons.results.schema import COMPLETE
from mol_compactons.simulation import Simulation
from mol_compactons.studies.family import VISCOUS, Cell, Family
from mol_compactons.studies.outcome import on_grid
from mol_compactons.studies.store import FAILED

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

SMALLEST_MULTIPLE = 3.0
"""Errors below so many times the uncertainty of what they are measured against show no order."""

FITTED = 3
"""To how many of the finest grids an order is fitted."""

COSTS = {"solver_steps": "1", "solver_evaluations": "1", "cpu_seconds": "s"}
"""What a run has cost, and in which unit."""

MEANINGS = {
    "error": "L2 error of the last profile, relative to its norm",
    "order": "observed order, from a grid and the next coarser one",
    "fitted_order": "observed order, fitted to the three finest grids",
    "reference_error": "uncertainty of what errors are measured against, relative",
    "time_error": "error of the integration in time on the finest grid, relative",
    "viscosity": "artificial viscosity, in grid units in the conservative limit",
    "reference": "what errors are measured against",
    "solver_steps": "steps of the integrator",
    "solver_evaluations": "evaluations of the right-hand side",
    "cpu_seconds": "CPU time of the run",
    "integrator": "the integrator",
    "status": "how the run ended",
    "member": "the name of the run among the members of the study",
}


TEXTS = ("integrator", "status", "member", "reference")
"""The variables that are words."""


def compare_schemes(study: xr.DataTree, references: Sequence[xr.Dataset] = ()) -> xr.Dataset:
    """The schemes of a convergence study beside each other, at its smallest viscosity and tightest tolerance.

    Errors are those of the last profile against the exact wave on all points of a grid, where the initial data are one and the
    viscosity, if any, vanishes with the grid. Elsewhere they are those on the points of the coarsest grid against the profile
    to which the members tend, with the uncertainty that the study gives it, or against a run on a finer grid.

    Parameters
    ----------
    study : xarray.DataTree
        What `converge` returned, or its file, opened.
    references : sequence of xarray.Dataset, optional
        Two results on finer grids, the finer one last: errors are measured against that, and are uncertain by the distance of
        the two. Their points include those of all members.

    Returns
    -------
    xarray.Dataset
        Along ``scheme``, ``size`` and, if the equation has an exponent n, ``n``: ``error``, ``order``, the largest drift of
        each conserved quantity as ``mass_drift``, ``solver_steps``, ``solver_evaluations``, ``cpu_seconds``, ``integrator``,
        ``status`` and the name of the ``member``; without ``size`` ``fitted_order``, ``time_error`` and
        ``viscosity``; along ``n`` ``reference_error`` and ``reference``. Errors below three times what is uncertain in them
        show no order.

    Raises
    ------
    InputError
        If the study is one of a chain, which has no schemes.
    """
    simulation = Simulation.from_json(str(study.attrs["simulation"]))
    require(simulation.scheme.refines, "A chain has no discretisations to compare; compare its tolerances.")
    family = decode(Family, json.loads(study.attrs["family"])).completed(simulation)
    limit, viscosities = next(iter(family.limits.items()))
    runs = {name: member.to_dataset() for name, member in study["members"].children.items()}
    runs = {
        name: run for name, run in runs.items() if (run.attrs["limit"], run.attrs["viscosity"]) == (limit, viscosities[-1])
    }
    reference, uncertain, meaning = _reference(study, simulation, limit, references)
    table = _table(family, runs, simulation, reference)
    for scheme, size in np.argwhere(table["status"].values == FAILED):
        cell = Cell(limit, family.schemes[scheme].label, family.sizes[size], viscosities[-1], family.tolerances[-1])
        reasons = [line for line in str(study.attrs["failed"]).splitlines() if line.startswith(f"{cell.label}: ")]
        table["status"].values[scheme, size] = reasons[0].replace(cell.label, FAILED, 1) if reasons else FAILED
    table["reference_error"], table["reference"] = ((), uncertain), ((), meaning)
    table["viscosity"] = "scheme", np.full(len(family.schemes), viscosities[-1])
    table = _described(_with_orders(table).assign({name: table[name].astype(str) for name in TEXTS}))
    exponent = getattr(simulation.equation, "n", None)
    if isinstance(exponent, float):
        table = table.expand_dims(n=[exponent], axis=-1)
        table["n"].attrs["long_name"] = "exponent of the contacts"
    return table.assign_attrs(title=f"Discretisations: {simulation.title or simulation.headline}", limit=limit)


def _reference(
    study: xr.DataTree, simulation: Simulation, limit: str, references: Sequence[xr.Dataset]
) -> tuple[Array | None, float, str]:
    """A profile that errors are measured against, None for the exact wave, how uncertain it is, and what it is."""
    if references:
        coarse, fine = (arranged(one)[field_names(one)[0]].values[-1] for one in references)
        require(fine.size % coarse.size == 0, f"The references have {coarse.size} and {fine.size} points; double the first.")
        apart = np.linalg.norm(on_grid(fine, coarse.size) - coarse) / np.linalg.norm(coarse)
        return fine, float(apart), f"a run on {fine.size} points"
    if limit != VISCOUS and simulation.exact_state(simulation.t_end) is not None:
        return None, 0.0, "the exact wave"
    judged = study["summary"].to_dataset().sel(limit=limit, quantity="profile", drop=True)
    profile = study["profile"].to_dataset()["profile"].sel(limit=limit).values
    return profile, float(judged["error"] / judged["scale"]), f"the profile to which the members tend in the {limit} limit"


def _with_orders(table: xr.Dataset) -> xr.Dataset:
    """A table with the orders that its errors show, where these are above what is uncertain in them."""
    sizes = table["size"].values
    uncertain = table["time_error"].fillna(0) + table["reference_error"]
    trusted = table["error"].where(table["error"] > SMALLEST_MULTIPLE * uncertain).values
    return table.assign(
        order=(("scheme", "size"), [[math.nan, *_orders(sizes, one)] for one in trusted]),
        fitted_order=("scheme", [_fitted(sizes[-FITTED:], one[-FITTED:]) for one in trusted]),
    )


def _table(family: Family, runs: Mapping[str, xr.Dataset], simulation: Simulation, reference: Array | None) -> xr.Dataset:
    """What the runs came to, along scheme and size; NaN where there is none."""
    import xarray as xr

    schemes, sizes = [scheme.label for scheme in family.schemes], list(family.sizes)
    shape = len(schemes), len(sizes)
    changes = {name: largest_drifts(run) for name, run in runs.items()}
    quantities = sorted({f"{quantity}_drift" for change in changes.values() for quantity in change})
    numbers = {name: np.full(shape, math.nan) for name in ("error", *quantities, *COSTS)}
    texts = {name: np.full(shape, "", dtype=object) for name in ("integrator", "status", "member")}
    texts["status"][...] = FAILED
    for name, run in runs.items():
        if run.attrs["tolerance"] != family.tolerances[-1]:
            continue
        place = schemes.index(run.attrs["scheme"]), sizes.index(_profile(run).size)
        numbers["error"][place] = _error(run, simulation, reference)
        for quantity, size in changes[name].items():
            numbers[f"{quantity}_drift"][place] = size
        for cost in COSTS:
            numbers[cost][place] = float(run.attrs.get(cost, math.nan))
        own = Simulation.from_json(str(run.attrs["simulation"]))
        status = str(run.attrs.get("status", COMPLETE))
        for text, told in (("integrator", type(own.integrator).__name__), ("status", status), ("member", name)):
            texts[text][place] = told
    timing = [_time_error([run for run in runs.values() if run.attrs["scheme"] == scheme]) for scheme in schemes]
    columns = {name: (("scheme", "size"), values) for name, values in (numbers | texts).items()}
    return xr.Dataset({**columns, "time_error": ("scheme", timing)}, {"scheme": schemes, "size": sizes})


def _time_error(runs: Sequence[xr.Dataset]) -> float:
    """The error of time on the finest grid, relative: what a looser tolerance changes, in proportion to the tolerances."""
    finest = max((_profile(run).size for run in runs), default=0)
    own = sorted((run for run in runs if _profile(run).size == finest), key=lambda run: float(run.attrs["tolerance"]))
    if len(own) < 2:
        return math.nan
    tight, loose = own[0], own[-1]
    change = np.linalg.norm(_profile(loose) - _profile(tight)) / np.linalg.norm(_profile(tight))
    return float(change * tight.attrs["tolerance"] / loose.attrs["tolerance"])


def _profile(run: xr.Dataset) -> Array:
    return np.asarray(run[field_names(run)[0]].values)


def _error(run: xr.Dataset, simulation: Simulation, reference: Array | None) -> float:
    """The relative L2 error of a last profile."""
    profile = _profile(run)
    if reference is None:
        finer = replace(simulation, grid=replace(simulation.grid, size=profile.size))
        exact = finer.exact_state(simulation.t_end)
        assert exact is not None
        reference = exact[0]
    size = min(profile.size, reference.size)
    profile, reference = on_grid(profile, size), on_grid(reference, size)
    return float(np.linalg.norm(profile - reference) / np.linalg.norm(reference))


def _orders(sizes: Any, errors: Array) -> Array:
    """The power of the spacing at which the error falls from each grid to the next."""
    with np.errstate(all="ignore"):
        return np.asarray(np.log(errors[:-1] / errors[1:]) / np.log(np.divide(sizes[1:], sizes[:-1])))


def _fitted(sizes: Any, errors: Array) -> float:
    """The power of the spacing at which the errors fall, by least squares in logarithms; NaN unless all are known."""
    if len(sizes) < 2 or not (errors > 0).all():
        return math.nan
    return float(-np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def _described(table: xr.Dataset) -> xr.Dataset:
    """A table whose variables say what they are."""
    for name, variable in table.data_vars.items():
        drifting = str(name).removesuffix("_drift")
        meaning = MEANINGS.get(str(name), f"largest drift of the {drifting}, relative to its scale")
        variable.attrs = {"long_name": meaning} | ({} if name in TEXTS else {"units": COSTS.get(str(name), "1")})
    return table
