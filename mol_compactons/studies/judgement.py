"""How much of a result is real: a family of runs, an error budget for each quantity, and a verdict.

For each limit and each scheme the values on three grids or more give an observed rate and, by Richardson's extrapolation, a
limit for h -> 0 with an uncertainty (Roache, Annu. Rev. Fluid Mech. 29 (1997) 123, doi:10.1146/annurev.fluid.29.1.123).
Viscosities, tolerances and schemes give one more part of the budget each, and nothing is called converged unless each
that matters was varied, independent schemes agree, and the whole budget is below the accuracy asked for.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.collisions import first_collision
from mol_compactons.analysis.drift import drift
from mol_compactons.configuration import decode, encode
from mol_compactons.results.reading import field_names
from mol_compactons.results.schema import describe
from mol_compactons.simulation import Simulation
from mol_compactons.studies.extrapolation import WIDE_SAFETY, Extrapolation, distance, extrapolate
from mol_compactons.studies.family import CONSERVATIVE, INVISCID, Family, Member

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

CONVERGED, CONVERGING, NOT_CONVERGED = "converged", "converging", "not converged"

CAUTIOUS_ORDER = 2.0
"""No error of the grid is taken for smaller than one of this order, whatever the observed rate."""

BUDGET = ("space", "time", "viscosity", "scheme")


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a member of a family came to.

    Parameters
    ----------
    member : Member
        The member.
    values : dict of str to array
        Each quantity: a number, or a profile on the points of the coarsest grid.
    scales : dict of str to float
        What an error of each is compared with.
    """

    member: Member
    values: dict[str, Array]
    scales: dict[str, float]


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
    outcomes = [_outcome(member.to_dataset(), family.sizes[0]) for member in members.values()]
    assessments = {limit: _assess(family, [o for o in outcomes if o.member.limit == limit]) for limit in family.limits}
    root = xr.Dataset(attrs=study.attrs | {"family": json.dumps(encode(family))})
    groups = {f"/members/{name}": member.to_dataset() for name, member in members.items()}
    own = {"/": root, "/summary": _summary(assessments), "/ladder": _ladder(assessments, outcomes), "/members": xr.Dataset()}
    return xr.DataTree.from_dict(own | groups)


def _outcome(result: xr.Dataset, coarsest: int) -> Outcome:
    simulation = Simulation.from_json(str(result.attrs["simulation"]))
    kind, scheme = str(result.attrs["limit"]), str(result.attrs["scheme"])
    member = Member(kind, scheme, float(result.attrs["viscosity"]), float(result.attrs["tolerance"]), simulation)
    profile = _on_grid(result[field_names(result)[0]].values, coarsest) * np.sqrt(simulation.grid.length / coarsest)
    values, scales = {"profile": profile}, {"profile": float(np.linalg.norm(profile))}
    for quantity, change in drift(result).data_vars.items():
        values[f"{quantity} drift"], scales[f"{quantity} drift"] = np.array(float(change[-1])), 1.0
    if "position" in result:
        _add_waves(values, scales, result, simulation)
    return Outcome(member, values, scales)


def _add_waves(values: dict[str, Array], scales: dict[str, float], tracks: xr.Dataset, simulation: Simulation) -> None:
    """Add what the tracks say about each wave, once it has settled, and about what it left behind."""
    collision = first_collision(tracks)
    first, spacing = simulation.initial_state()[0], simulation.grid.spacing
    for wave in range(tracks.sizes["wave"]):
        one = collision.isel(wave=wave)
        collided = not np.isnan(one.phase_shift)
        when, label = ("after", f"{wave} after") if collided else ("before", f"{wave}")
        width = float(tracks.width[0, wave])
        quantities = {
            f"height {label}": (one[f"height_{when}"], abs(float(tracks.height[0, wave]))),
            f"speed {label}": (one[f"speed_{when}"], abs(float(one.speed_before))),
            f"position {wave}": (tracks.position[-1, wave], width),
        }
        if collided:
            quantities[f"phase shift {wave}"] = one.phase_shift, width
        for name, (value, scale) in quantities.items():
            values[name], scales[name] = np.array(float(value)), scale
    totals = {"mass": np.abs(first).sum() * spacing, "momentum": 0.5 * spacing * first @ first, "height": np.abs(first).max()}
    for name, total in totals.items():
        after = collision[f"{name}_left"]
        values[f"{name} left"] = np.array(float(tracks[f"{name}_left"][-1] if np.isnan(after) else after))
        scales[f"{name} left"] = float(total)


