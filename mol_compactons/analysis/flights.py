"""The free flights of waves: before their first collision, and after it until they meet anything again."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.settling import FEWEST_FRAMES, Line, line_through
from mol_compactons.grid import ring_distance

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Frames = NDArray[np.intp]

SHORTEST_FLIGHT = 2 * FEWEST_FRAMES
"""Free flight of fewer frames than this does not end a collision."""


@dataclass(frozen=True, eq=False)
class Path:
    """The free flights of a wave, and where its first collision was.

    Parameters
    ----------
    before, after : array of int
        The frames of free flight before the first collision, and from it until the wave meets anything again.
    positions : array
        Its position in all frames, not wrapped.
    width : float
        The length of its support.
    incoming : Line
        Through the positions before.
    moment : float
        When the incoming lines meet; NaN for a wave that met nothing.
    """

    before: Frames
    after: Frames
    positions: Array
    width: float
    incoming: Line
    moment: float = np.nan

    @property
    def place(self) -> float:
        """Where free flight would have been at the moment of the collision."""
        return self.incoming.at(self.moment)


def free_flights(tracks: xr.Dataset) -> list[Path | None]:
    """The free flights of each wave; None where nothing is known of it before it collides.

    Free flight ends where the support of another wave is met, and where the wave runs into what a collision left behind: one
    that took part in it, when it has rounded the ring. That begins one length of its support behind the place of the
    collision, and is met by the front of the wave.

    Parameters
    ----------
    tracks : xarray.Dataset
        What `track` returned.

    Returns
    -------
    list of Path or None
        One for each wave.
    """
    times, length = tracks["t"].values, float(tracks["position"].attrs["period"])
    paths = [_uncut(tracks, wave) for wave in range(tracks.sizes["wave"])]
    paths = [path and _with_moment(path, paths, times, length) for path in paths]
    events = [path for path in paths if path is not None and not np.isnan(path.moment)]
    return [path and _cut(path, events, times, length) for path in paths]


def _uncut(tracks: xr.Dataset, wave: int) -> Path | None:
    times, positions = tracks["t"].values, tracks["position"].values[:, wave]
    flights = _flights(tracks["isolated"].values[:, wave])
    if not flights:
        return None
    before, after = flights
    # The support is about twice as long as the width at half the height.
    width = 2 * float(np.nanmax(tracks["width"].values[before, wave]))
    return Path(before, after, positions, width, line_through(times[before], positions[before]))


def _flights(isolated: NDArray[np.bool_]) -> tuple[Frames, Frames] | None:
    """The frames of free flight before the first collision, and of those from it to the next, if any."""
    flights: list[Frames] = []
    edges = np.flatnonzero(np.diff(np.concatenate([[0], isolated.astype(int), [0]])))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        if end - start >= SHORTEST_FLIGHT or (start == 0 and end - start >= FEWEST_FRAMES):
            flights.append(np.arange(start, end))
    # Without free flight at the start nothing is known of the wave before its first collision.
    if not flights or flights[0][0] != 0:
        return None
    return flights[0], flights[1] if len(flights) > 1 else np.arange(0)


def _with_moment(path: Path, paths: list[Path | None], times: Array, length: float) -> Path:
    """The path with the moment of its collision, if its free flight ends before the last frame.

    A wave that is alone at the start can only meet what is born later, as when it sheds waves: that is no collision.
    """
    last = path.before[-1]
    if last + 1 == times.size:
        return path
    seen_again = times[path.after[0]] if path.after.size else times[last]
    others = [other.incoming for other in paths if other is not None and other is not path]
    if not others:
        return replace(path, after=path.after[:0])
    return replace(path, moment=_moment(path.incoming, others, 0.5 * float(times[last] + seen_again), length))


def _moment(line: Line, others: list[Line], around: float, length: float) -> float:
    """When a line of free flight meets one of the others on the ring, the time nearest to a given one."""
    meetings = [
        around - float(ring_distance(np.array(line.at(around)), other.at(around), length)) / slope
        for other in others
        if (slope := line.slope - other.slope)
    ]
    return min(meetings, key=lambda moment: abs(moment - around), default=around)


def _cut(path: Path, events: list[Path], times: Array, length: float) -> Path | None:
    """A path whose free flights end at what any collision left behind; None without one before its first collision."""
    before, after = path.before, path.after
    outgoing = line_through(times[after], path.positions[after]) if after.size else path.incoming
    for event in events:
        before = _short_of(event, path, before, path.incoming, path.incoming.at(event.moment), times, length)
        start = path.place if event.moment <= path.moment else outgoing.at(event.moment)
        after = _short_of(event, path, after, outgoing, start, times, length)
    if before.size < FEWEST_FRAMES:
        return None
    if after.size < SHORTEST_FLIGHT:
        after = after[:0]
    return replace(path, before=before, after=after, incoming=line_through(times[before], path.positions[before]))


def _short_of(event: Path, path: Path, flight: Frames, line: Line, start: float, times: Array, length: float) -> Frames:
    """The frames of a flight before the wave has its front at the rear of what an event left behind.

    At the moment of the event, or of its own collision if that was later, it was at `start`.
    """
    way = np.sign(line.slope)
    front = 0.5 * path.width + event.width
    ahead = length - (way * (start - event.place) + front) % length
    reached = (times[flight] > event.moment) & (way * (path.positions[flight] - start) >= ahead)
    return flight[: int(np.argmax(reached))] if reached.any() else flight
