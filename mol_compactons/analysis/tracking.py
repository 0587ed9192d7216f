"""Following the waves of a result: where they are, how tall, fast and wide, and what they leave behind.

A wave keeps its name through a collision by its sign and its height: of two bright waves the one that is the taller before is
the taller after. Between frames each is looked for where free flight would have taken it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.peaks import peaks
from mol_compactons.errors import require
from mol_compactons.grid import Grid, Lattice, ring_distance
from mol_compactons.results.reading import field_names, grid_of, outlines_of
from mol_compactons.results.schema import WaveOutline, describe

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

THRESHOLD = 0.05
"""Peaks lower than this, relative to the lowest wave at the start, are ripples."""

FARTHEST_MATCH = 3.5
"""A peak is taken for a wave if its distance from where the wave should be, in half-widths, and twice the logarithm of the
ratio of their heights add up to less than this: a wave may lose half its height in a collision, a ripple is no wave."""

SPEED_FRAMES = 5
"""How many frames of free flight give the speed with which the next place is foretold."""

FEWEST_FRAMES = 3
"""Frames of free flight without which no speed is measured."""


@dataclass
class _Wave:
    """What is known of a wave from its last frames of free flight."""

    sign: int
    position: float
    speed: float
    height: float
    width: float
    t: float = 0.0
    flight: list[tuple[float, float]] = field(default_factory=list)

    def foretold(self, t: float) -> float:
        """Where free flight takes it."""
        return self.position + self.speed * (t - self.t)

    def remember(self, t: float, position: float, height: float) -> None:
        """Take note of a frame of free flight."""
        self.flight = [*self.flight[1 - SPEED_FRAMES :], (t, position)]
        if len(self.flight) >= FEWEST_FRAMES:
            times, places = np.array(self.flight).T
            self.speed = float(np.polyfit(times - t, places, 1)[0])
        self.t, self.position, self.height = t, position, height


def track(dataset: xr.Dataset, *, least_height: float | None = None) -> xr.Dataset:
    """Follow the waves of a result from frame to frame.

    The waves are the compactons and solitary waves of the initial data or, where there are none, the peaks of the first frame.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result; its first component is followed.
    least_height : float, optional
        Peaks lower than this are ripples; by default 5 % of the lowest wave at the start.

    Returns
    -------
    xarray.Dataset
        Along t and wave: ``position`` (not wrapped: it goes on growing where a wave comes round again), ``height`` (signed),
        ``speed``, ``width`` (at half the height), NaN where a wave cannot be told from another; ``isolated``, whether its
        support is clear of the others. Along t: ``mass_left``, ``momentum_left`` and ``height_left``, the integral of the
        field, half that of its square and its largest size outside the supports of the waves, NaN unless all are isolated.
        The attribute ``lost`` names the waves that were not found in the last frame, though no other hides them.

    Raises
    ------
    InputError
        If there is no wave to follow, or the result is a chain in displacements.
    """
    import xarray as xr

    name = _field_to_follow(dataset, least_height)
    grid = grid_of(dataset)
    times, frames = dataset["t"].values, dataset[name].values
    waves = _waves_at_start(outlines_of(dataset), grid, times, frames, least_height)
    least = least_height or THRESHOLD * min(wave.height for wave in waves)
    shape = (times.size, len(waves))
    position, height, width = (np.full(shape, np.nan) for _ in range(3))
    isolated = np.zeros(shape, dtype=bool)
    left = np.full((3, times.size), np.nan)
    for index, (t, frame) in enumerate(zip(times, frames, strict=True)):
        position[index], height[index], width[index] = _match(waves, float(t), frame, grid, least)
        isolated[index] = _isolated(waves, position[index], float(t), grid.length)
        for wave, place, size, alone in zip(waves, position[index], height[index], isolated[index], strict=True):
            if alone:
                wave.remember(float(t), float(place), abs(float(size)))
        if isolated[index].all():
            left[:, index] = _left_behind(waves, position[index], frame, grid)
    along = ("t", "wave")
    return xr.Dataset(
        {
            "position": (along, position, describe("position") | {"period": float(grid.length)}),
            "height": (along, height, describe("height")),
            "speed": (along, _speeds(times, position, isolated), describe("speed")),
            "width": (along, width, describe("width")),
            "isolated": (along, isolated, describe("isolated")),
            **{
                f"{what}_left": ("t", values, describe(f"{what}_left"))
                for what, values in zip(("mass", "momentum", "height"), left, strict=True)
            },
        },
        {"t": ("t", times, describe("t")), "wave": ("wave", np.arange(len(waves)), describe("wave"))},
        {
            "simulation": dataset.attrs["simulation"],
            "field": name,
            "lost": _lost(waves, times, position, grid.length),
        },
    )


def _field_to_follow(dataset: xr.Dataset, least_height: float | None) -> str:
    """The field whose waves are followed, of a result in which there are any."""
    require(
        "simulation" in dataset.attrs and len(field_names(dataset)) > 0,
        "There is no field to follow waves in; give a result of run(), not a study or tracks.",
    )
    require(dataset.sizes["t"] > 0, "The result holds no frame; give one of a run that has begun.")
    require(
        least_height is None or least_height > 0, f"least_height = {least_height} must be positive, or None for the default."
    )
    name = field_names(dataset)[0]
    require(name != "Q", "Waves are followed in stresses, not in displacements; run the chain with form='stresses'.")
    return name


def _lost(waves: list[_Wave], times: Array, position: Array, length: float) -> str:
    """What is to be said of the waves that have no position in the last frame, and should not be in a collision there."""
    sentences = []
    clear = _clear(waves, position[-1], float(times[-1]), length)
    for wave, places in enumerate(position.T):
        if np.isnan(places[-1]) and clear[wave]:
            found = np.flatnonzero(~np.isnan(places))
            since = f"after t = {times[found[-1]]:.6g}" if found.size else "from the start"
            sentences.append(f"Wave {wave} is lost {since}: where it should be there is no peak of about its height.")
    return " ".join(sentences)


def _waves_at_start(
    outlines: list[WaveOutline], grid: Grid | Lattice, times: Array, frames: Array, least: float | None
) -> list[_Wave]:
    waves = [_Wave(wave.sign, wave.center, wave.speed, wave.height, wave.width) for wave in outlines]
    if not waves:
        first, second = frames[0], frames[min(1, len(frames) - 1)]
        lowest = least or 4 * THRESHOLD * float(np.abs(first).max())
        for sign in (1, -1):
            later = peaks(second, grid, sign, lowest)[0]
            for place, height, width in zip(*peaks(first, grid, sign, lowest), strict=True):
                gone = ring_distance(later, place, grid.length)
                moved = float(gone[np.argmin(np.abs(gone))]) if gone.size else 0.0
                speed = moved / float(times[1] - times[0]) if len(times) > 1 else 0.0
                waves.append(_Wave(sign, float(place), speed, float(height), 2 * float(width)))
    require(len(waves) > 0, "There is no wave to follow: the initial data hold no solitary wave, and the first frame no peak.")
    return waves


def _match(waves: list[_Wave], t: float, frame: Array, grid: Grid | Lattice, least: float) -> tuple[Array, Array, Array]:
    """Position, signed height and width of each wave in a frame; NaN for those without a peak of their own."""
    from scipy.optimize import linear_sum_assignment

    result = np.full((3, len(waves)), np.nan)
    for sign in (1, -1):
        members = [index for index, wave in enumerate(waves) if wave.sign == sign]
        positions, heights, widths = peaks(frame, grid, sign, least)
        if not members or not positions.size:
            continue
        foretold = np.array([waves[index].foretold(t) for index in members])[:, None]
        reach = np.array([waves[index].width / 2 for index in members])[:, None]
        before = np.array([waves[index].height for index in members])[:, None]
        distance = ring_distance(positions, foretold, grid.length)
        cost = np.abs(distance) / reach + 2 * np.abs(np.log(heights / before))
        for row, column in zip(*linear_sum_assignment(np.minimum(cost, 10 * FARTHEST_MATCH)), strict=True):
            if cost[row, column] < FARTHEST_MATCH:
                place = foretold[row, 0] + distance[row, column]
                result[:, members[row]] = place, sign * heights[column], widths[column]
    return result[0], result[1], result[2]


def _isolated(waves: list[_Wave], positions: Array, t: float, length: float) -> NDArray[np.bool_]:
    """Which waves were found and have their support clear of all others."""
    return np.asarray(_clear(waves, positions, t, length) & ~np.isnan(positions))


def _clear(waves: list[_Wave], positions: Array, t: float, length: float) -> NDArray[np.bool_]:
    """Which supports are clear of all others; those of waves that were not found are where free flight takes them."""
    places = np.array([wave.foretold(t) if math.isnan(x) else x for wave, x in zip(waves, positions, strict=True)])
    halves = np.array([wave.width / 2 for wave in waves])
    distance = np.abs(ring_distance(places[:, None], places, length))
    clear = distance >= halves[:, None] + halves
    np.fill_diagonal(clear, True)
    return np.asarray(clear.all(axis=1))


def _left_behind(waves: list[_Wave], positions: Array, frame: Array, grid: Grid | Lattice) -> tuple[float, float, float]:
    outside = np.ones(grid.size, dtype=bool)
    for wave, place in zip(waves, positions, strict=True):
        outside &= np.abs(grid.offset(float(place))) > wave.width / 2
    rest = np.where(outside, frame, 0.0)
    return grid.spacing * float(rest.sum()), 0.5 * grid.spacing * float(rest @ rest), float(np.abs(rest).max())


def _speeds(times: Array, position: Array, isolated: NDArray[np.bool_]) -> Array:
    """Central differences of the positions where a wave was isolated before and after."""
    places = np.where(isolated, position, np.nan)
    speed = np.full_like(places, np.nan)
    if times.size > 2:
        speed[1:-1] = (places[2:] - places[:-2]) / (times[2:] - times[:-2])[:, None]
    return speed