def _on_grid(profile: Array, size: int) -> Array:
    """A periodic profile on a coarser grid with the same first point, by a cubic spline where the points do not coincide."""
    if profile.size % size == 0:
        return profile[:: profile.size // size]
    from scipy.interpolate import CubicSpline

    places = np.arange(profile.size + 1) / profile.size
    return np.asarray(CubicSpline(places, np.append(profile, profile[0]), bc_type="periodic")(np.arange(size) / size))


@dataclass(frozen=True, eq=False)
class Evidence:
    """What one scheme says about one quantity in one limit.

    Irregularities are differences that do not shrink, gaps what was not varied; `limits` are those for h -> 0 by viscosity.
    """

    scheme: str
    limits: dict[float, Array]
    value: Array
    budget: dict[str, float]
    rate: float
    irregularities: tuple[str, ...]
    gaps: tuple[str, ...]

    @property
    def error(self) -> float:
        """The sum of the budget."""
        return sum(self.budget.values())


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


def _assess(family: Family, outcomes: Sequence[Outcome]) -> dict[str, Assessment]:
    """The judgement of each quantity that any member has."""
    quantities = dict.fromkeys(name for outcome in outcomes for name in outcome.values)
    return {name: _weigh(name, family, outcomes) for name in quantities}


def _weigh(quantity: str, family: Family, outcomes: Sequence[Outcome]) -> Assessment:
    known = [outcome for outcome in outcomes if not np.isnan(outcome.values.get(quantity, np.array(np.nan))).any()]
    schemes = dict.fromkeys(outcome.member.scheme for outcome in known)
    evidence = [_gather(quantity, [o for o in known if o.member.scheme == scheme]) for scheme in schemes]
    if not evidence:
        return _unknown("no member has a value")
    best = min(evidence, key=lambda one: (len(one.gaps), one.error, one.scheme))
    scale = max(outcome.scales[quantity] for outcome in known)
    objections, gaps = [], list(best.gaps)
    others = [one for one in evidence if one.scheme.split("(")[0] != best.scheme.split("(")[0]]
    distances = [distance(one.value, best.value) for one in others]
    allowed = family.accuracy * scale
    for one, apart in zip(others, distances, strict=True):
        # A scheme without an error bar of its own cannot excuse a distance with it.
        bars = best.error + (one.error if np.isfinite(one.error) else 0.0)
        if apart > max(bars, allowed / 2):
            objections.append(f"{one.scheme} differs by {apart / scale:.1e}, more than the error bars")
    if not others and known[0].member.simulation.scheme.refines:
        gaps.append("no independent scheme has a value")
    budget = best.budget | {"scheme": max(distances, default=0.0)}
    error = sum(budget.values())
    if error > scale:
        objections.append("the error is larger than what it is measured against")
    if error > allowed:
        objections += best.irregularities
        gaps.append(f"the error is {error / scale:.1e}, above the accuracy {family.accuracy:g}")
    verdict = NOT_CONVERGED if objections else CONVERGING if gaps else CONVERGED
    reason = "; ".join(objections + gaps) or f"by {best.scheme}"
    limits = {(one.scheme, viscosity): value for one in evidence for viscosity, value in one.limits.items()}
    return Assessment(limits, best.value, budget, best.rate, scale, verdict, reason)


def _unknown(reason: str) -> Assessment:
    return Assessment({}, np.array(np.nan), dict.fromkeys(BUDGET, np.nan), np.nan, 1.0, NOT_CONVERGED, reason)


def _error_of_time(
    quantity: str, outcomes: Sequence[Outcome], precise: Sequence[Outcome], viscosity: float
) -> tuple[float, list[str]]:
    """How far the next tolerance is from the tightest on the finest grid that has both, and what is missing."""
    for one in sorted(precise, key=lambda outcome: -outcome.member.size):
        same = [o for o in outcomes if (o.member.size, o.member.viscosity) == (one.member.size, viscosity)]
        looser = [o for o in same if o.member.tolerance > one.member.tolerance]
        if looser and one.member.viscosity == viscosity:
            nearest = min(looser, key=lambda outcome: outcome.member.tolerance)
            return distance(nearest.values[quantity], one.values[quantity]), []
    return 0.0, ["only one tolerance"]


def _gather(quantity: str, outcomes: Sequence[Outcome]) -> Evidence:
    """Extrapolate the values of one scheme in h for each viscosity, and then in the viscosity."""
    if not outcomes[0].member.simulation.scheme.refines:
        return _gather_in_time(quantity, outcomes)
    tightest = min(outcome.member.tolerance for outcome in outcomes)
    precise = [outcome for outcome in outcomes if outcome.member.tolerance == tightest]
    viscosities = sorted({outcome.member.viscosity for outcome in precise}, reverse=True)
    time_error, gaps = _error_of_time(quantity, outcomes, precise, viscosities[-1])
    order = outcomes[0].member.simulation.scheme.formal_order
    floor = 2 * time_error + 1e-12 * max(outcome.scales[quantity] for outcome in outcomes)
    limits: dict[float, Extrapolation] = {}
    ladder: list[Outcome] = []
    for viscosity in viscosities:
        ladder = sorted((o for o in precise if o.member.viscosity == viscosity), key=lambda outcome: outcome.member.size)
        spacings = [outcome.member.simulation.grid.spacing for outcome in ladder]
        values = [outcome.values[quantity] for outcome in ladder]
        limits[viscosity] = extrapolate(spacings, values, order, CAUTIOUS_ORDER, floor)
    by_viscosity = list(limits.values())
    space = by_viscosity[-1]
    irregularities = []
    if len(ladder) < 3:
        gaps.append(f"only {len(ladder)} grid(s) ran to the end")
        irregularities.append("with fewer than three grids nothing shows that their differences shrink")
    elif not space.shrinking:
        irregularities.append("the differences between the grids do not shrink")
    value, viscous = space.limit, 0.0
    limit = outcomes[0].member.limit
    if limit != INVISCID:
        if len(limits) < 2:
            gaps.append("only one viscosity")
        elif limit == CONSERVATIVE:
            viscous = distance(space.limit, by_viscosity[-2].limit)
        else:
            in_viscosity = _extrapolate_viscosity(list(limits), [one.limit for one in by_viscosity])
            value, viscous = in_viscosity.limit, in_viscosity.error
            if not in_viscosity.shrinking:
                irregularities.append("the differences between the viscosities do not shrink")
    budget = {"space": space.error, "time": time_error, "viscosity": viscous}
    at_rest = {viscosity: one.limit for viscosity, one in limits.items()}
    return Evidence(outcomes[0].member.scheme, at_rest, value, budget, space.rate, tuple(irregularities), tuple(gaps))


def _gather_in_time(quantity: str, outcomes: Sequence[Outcome]) -> Evidence:
    """The same of a chain, which has no grid to refine: its ladder is that of the tolerances or steps."""
    ladder = sorted(outcomes, key=lambda outcome: -outcome.member.tolerance)
    values = [outcome.values[quantity] for outcome in ladder]
    changes = [distance(fine, coarse) for coarse, fine in pairwise(values)]
    noise = 1e-12 * max(outcome.scales[quantity] for outcome in outcomes)
    growing = len(changes) > 1 and changes[-1] > max(changes[-2], noise)
    irregularities = ("the differences between the tolerances do not shrink",) if growing else ()
    gaps = () if changes else ("only one tolerance ran to the end",)
    # An error need not follow the tolerance: half of the change before the last one counts as well.
    error = WIDE_SAFETY * max([changes[-1], *(0.5 * change for change in changes[-2:-1])]) if changes else np.inf
    budget = {"space": 0.0, "time": error, "viscosity": 0.0}
    scheme = ladder[-1].member.scheme
    return Evidence(scheme, {0.0: values[-1]}, values[-1], budget, np.nan, irregularities, gaps)


def _extrapolate_viscosity(viscosities: Sequence[float], limits: Sequence[Array]) -> Extrapolation:
    """The limit eps -> 0; of two values linearly, with the whole correction as error."""
    if viscosities[-1] == 0:
        return Extrapolation(limits[-1], 0.0, np.nan, shrinking=True)
    if len(limits) > 2:
        return extrapolate(viscosities, limits, order=1, cautious_order=1)
    correction = (limits[-1] - limits[-2]) * viscosities[-1] / (viscosities[-2] - viscosities[-1])
    return Extrapolation(limits[-1] + correction, float(np.linalg.norm(correction)), np.nan, shrinking=True)


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
