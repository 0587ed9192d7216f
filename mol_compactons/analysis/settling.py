"""Whether a quantity of free flight has settled: three windows in time, and how far it may still go."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WINDOWS = 3
"""A change that shrinks is seen in two differences, and so in three windows."""

EARLIEST = 1 / 8
"""The windows begin no earlier than at this part of the time."""

FEWEST_FRAMES = 3
"""Frames without which a window gives no line and no scatter."""

FASTEST = 1.0
"""No change is taken to die faster than the time to this power, whatever the observed one: a tail may follow."""

SLOWEST = 0.3
"""A change that dies more slowly than this cannot be told from one that does not die."""

SAFETY = 1.25
WIDE_SAFETY = 3.0
ENDLESS = 10.0
"""The factors on what is left of a regular change, and on the largest one that swings or does not shrink."""


@dataclass(frozen=True, eq=False)
class Line:
    """A straight line through values along t.

    Parameters
    ----------
    t, value, slope : float
        The line is value + slope (t' - t), with t in the middle of its times.
    value_noise, slope_noise : float
        Their standard errors; residuals that keep their sign for long count as few independent ones.
    scatter : float
        The largest distance of a value from the line.
    """

    t: float
    value: float
    slope: float
    value_noise: float
    slope_noise: float
    scatter: float

    def at(self, t: float) -> float:
        """The line at a time."""
        return self.value + self.slope * (t - self.t)

    def noise_at(self, t: float) -> float:
        """The standard error there."""
        return float(np.hypot(self.value_noise, self.slope_noise * (t - self.t)))


def line_through(times: Array, values: Array) -> Line:
    """The line of least squares through two values or more."""
    t = float(times.mean())
    value, lever = float(values.mean()), float(np.sum((times - t) ** 2))
    slope = float((times - t) @ (values - value)) / lever
    residuals = values - value - slope * (times - t)
    runs = 1 + np.count_nonzero(residuals[1:] * residuals[:-1] < 0)
    variance = float(residuals @ residuals) / max(times.size - 2, 1) * times.size / runs
    noise = np.sqrt(np.array([variance / times.size, variance / lever]))
    return Line(t, value, slope, float(noise[0]), float(noise[1]), float(np.abs(residuals).max()))


def reading_noise(values: Array) -> float:
    """The standard error of one of a few values at equal times, that lie about a smooth course.

    The third differences of a smooth course are small, those of independent errors of the variance s^2 have 20 s^2.

    Parameters
    ----------
    values : array
        Four or more.

    Returns
    -------
    float
        NaN where there are fewer, or one of them is NaN.
    """
    thirds = np.diff(values, 3) if values.size > 3 else np.array([np.nan])
    return float(np.sqrt(np.mean(thirds * thirds) / 20))


def windows(times: Array, frames: NDArray[np.intp], since: float) -> list[NDArray[np.intp]]:
    """Three windows of free flight, whose ends follow each other by one ratio in the time since a moment.

    Parameters
    ----------
    times : array
        The times of all frames.
    frames : array of int
        Those of the free flight.
    since : float
        The moment at which what has to settle began.

    Returns
    -------
    list of array
        The frames of each window; none where one would have fewer than `FEWEST_FRAMES`.
    """
    if frames.size < WINDOWS * FEWEST_FRAMES:
        return []
    gone = times[frames] - since
    first = max(float(gone[0]), EARLIEST * float(gone[-1]))
    if not 0 < first < gone[-1]:
        return []
    ends = np.geomspace(first, float(gone[-1]), WINDOWS + 1)
    places = np.searchsorted(gone, ends * (1 - 1e-9))
    places[-1] = gone.size
    parts = [frames[start:end] for start, end in pairwise(places)]
    return parts if min(part.size for part in parts) >= FEWEST_FRAMES else []


def remaining(times: Array, values: Array, noise: float) -> float:
    """How far from the value in its last window a quantity may still go.

    A change that shrinks from window to window like t^-p, p <= 1, has |late| / ((t3 / t2)^p - 1) before it; one within the
    noise is taken for the largest that the noise may hide, with p = 1; one that swings counts three times, and one that does
    not shrink ten times.

    Parameters
    ----------
    times, values : array, shape (3,)
        The middles of the windows, since the moment at which the change began, and the quantity there.
    noise : float
        The standard error of a value.

    Returns
    -------
    float
        NaN where a value is.

    Examples
    --------
    >>> times = np.array([10.0, 20.0, 40.0])
    >>> print(f"{remaining(times, 2 + 1 / times, 0.0):.4f}, the truth is {1 / 40:.4f} away")
    0.0312, the truth is 0.0250 away
    """
    if np.isnan(values).any() or np.isnan(times).any():
        return np.nan
    early, late = np.diff(values)
    largest = float(np.abs([early, late]).max())
    ratio = float(times[2] / times[1])
    if largest <= 2 * noise:
        return SAFETY * max(largest, noise) / min(ratio - 1, 1.0)
    if early * late <= 0:
        return WIDE_SAFETY * largest + noise
    rate = float(np.log(early / late) / (0.5 * np.log(times[2] / times[0])))
    if rate < SLOWEST:
        return ENDLESS * largest + noise
    return float(SAFETY * abs(late) / (ratio ** min(rate, FASTEST) - 1)) + noise
