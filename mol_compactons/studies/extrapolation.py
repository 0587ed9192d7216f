"""Richardson's extrapolation with an uncertainty: the limit of a few values as a parameter goes to zero.

Roache, Annu. Rev. Fluid Mech. 29 (1997) 123, doi:10.1146/annurev.fluid.29.1.123.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SAFETY = 1.25
"""Roache's factor of safety on an extrapolated error whose rate is regular."""

WIDE_SAFETY = 3.0
"""The factor on the largest difference where it is not."""

LOWEST_RATE = 0.4
MARGIN = 1.5
"""Observed rates from the lowest to the theoretical order times the margin are extrapolated with."""


@dataclass(frozen=True, eq=False)
class Extrapolation:
    """The limit of a sequence of values as a parameter goes to zero.

    Parameters
    ----------
    limit : array
        The limit, extrapolated where the rate is regular, else the last value.
    error : float
        How far from it the truth may be.
    rate : float
        The observed power of the parameter, NaN where the differences do not shrink or there are fewer than three values.
    shrinking : bool
        Whether the differences shrink.
    """

    limit: Array
    error: float
    rate: float
    shrinking: bool


def extrapolate(
    parameters: Sequence[float], values: Sequence[Array], order: float, cautious_order: float, floor: float = 0.0
) -> Extrapolation:
    """The limit of a sequence of values as its parameter goes to zero, by Richardson's extrapolation of the last three.

    Parameters
    ----------
    parameters : sequence of float
        Descending and positive.
    values : sequence of array
        One value, or profile, for each.
    order : float
        The power of the parameter that theory allows; a much higher observed rate is chance.
    cautious_order : float
        The error is not taken for smaller than it is with this power.
    floor : float
        Differences up to this are noise of another origin, which need not shrink. Parameters that are close to each other
        may hide an error in it that is many times as large.

    Returns
    -------
    Extrapolation
        With a single value the error is infinite, with two it is `WIDE_SAFETY` times their distance, or more if their
        parameters are close to each other.

    Examples
    --------
    >>> second_order = [np.array(1 + h**2) for h in (0.4, 0.2, 0.1)]
    >>> found = extrapolate([0.4, 0.2, 0.1], second_order, order=2, cautious_order=2)
    >>> print(f"{found.limit:.6f} {found.rate:.6f}")
    1.000000 2.000000
    """
    last = values[-1]
    if len(values) < 2:
        return Extrapolation(last, np.inf, np.nan, shrinking=False)
    fine = distance(values[-1], values[-2])
    # Parameters that are close to each other show only a small part of the error.
    wide = max(WIDE_SAFETY, SAFETY / ((parameters[-2] / parameters[-1]) ** cautious_order - 1))
    if len(values) < 3:
        return Extrapolation(last, wide * fine, np.nan, shrinking=False)
    coarse = distance(values[-2], values[-3])
    if max(coarse, fine) <= floor:
        hidden = wide * floor if wide > WIDE_SAFETY else SAFETY * max(coarse, fine)
        return Extrapolation(last, hidden, np.nan, shrinking=True)
    aligned = float(np.sum((values[-1] - values[-2]) * (values[-2] - values[-3]))) > 0
    rate = _rate(parameters[-3:], coarse / fine) if fine else np.nan
    if aligned and LOWEST_RATE <= rate <= MARGIN * order:
        ratio = parameters[-2] / parameters[-1]
        limit = last + (values[-1] - values[-2]) / (ratio**rate - 1)
        return Extrapolation(limit, SAFETY * fine / (ratio ** min(rate, cautious_order) - 1), rate, shrinking=True)
    shrinking = fine < 0.8 * coarse
    return Extrapolation(last, wide * max(coarse, fine), rate if shrinking else np.nan, shrinking)


def rest_of_changes(parameters: Sequence[float], values: Sequence[Array]) -> float:
    """How far the last of a few values may be from the limit if they are no smooth function of the parameter.

    The last change, or half of the one before it, if that is more: what need not shrink may agree by chance. And this times
    what is left of a change that dies like the parameter to the power `LOWEST_RATE`: about three if the parameter is halved,
    and many times as much if parameters are close to each other, which show only a small part of the error.

    Parameters
    ----------
    parameters : sequence of float
        Descending; the last one may be zero, where nothing is left beyond the last change.
    values : sequence of array
        One value, or profile, for each.

    Returns
    -------
    float
        Infinite for a single value.

    Examples
    --------
    >>> values = [np.array(h**0.4) for h in (0.4, 0.2, 0.1)]
    >>> print(f"{rest_of_changes([0.4, 0.2, 0.1], values):.4f}, the truth is {0.1**0.4:.4f} away")
    0.3981, the truth is 0.3981 away
    """
    changes = [distance(fine, coarse) for coarse, fine in pairwise(values)]
    if not changes:
        return np.inf
    change = max([changes[-1], *(0.5 * change for change in changes[-2:-1])])
    left = 1.0 if parameters[-1] == 0 else 1 / ((parameters[-2] / parameters[-1]) ** LOWEST_RATE - 1)
    return max(WIDE_SAFETY, left) * change


def distance(a: Array, b: Array) -> float:
    """The L2 distance of two values or profiles."""
    return float(np.linalg.norm(a - b))


def _rate(parameters: Sequence[float], ratio: float) -> float:
    """The p for which (h1^p - h2^p) / (h2^p - h3^p) is a given ratio of differences; NaN if there is none."""
    from scipy.optimize import brentq

    first, second, third = parameters
    if not first > second > third:
        return np.nan
    lowest, highest = 0.01, 20.0

    def mismatch(p: float) -> float:
        return float(np.log(((first / second) ** p - 1) / (1 - (third / second) ** p)) - np.log(ratio))

    if ratio <= 0 or mismatch(lowest) * mismatch(highest) > 0:
        return np.nan
    return float(brentq(mismatch, lowest, highest))
