"""What one scheme says about one quantity in one limit: its value and the parts of its error budget that it can tell."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.settling import remaining
from mol_compactons.studies.extrapolation import WIDE_SAFETY, Extrapolation, distance, extrapolate, rest_of_changes
from mol_compactons.studies.family import CONSERVATIVE, INVISCID, Member
from mol_compactons.studies.outcome import LARGEST_VALUES, Course, Outcome

Array = NDArray[np.float64]

CAUTIOUS_ORDER = 2.0
"""No error of the grid is taken for smaller than one of this order, whatever the observed rate."""

Values = Callable[[Outcome], Array]
"""What is extrapolated of an outcome."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """What one scheme says about one quantity in one limit.

    Irregularities are differences that do not shrink, gaps what was not varied; `limits` are those for h -> 0 by viscosity,
    `known` the members that have a value at the tightest tolerance, `runs` their fingerprints.
    """

    scheme: str
    member: Member
    limits: dict[float, Array]
    value: Array
    budget: dict[str, float]
    rate: float
    irregularities: tuple[str, ...]
    gaps: tuple[str, ...]
    known: frozenset[tuple[int, float]]
    runs: frozenset[str]

    @property
    def error(self) -> float:
        """The sum of the budget."""
        return sum(self.budget.values())


def gather(quantity: str, outcomes: Sequence[Outcome]) -> Evidence:
    """The evidence of outcomes of one scheme: extrapolated in h for each viscosity, and then in the viscosity.

    Parameters
    ----------
    quantity : str
        Its name.
    outcomes : sequence of Outcome
        Those of one scheme in one limit that have a value of it.
    """
    if not outcomes[0].member.simulation.scheme.refines:
        return _gather_in_time(quantity, outcomes)
    tightest = min(outcome.member.tolerance for outcome in outcomes)
    precise = _distinct([outcome for outcome in outcomes if outcome.member.tolerance == tightest])
    viscosities = sorted({outcome.member.viscosity for outcome in precise}, reverse=True)
    time_error, gaps = _error_of_time(quantity, outcomes, precise, viscosities[-1])
    reading = _reading(quantity, _finest(precise))
    noise = 2 * time_error + (reading if np.isfinite(reading) else 0.0)
    floor = noise + 1e-12 * max(outcome.scales[quantity] for outcome in outcomes)
    limits = _limits(precise, lambda outcome: outcome.values[quantity], floor)
    if quantity in LARGEST_VALUES:
        limits = _not_extrapolated(quantity, precise, limits)
    irregularities, missing = _irregularities(limits[viscosities[-1]], precise)
    value, viscous, irregular, also_missing = _without_viscosity(
        outcomes[0].member.limit, limits, smooth=quantity not in LARGEST_VALUES
    )
    settling, unknown = _settling(quantity, outcomes[0].member.limit, precise, floor)
    space = limits[viscosities[-1]]
    return Evidence(
        outcomes[0].member.scheme,
        outcomes[0].member,
        {viscosity: one.limit for viscosity, one in limits.items()},
        value,
        {"space": space.error, "time": time_error, "viscosity": viscous, "settling": settling, "reading": reading},
        space.rate,
        tuple(irregularities + irregular),
        tuple(gaps + missing + also_missing + unknown),
        frozenset((outcome.member.size, outcome.member.viscosity) for outcome in precise),
        frozenset(outcome.fingerprint for outcome in outcomes),
    )


def _distinct(outcomes: Sequence[Outcome]) -> list[Outcome]:
    """The outcomes without those that are another with a smaller viscosity, bit for bit."""
    found: list[Outcome] = []
    for outcome in sorted(outcomes, key=lambda outcome: outcome.member.viscosity):
        if not any(outcome.is_same_run_as(other) for other in found):
            found.append(outcome)
    return found


def _finest(outcomes: Sequence[Outcome]) -> Outcome:
    """The one with the most points and, of these, the smallest viscosity."""
    return max(outcomes, key=lambda outcome: (outcome.member.size, -outcome.member.viscosity))


def _reading(quantity: str, outcome: Outcome) -> float:
    """How exactly a quantity is read from the frames."""
    reading = outcome.readings.get(quantity, 0.0)
    return np.inf if np.isnan(reading) else reading


def _ladder(outcomes: Sequence[Outcome], viscosity: float) -> list[Outcome]:
    """The outcomes of one viscosity, coarse grids first."""
    return sorted((o for o in outcomes if o.member.viscosity == viscosity), key=lambda outcome: outcome.member.size)


def _limits(precise: Sequence[Outcome], values: Values, floor: float) -> dict[float, Extrapolation]:
    """What something tends to for h -> 0, for each viscosity, the largest first."""
    order = precise[0].member.simulation.scheme.formal_order
    limits = {}
    for viscosity in sorted({outcome.member.viscosity for outcome in precise}, reverse=True):
        ladder = _ladder(precise, viscosity)
        spacings = [outcome.member.simulation.grid.spacing for outcome in ladder]
        limits[viscosity] = extrapolate(spacings, [values(outcome) for outcome in ladder], order, CAUTIOUS_ORDER, floor)
    return limits


def _not_extrapolated(
    quantity: str, precise: Sequence[Outcome], limits: dict[float, Extrapolation]
) -> dict[float, Extrapolation]:
    """The values on the finest grid, which is all that is known of the largest of many.

    Their error is what the changes leave open that no rate is known of, and no less than the range of all on the two finest
    grids.
    """
    finest = sorted({outcome.member.size for outcome in precise})[-2:]
    spread = float(np.ptp([outcome.values[quantity] for outcome in precise if outcome.member.size in finest]))
    bare = {}
    for viscosity, one in limits.items():
        ladder = _ladder(precise, viscosity)
        values = [outcome.values[quantity] for outcome in ladder]
        error = max(spread, rest_of_changes([outcome.member.simulation.grid.spacing for outcome in ladder], values))
        bare[viscosity] = Extrapolation(values[-1], error, np.nan, one.shrinking)
    return bare


def _last_change(changes: Sequence[float]) -> float:
    """The last change or half of the one before it, if that is more: what need not shrink may agree by chance."""
    return max([changes[-1], *(0.5 * change for change in changes[-2:-1])])


def _irregularities(space: Extrapolation, precise: Sequence[Outcome]) -> tuple[list[str], list[str]]:
    """What is irregular about the grids of the smallest viscosity, and what is missing."""
    grids = len(_ladder(precise, min(outcome.member.viscosity for outcome in precise)))
    if grids < 3:
        return ["with fewer than three grids nothing shows that their differences shrink"], [
            f"only {grids} grid(s) ran to the end"
        ]
    return ([] if space.shrinking else ["the differences between the grids do not shrink"]), []


def _without_viscosity(
    limit: str, limits: dict[float, Extrapolation], smooth: bool = True
) -> tuple[Array, float, list[str], list[str]]:
    """The value in a limit, the part of its error from the viscosity, what is irregular, and what is missing.

    What is not smooth is not extrapolated.
    """
    (*_, smallest), (*_, space) = limits, limits.values()
    if limit == INVISCID:
        return space.limit, 0.0, [], []
    if len(limits) < 2:
        return space.limit, 0.0, [], ["only one viscosity"]
    if limit == CONSERVATIVE:
        larger = list(limits)[-2]
        # Viscosities that are close to each other show only a part of what the smaller one does.
        part = max(1.0, smallest / (larger - smallest))
        return space.limit, part * distance(space.limit, limits[larger].limit), [], []
    values = [one.limit for one in limits.values()]
    if not smooth:
        return values[-1], rest_of_changes(list(limits), values), [], []
    found = _extrapolate_viscosity(list(limits), values)
    return found.limit, found.error, [] if found.shrinking else ["the differences between the viscosities do not shrink"], []


def _extrapolate_viscosity(viscosities: Sequence[float], limits: Sequence[Array]) -> Extrapolation:
    """The limit eps -> 0; of two values linearly, with the whole correction as error."""
    if viscosities[-1] == 0:
        return Extrapolation(limits[-1], 0.0, np.nan, shrinking=True)
    if len(limits) > 2:
        return extrapolate(viscosities, limits, order=1, cautious_order=1)
    correction = (limits[-1] - limits[-2]) * viscosities[-1] / (viscosities[-2] - viscosities[-1])
    return Extrapolation(limits[-1] + correction, float(np.linalg.norm(correction)), np.nan, shrinking=True)


def _settling(quantity: str, limit: str, precise: Sequence[Outcome], floor: float) -> tuple[float, list[str]]:
    """How far a quantity still is from what it tends to, and what is missing to tell.

    The windows are extrapolated like the quantity itself: what the grid or the viscosity goes on changing is not counted here.
    """
    finest = _finest(precise)
    if quantity not in finest.courses:
        return 0.0, []
    known = [outcome for outcome in precise if not np.isnan(outcome.courses[quantity].values).any()]
    if finest not in known:
        return np.inf, [
            "its free flight has too few frames to tell whether it has settled; choose more frames or a longer t_end"
        ]
    course = finest.courses[quantity]

    def limit_of(part: Callable[[Course], float]) -> float:
        return float(_without_viscosity(limit, _limits(known, lambda o: np.array(part(o.courses[quantity])), floor))[0])

    windows = np.array([limit_of(partial(_in_window, window=window)) for window in range(course.values.size)])
    least = abs(limit_of(attrgetter("least")))
    return max(remaining(course.t, windows, course.noise), least), []


def _in_window(course: Course, window: int) -> float:
    return float(course.values[window])


def _error_of_time(
    quantity: str, outcomes: Sequence[Outcome], precise: Sequence[Outcome], viscosity: float
) -> tuple[float, list[str]]:
    """How far the next tolerance is from the tightest on the finest grid that has both, and what is missing."""
    for one in sorted(precise, key=lambda outcome: -outcome.member.size):
        same = [o for o in outcomes if (o.member.size, o.member.viscosity) == (one.member.size, viscosity)]
        looser = [o for o in same if o.member.tolerance > one.member.tolerance and not o.has_the_steps_of(one)]
        if looser and one.member.viscosity == viscosity:
            nearest = min(looser, key=lambda outcome: outcome.member.tolerance)
            return _part_of(nearest, one) * distance(nearest.values[quantity], one.values[quantity]), []
    return 0.0, ["only one tolerance"]


def _part_of(looser: Outcome, tighter: Outcome) -> float:
    """What the distance of two tolerances is multiplied by: those close to each other show only a part of the error."""
    return max(1.0, tighter.member.tolerance / (looser.member.tolerance - tighter.member.tolerance))


def _gather_in_time(quantity: str, outcomes: Sequence[Outcome]) -> Evidence:
    """The same of a chain, which has no grid to refine: its ladder is that of the tolerances or steps."""
    ladder: list[Outcome] = []
    for outcome in sorted(outcomes, key=lambda outcome: -outcome.member.tolerance):
        if ladder and ladder[-1].has_the_steps_of(outcome):
            continue
        ladder.append(outcome)
    steps = list(pairwise(ladder))
    changes = [_part_of(coarse, fine) * distance(fine.values[quantity], coarse.values[quantity]) for coarse, fine in steps]
    noise = 1e-12 * max(outcome.scales[quantity] for outcome in outcomes)
    growing = len(changes) > 1 and changes[-1] > max(changes[-2], noise)
    irregularities = ("the differences between the tolerances do not shrink",) if growing else ()
    gaps = [] if changes else ["only one tolerance ran to the end"]
    # An error need not follow the tolerance: half of the change before the last one counts as well.
    error = WIDE_SAFETY * _last_change(changes) if changes else np.inf
    last = ladder[-1]
    settling, unknown = _settling(quantity, INVISCID, [last], noise)
    budget = {"space": 0.0, "time": error, "viscosity": 0.0, "settling": settling, "reading": _reading(quantity, last)}
    value, known = last.values[quantity], frozenset([(last.member.size, last.member.viscosity)])
    return Evidence(
        *(last.member.scheme, last.member, {0.0: value}, value, budget, np.nan),
        *(irregularities, tuple(gaps + unknown), known, frozenset(outcome.fingerprint for outcome in outcomes)),
    )
