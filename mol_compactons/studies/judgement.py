"""How much of a result is real: a family of runs, an error budget for each quantity, and a verdict.

For each limit and each scheme the values on three grids or more give an observed rate and, by Richardson's extrapolation, a
limit for h -> 0 with an uncertainty (Roache, Annu. Rev. Fluid Mech. 29 (1997) 123, doi:10.1146/annurev.fluid.29.1.123).
Viscosities, tolerances and schemes give one more part of the budget each, and so does what goes on changing after a collision
and how exactly a quantity is read from the frames. Nothing is called converged unless each that matters was varied,
independent schemes agree whose members ran wherever those of the best did, and the whole budget is below the accuracy asked
for. Members that are one run, by the same steps or bit for bit, count once.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import decode, encode
from mol_compactons.results.schema import describe
from mol_compactons.simulation import Simulation
from mol_compactons.studies.discretisations import compare_schemes
from mol_compactons.studies.evidence import Evidence, gather
from mol_compactons.studies.extrapolation import distance
from mol_compactons.studies.family import Cell, Family
from mol_compactons.studies.outcome import Outcome, outcome_of

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

CONVERGED, CONVERGING, NOT_CONVERGED = "converged", "converging", "not converged"

BUDGET = ("space", "time", "viscosity", "scheme", "settling", "reading")

NOT_SETTLED = (
    "not settled: it may still change by {:.1e} of what it is measured against; choose a longer t_end or a longer box"
)


def judge(study: xr.DataTree, accuracy: float | None = None) -> xr.DataTree:
    """A study with its members judged anew, if wanted with another accuracy.

    Parameters
    ----------
    study : xarray.DataTree
        What `converge` returned, or its file.
    accuracy : float, optional
        The relative error below which a quantity may be called converged.
    """
    import xarray as xr

    family = decode(Family, json.loads(study.attrs["family"]))
    family = replace(family, accuracy=family.accuracy if accuracy is None else accuracy)
    members = study["members"].children
    outcomes = [outcome_of(member.to_dataset(), family.sizes[0]) for member in members.values()]
    cells = {limit: [cell for cell, _ in family.cells() if cell.limit == limit] for limit in family.limits}
    assessments = {
        limit: _assess(own, family.accuracy, [o for o in outcomes if o.member.limit == limit]) for limit, own in cells.items()
    }
    ran = {outcome.member.cell for outcome in outcomes}
    counts = {"members": cells.values(), "failed": [[cell for cell in own if cell not in ran] for own in cells.values()]}
    columns = {name: ("limit", [len(one) for one in table], describe(name)) for name, table in counts.items()}
    summary = _summary(assessments).assign(columns)
    root = xr.Dataset(attrs=study.attrs | {"family": json.dumps(encode(family))})
    groups = {f"/members/{name}": member.to_dataset() for name, member in members.items()}
    own = {"/": root, "/summary": summary, "/ladder": _ladder(assessments, outcomes), "/members": xr.Dataset()}
    own["/profile"] = _profile(assessments, outcomes)
    tree = xr.DataTree.from_dict(own | groups)
    if Simulation.from_json(str(root.attrs["simulation"])).scheme.refines:
        tree["schemes"] = xr.DataTree(compare_schemes(tree))
    return tree


@dataclass(frozen=True, eq=False)
class Assessment:
    """The judgement of one quantity in one limit; errors in its units; limits for h -> 0 by scheme and viscosity."""

    limits: dict[tuple[str, float], Array]
    value: Array
    budget: dict[str, float]
    rate: float
    scale: float
    verdict: str
    reason: str


def _assess(cells: Sequence[Cell], accuracy: float, outcomes: Sequence[Outcome]) -> dict[str, Assessment]:
    """The judgement of each quantity that any member has."""
    quantities = dict.fromkeys(name for outcome in outcomes for name in outcome.values)
    return {name: _weigh(name, cells, accuracy, [o for o in outcomes if o.knows(name)]) for name in quantities}


def _weigh(quantity: str, cells: Sequence[Cell], accuracy: float, known: Sequence[Outcome]) -> Assessment:
    """The judgement of a quantity from the outcomes that have a value of it, of all cells of the family in one limit."""
    schemes = dict.fromkeys(outcome.member.scheme for outcome in known)
    evidence = [gather(quantity, [o for o in known if o.member.scheme == scheme]) for scheme in schemes]
    if not evidence:
        return _unknown("no member has a value")
    absent = _absent(cells, known)
    finest = max(cell.size for cell in cells)
    lacking = {one.scheme: any(cell.size == finest for cell in absent[one.scheme]) for one in evidence}
    best = min(evidence, key=lambda one: (len(one.gaps) + lacking[one.scheme], one.error, one.scheme))
    scale = max(outcome.scales[quantity] for outcome in known)
    objections, distances = _disagreements(best, _independent_of(best, evidence), scale, accuracy)
    gaps = list(best.gaps) + ([_words_of(best.scheme, cells, absent)] if lacking[best.scheme] else [])
    if best.member.simulation.scheme.refines:
        gaps += _not_independent(best, evidence, cells, absent)
    budget = {part: best.budget.get(part, max(distances, default=0.0)) for part in BUDGET}
    error = sum(budget.values())
    if error > accuracy * scale:
        objections += best.irregularities
        gaps.append(f"the error is {error / scale:.1e}, above the accuracy {accuracy:g}")
    if error > scale:
        objections.append("the error is larger than what it is measured against")
    if accuracy * scale < budget["settling"] < np.inf:
        objections.insert(0, NOT_SETTLED.format(budget["settling"] / scale))
    verdict = NOT_CONVERGED if objections else CONVERGING if gaps else CONVERGED
    named = [_words_of(scheme, cells, absent) for scheme in absent if absent[scheme]]
    reason = "; ".join(objections + gaps) or "; ".join([f"by {best.scheme}", *named])
    limits = {(one.scheme, viscosity): value for one in evidence for viscosity, value in one.limits.items()}
    return Assessment(limits, best.value, budget, best.rate, scale, verdict, reason)


def _disagreements(best: Evidence, others: Sequence[Evidence], scale: float, accuracy: float) -> tuple[list[str], list[float]]:
    """The schemes that differ from the best by more than the error bars allow, and the distances of all."""
    distances = [distance(one.value, best.value) for one in others]
    sentences = []
    for one, apart in zip(others, distances, strict=True):
        # A scheme without an error bar of its own cannot excuse a distance with it.
        bars = best.error + (one.error if np.isfinite(one.error) else 0.0)
        if apart > max(bars, 0.5 * accuracy * scale):
            sentences.append(f"{one.scheme} differs by {apart / scale:.1e}, more than the error bars")
    return sentences, distances


def _absent(cells: Sequence[Cell], known: Sequence[Outcome]) -> dict[str, list[Cell]]:
    """For each scheme the members that have no value: they failed, or lost the wave."""
    there = {outcome.member.cell for outcome in known}
    return {
        scheme: [c for c in cells if c.scheme == scheme and c not in there]
        for scheme in dict.fromkeys(c.scheme for c in cells)
    }


def _words_of(scheme: str, cells: Sequence[Cell], absent: dict[str, list[Cell]]) -> str:
    """How many members of a scheme have no value, and on which grids."""
    sizes = ", ".join(str(size) for size in sorted({cell.size for cell in absent[scheme]}))
    total = sum(cell.scheme == scheme for cell in cells)
    return f"{len(absent[scheme])} of {total} members of {scheme} have no value (N = {sizes})"


def _independent_of(best: Evidence, evidence: Sequence[Evidence]) -> list[Evidence]:
    """That of schemes of another kind, whose runs are others too."""
    return [one for one in evidence if one.member.is_independent_of(best.member) and not one.runs & best.runs]


def _not_independent(
    best: Evidence, evidence: Sequence[Evidence], cells: Sequence[Cell], absent: dict[str, list[Cell]]
) -> list[str]:
    """Why no independent scheme bears the best one out, if so: it has to on every grid and with every viscosity of it."""
    if any(one.known >= best.known for one in _independent_of(best, evidence)):
        return []
    twins = [one.scheme for one in evidence if one is not best and one.runs & best.runs]
    dead = [scheme for scheme in absent if absent[scheme] and scheme != best.scheme]
    reasons = [f"{scheme} gives the same numbers as {best.scheme}, bit for bit" for scheme in twins]
    reasons += [_words_of(scheme, cells, absent) for scheme in dead]
    return [f"{reason}, and so it is no independent evidence" for reason in reasons] or ["no independent scheme has a value"]


def _unknown(reason: str) -> Assessment:
    return Assessment({}, np.array(np.nan), dict.fromkeys(BUDGET, np.nan), np.nan, 1.0, NOT_CONVERGED, reason)


def _summary(assessments: dict[str, dict[str, Assessment]]) -> xr.Dataset:
    import xarray as xr

    quantities = list(dict.fromkeys(name for table in assessments.values() for name in table))
    table = [[assessments[limit].get(name, _unknown("no member has a value")) for name in quantities] for limit in assessments]
    along = ("limit", "quantity")

    def column(name: str, entry: Any) -> tuple[tuple[str, str], Array, dict[str, str]]:
        return along, np.array([[entry(cell) for cell in row] for row in table], dtype=float), describe(name)

    return xr.Dataset(
        {
            "value": column("value", lambda cell: np.linalg.norm(cell.value) if cell.value.ndim else cell.value),
            "error": column("error", lambda cell: sum(cell.budget.values())),
            **{part: column(f"{part}_error", lambda cell, part=part: cell.budget[part]) for part in BUDGET},
            "rate": column("rate", lambda cell: cell.rate),
            "scale": column("scale", lambda cell: cell.scale),
            "verdict": (along, [[cell.verdict for cell in row] for row in table]),
            "reason": (along, [[cell.reason for cell in row] for row in table]),
        },
        {"limit": list(assessments), "quantity": quantities},
    )


def _profile(assessments: dict[str, dict[str, Assessment]], outcomes: Sequence[Outcome]) -> xr.Dataset:
    """The profile to which the members tend in each limit, and how far it may be from the truth."""
    import xarray as xr

    coarsest = min(outcomes, key=lambda outcome: outcome.member.size).member.simulation.grid
    unit = np.sqrt(coarsest.length / coarsest.size)  # of the outcomes, whose norm is that of the integral
    known = [assessments[limit].get("profile", _unknown("")) for limit in assessments]
    values = [np.broadcast_to(one.value / unit, coarsest.size) for one in known]
    x = (str(coarsest.dimension), coarsest.coordinates, describe("x"))
    profile = {"profile": (("limit", x[0]), values, describe("profile"))}
    return xr.Dataset(profile, {"limit": list(assessments), x[0]: x})


def _ladder(assessments: dict[str, dict[str, Assessment]], outcomes: Sequence[Outcome]) -> xr.Dataset:
    """The distance of each member with the tightest tolerance from its limit for h -> 0, relative to the scale."""
    import xarray as xr

    tightest = min((outcome.member.tolerance for outcome in outcomes), default=0.0)
    rows = [outcome for outcome in outcomes if outcome.member.tolerance == tightest]
    axes: dict[str, list[Any]] = {
        "limit": list(assessments),
        "scheme": list(dict.fromkeys(outcome.member.scheme for outcome in rows)),
        "viscosity": sorted({outcome.member.viscosity for outcome in rows}),
        "size": sorted({outcome.member.size for outcome in rows}),
        "quantity": list(dict.fromkeys(name for table in assessments.values() for name in table)),
    }
    error = xr.DataArray(np.full([len(axis) for axis in axes.values()], np.nan), axes, list(axes), attrs=describe("error"))
    for outcome in rows:
        member = outcome.member
        for name, assessment in assessments[member.limit].items():
            limit = assessment.limits.get((member.scheme, member.viscosity))
            if limit is not None and name in outcome.values:
                place = (member.limit, member.scheme, member.viscosity, member.size, name)
                error.loc[place] = distance(outcome.values[name], limit) / assessment.scale
    lengths = {outcome.member.size: outcome.member.simulation.grid.spacing for outcome in rows}
    return xr.Dataset({"distance": error, "spacing": ("size", [lengths[size] for size in axes["size"]], describe("spacing"))})
