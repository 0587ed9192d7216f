"""What the first collision of each wave did to it, from its tracks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import require
from mol_compactons.grid import ring_distance
from mol_compactons.results.schema import describe

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

FEWEST_FRAMES = 3
"""Frames of free flight on either side without which a collision has no phase shift."""

SHORTEST_FLIGHT = 2 * FEWEST_FRAMES
"""Free flight of fewer frames than this does not end a collision."""


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
        that did not collide has no values after, nor has one that only met waves born later, as when it sheds them.
        ``mass_left``, ``momentum_left``, ``height_left``: means over the settled time after the last of these collisions, NaN
        without one.
    """
    import xarray as xr

    require("wave" in tracks.sizes, "There are no tracks; give what track() returned.")
    tracks = tracks.transpose("t", "wave", ...)
    times = tracks["t"].values
    waves = tracks.sizes["wave"]
    names = ("moment", "phase_shift", "speed_before", "speed_after", "height_before", "height_after", "scatter")
    values = {name: np.full(waves, np.nan) for name in names}
    length = float(tracks["position"].attrs["period"])
    flights = [_free_flights(tracks["isolated"].values[:, wave]) for wave in range(waves)]
    lines = [[_line(times, tracks["position"].values[:, wave], flight) for flight in flights[wave]] for wave in range(waves)]
    for wave in range(waves):
        height = tracks["height"].values[:, wave]
        if lines[wave]:
            before, values["scatter"][wave] = lines[wave][0]
            values["speed_before"][wave] = before[0]
            values["height_before"][wave] = height[flights[wave][0]].mean()
        others = [line[0][0] for other, line in enumerate(lines) if other != wave and line]
        if len(lines[wave]) < 2 or not others:
            continue
        after, scatter = lines[wave][1]
        gap = 0.5 * (times[flights[wave][0][-1]] + times[flights[wave][1][0]])
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
