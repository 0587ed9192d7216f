"""Following the waves of a result: where they are, how tall, fast and wide, what a collision did to them and left behind.

A wave keeps its name through a collision by its sign and its height: of two bright waves the one that is the taller before is
the taller after. Between frames each is looked for where free flight would have taken it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.dataset import describe, field_names
from mol_compactons.errors import require
from mol_compactons.grid import Grid, Lattice, ring_distance
from mol_compactons.simulation import Simulation
from mol_compactons.waves import LocalizedWave

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
"""Frames of free flight on either side without which a collision has no phase shift."""

SHORTEST_FLIGHT = 2 * FEWEST_FRAMES
"""Free flight of fewer frames than this does not end a collision."""


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


def peaks(values: Array, grid: Grid | Lattice, sign: int, least: float) -> tuple[Array, Array, Array]:
    """The peaks of one sign, with the position of each between the points, from a quartic through five of them.

    Parameters
    ----------
    values : array, shape (N,)
        A field on a periodic grid.
    grid : Grid or Lattice
        The grid.
    sign : {1, -1}
        Crests or troughs.
    least : float
        The least height and prominence of a peak.

    Returns
    -------
    positions, heights, widths : arrays, one entry for each peak
        Heights count from zero and are positive for either sign; widths are those at half the height.
    """
    from scipy.signal import find_peaks, peak_widths

    turned = sign * np.asarray(values, dtype=float)
    start = int(np.argmin(turned))
    rolled = np.append(np.roll(turned, -start), turned[start])
    places, _ = find_peaks(rolled, height=least, prominence=least)
    if not places.size:
        return (np.empty(0),) * 3
    width = peak_widths(
        rolled,
        places,
        rel_height=0.5,
        prominence_data=(rolled[places], np.zeros_like(places), np.full_like(places, grid.size)),
    )[0]
    around = turned[(places[:, None] + start + np.arange(-2, 3)) % grid.size]
    offsets, heights = _summits(around)
    positions = grid.coordinates[0] + grid.spacing * (((places + start) % grid.size) + offsets)
    return positions, heights, grid.spacing * width


def _summits(around: Array) -> tuple[Array, Array]:
    """Place and height of the top of the quartics through five points each, shape (peaks, 5), in units of the spacing."""
    coefficients = np.linalg.solve(np.vander(np.arange(-2.0, 3.0)), around.T)
    slope = np.arange(4.0, 0.0, -1.0)[:, None] * coefficients[:-1]
    curvature = np.arange(3.0, 0.0, -1.0)[:, None] * slope[:-1]
    offsets = np.zeros(around.shape[0])
    for _ in range(6):
        bend = np.minimum(_polynomial(curvature, offsets), -1e-300)
        offsets = np.clip(offsets - _polynomial(slope, offsets) / bend, -1.0, 1.0)
    return offsets, _polynomial(coefficients, offsets)


def _polynomial(coefficients: Array, x: Array) -> Array:
    """One polynomial for each column, highest power first."""
    value = np.zeros_like(x)
    for row in coefficients:
        value = value * x + row
    return value


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

    require(
        "simulation" in dataset.attrs and len(field_names(dataset)) > 0,
        "There is no field to follow waves in; give a result of run(), not a study or tracks.",
    )
    simulation = Simulation.from_json(str(dataset.attrs["simulation"]))
    require(
        simulation.equation.variables[0] != "Q",
        "Waves are followed in stresses, not in displacements; run the chain with form='stresses'.",
    )
    grid = simulation.grid
    name = field_names(dataset)[0]
    times, frames = dataset["t"].values, dataset[name].values
    waves = _waves_at_start(simulation, times, frames, least_height)
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
            "position": (along, position, describe("position")),
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
        {"simulation": dataset.attrs["simulation"], "field": name, "lost": _lost(waves, times, position, grid.length)},
    )


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


def _waves_at_start(simulation: Simulation, times: Array, frames: Array, least: float | None) -> list[_Wave]:
    waves = []
    for wave in simulation.initial:
        if isinstance(wave, LocalizedWave):
            height, width = wave.outline(simulation.equation)
            waves.append(_Wave(wave.sign, wave.center, wave.speed, abs(height), width))
    if not waves:
        first, second = frames[0], frames[min(1, len(frames) - 1)]
        lowest = least or 4 * THRESHOLD * float(np.abs(first).max())
        for sign in (1, -1):
            later = peaks(second, simulation.grid, sign, lowest)[0]
            for place, height, width in zip(*peaks(first, simulation.grid, sign, lowest), strict=True):
                gone = ring_distance(later, place, simulation.grid.length)
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


def first_collision(tracks: xr.Dataset) -> xr.Dataset:
    """What the first collision of each wave did to it.

    Straight lines through the positions in free flight, before the collision and in the second half of the time from it to
    the next, when the waves have settled, give the speeds. The moment of a collision is when the incoming lines meet; there
    the outgoing line lies ahead of the incoming one by the phase shift.

    Parameters
    ----------
    tracks : xarray.Dataset
        What `track` returned.

    Returns
    -------
    xarray.Dataset
        Along wave: ``moment``, ``phase_shift``, ``speed_before``, ``speed_after``, ``height_before``, ``height_after`` (means
    over the same times), ``scatter`` (the largest distance of a position from its line); NaN for what there is not: a wave
        that did not collide has no values after. ``mass_left``, ``momentum_left``, ``height_left``: means over the
        settled time after the last of these collisions, NaN without one.
    """
    import xarray as xr

    require("wave" in tracks.sizes, "There are no tracks; give what track() returned.")
    times = tracks["t"].values
    waves = tracks.sizes["wave"]
    names = ("moment", "phase_shift", "speed_before", "speed_after", "height_before", "height_after", "scatter")
    values = {name: np.full(waves, np.nan) for name in names}
    length = Simulation.from_json(tracks.attrs["simulation"]).grid.length
    flights = [_free_flights(tracks["isolated"].values[:, wave]) for wave in range(waves)]
    lines = [[_line(times, tracks["position"].values[:, wave], flight) for flight in flights[wave]] for wave in range(waves)]
    for wave in range(waves):
        height = tracks["height"].values[:, wave]
        if lines[wave]:
            before, values["scatter"][wave] = lines[wave][0]
            values["speed_before"][wave] = before[0]
            values["height_before"][wave] = height[flights[wave][0]].mean()
        if len(lines[wave]) < 2:
            continue
        after, scatter = lines[wave][1]
        gap = 0.5 * (times[flights[wave][0][-1]] + times[flights[wave][1][0]])
        others = [line[0][0] for other, line in enumerate(lines) if other != wave and line]
        moment = _moment(before, others, float(gap), length)
        values["moment"][wave] = moment
        values["phase_shift"][wave] = np.polyval(after, moment) - np.polyval(before, moment)
        values["speed_after"][wave] = after[0]
        values["height_after"][wave] = height[flights[wave][1]].mean()
        values["scatter"][wave] = max(values["scatter"][wave], scatter)
    ends = [flight[1][0] for flight in flights if len(flight) == 2]
    late = times >= (times[max(ends)] if ends else np.inf)
    for name in ("mass_left", "momentum_left", "height_left"):
        series = tracks[name].values[late]
        known = series[~np.isnan(series)]
        values[name] = np.array(known.mean() if known.size else np.nan)
    return xr.Dataset(
        {name: (("wave",) if np.ndim(value) else (), value, describe(name)) for name, value in values.items()},
        {"wave": tracks["wave"]},
    )


def _free_flights(isolated: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """The frames of free flight before the first collision, and the second half of those from it to the next, if any."""
    flights: list[NDArray[np.intp]] = []
    edges = np.flatnonzero(np.diff(np.concatenate([[0], isolated.astype(int), [0]])))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        if end - start >= SHORTEST_FLIGHT or (start == 0 and end - start >= FEWEST_FRAMES):
            flights.append(np.arange((start + end) // 2 if flights else start, end))
    # Without free flight at the start nothing is known of the wave before its first collision.
    return flights[:2] if flights and flights[0][0] == 0 else []


def _line(times: Array, positions: Array, flight: NDArray[np.intp]) -> tuple[Array, float]:
    line = np.polyfit(times[flight], positions[flight], 1)
    return line, float(np.abs(np.polyval(line, times[flight]) - positions[flight]).max())


def _moment(line: Array, others: list[Array], around: float, length: float) -> float:
    """When a line of free flight meets one of the others on the ring, the time nearest to a given one."""
    meetings = [
        around - float(ring_distance(np.array(np.polyval(line, around)), float(np.polyval(other, around)), length)) / slope
        for other in others
        if (slope := float(line[0] - other[0]))
    ]
    return min(meetings, key=lambda moment: abs(moment - around), default=around)
