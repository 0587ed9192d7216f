"""Following the waves of a result: where they are, how tall, fast and wide, what they are, and what they leave behind.

A wave keeps its name through a collision by its sign and its height: of two bright waves the one that is the taller before is
the taller after. Between frames each is looked for where free flight would have taken it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.following import Followed, Followers, clear
from mol_compactons.analysis.sighting import Frames, frames_of
from mol_compactons.errors import require
from mol_compactons.grid import Grid, Lattice, ring_distance
from mol_compactons.results.reading import outlines_of
from mol_compactons.results.schema import describe

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

LARGEST_MISFIT = 0.03
"""How far the profile of a compacton may be from the exact one. In runs on 10 points for each width of it the misfit is up to
0.032, on 12 up to 0.016, under noise of a hundredth of its height 0.02; a width that is wrong by 4 % gives as much. Of all
Gaussians the one most like a compacton has 0.027 for n = 3/2, and 0.037 to 0.049 for n = 2 to 4: these the speed tells."""

SPEED_TOLERANCE = 0.05
"""How far the speed of a compacton may be from that of its height, relative to it: on 10 points for each width it is
up to 0.01, and up to 0.04 while the profile of a wave that left a collision comes within `LARGEST_MISFIT`."""


def track(dataset: xr.Dataset, *, least_height: float | None = None, newborn: bool = True) -> xr.Dataset:
    """Follow the waves of a result from frame to frame.

    The waves are, in this order: the compactons and solitary waves of the initial data or, where there are none, the peaks of
    the first frame; then those that come later, as when a pulse breaks up. A peak that comes later is a wave if it looks like
    an exact one in 5 frames and moves as one, or if it is a fifth as high as the highest at the start and moves by half its
    width.

    A peak is measured by a fit of the exact wave, `mol_compactons.analysis.fitting.fit`, where the misfit is at most 5 %, and
    else by a quartic through five points. The result may be transposed, and may hold every m-th frame or point only, or a part
    of the frames or of the period: of a wave outside this part nothing is known.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result; its first component is followed, of a chain in displacements the stresses.
    least_height : float, optional
        Peaks lower than this are ripples; by default 5 % of the lowest wave at the start.
    newborn : bool
        Whether waves that come later are followed too.

    Returns
    -------
    xarray.Dataset
        Along t and wave: ``position`` (not wrapped: it goes on growing where a wave comes round again), ``height`` (signed),
        ``speed``, ``width`` (at half the height), NaN where a wave cannot be told from another; ``isolated``, whether its
        support is clear of all others, but for those born later and lower than a quarter of it; ``residual``, the relative L2
        misfit of the exact wave, NaN where none is known or too few points are clear; ``family_speed``, the speed that belongs
        to the height, NaN where none is known; ``compacton``, whether it is an exact wave: residual at most 3 %, and the speed
        within 5 % of the family speed. Along wave: ``first_seen``, the time from which on it is known. Along t: ``mass_left``,
        ``momentum_left`` and ``height_left``, the integral of the field, half that of its square and its largest size outside
        the supports of the waves of the initial data or, without these, of all waves; NaN unless all of them are isolated and
        the whole period is known.
        The attribute ``lost`` names the waves that were not found in the last frame, though no other hides them; ``doubtful``
        names those that move so far between frames that it is not sure which peak they are in the next.

    Raises
    ------
    InputError
        If there is no wave to follow, or the points lie on no grid of the period.
    """
    require(
        least_height is None or least_height > 0, f"least_height = {least_height} must be positive, or None for the default."
    )
    frames, outlines = frames_of(dataset), outlines_of(dataset)
    followers = Followers(frames, outlines, least_height, newborn)
    waves = followers.run()
    values = _table(frames, waves)
    places = np.array([[wave.places.get(index, np.nan) for wave in waves] for index in range(frames.times.size)])
    found = ~np.isnan(values["position"])
    heights = np.where(found, np.abs(values["height"]), [wave.height for wave in waves])
    free = np.array([clear(waves, *row, frames) for row in zip(places, heights, strict=True)])
    isolated = free & found
    values["speed"] = _speeds(frames.times, values["position"], isolated)
    whole = slice(0, followers.count_at_start if outlines else None)
    left = _left_behind(frames, waves[whole], places[:, whole], isolated[:, whole])
    flags = {"isolated": isolated, "compacton": _are_exact(values)}
    lost = _lost(waves, followers.count_at_start, frames.times, values["position"], free[-1], flags["compacton"])
    return _dataset(dataset, frames, waves, {**values, **flags}, left, {"lost": lost, "doubtful": _doubtful(frames, waves)})


def _dataset(
    dataset: xr.Dataset,
    frames: Frames,
    waves: Sequence[Followed],
    values: Mapping[str, NDArray[Any]],
    left: Array,
    sentences: dict[str, str],
) -> xr.Dataset:
    import xarray as xr

    period = {"position": {"period": float(frames.grid.length)}}
    return xr.Dataset(
        {
            **{name: (("t", "wave"), value, describe(name) | period.get(name, {})) for name, value in values.items()},
            "first_seen": ("wave", frames.times[[wave.first for wave in waves]], describe("first_seen")),
            **{
                f"{what}_left": ("t", series, describe(f"{what}_left"))
                for what, series in zip(("mass", "momentum", "height"), left, strict=True)
            },
        },
        {"t": ("t", frames.times, describe("t")), "wave": ("wave", np.arange(len(waves)), describe("wave"))},
        {"simulation": dataset.attrs["simulation"], "field": frames.name} | sentences,
    )


def _table(frames: Frames, waves: Sequence[Followed]) -> dict[str, Array]:
    """What was seen of each wave in each frame, each of the shape (t, wave)."""
    names = ("position", "height", "width", "residual", "family_speed")
    values = {name: np.full((frames.times.size, len(waves)), np.nan) for name in names}
    for number, wave in enumerate(waves):
        for index, sighting in wave.seen.items():
            for name in names:
                values[name][index, number] = getattr(sighting, name)
            values["height"][index, number] *= wave.sign
    return values


def _are_exact(values: dict[str, Array]) -> NDArray[np.bool_]:
    """Where profile, height and speed belong together; the speed at the ends of a flight is that of the frame beside it."""
    speed, family = values["speed"], values["family_speed"]
    nearby = np.full_like(speed, np.nan)
    nearby[:-1] = speed[1:]
    nearby[1:] = np.where(np.isnan(speed[:-1]), nearby[1:], speed[:-1])
    speed = np.where(np.isnan(speed), nearby, speed)
    return (values["residual"] <= LARGEST_MISFIT) & (np.abs(speed - family) <= SPEED_TOLERANCE * np.abs(family))


def _lost(
    waves: Sequence[Followed],
    count_at_start: int,
    times: Array,
    position: Array,
    free: NDArray[np.bool_],
    exact: NDArray[np.bool_],
) -> str:
    """What is to be said of the waves that have no position in the last frame, and should not be in a collision there.

    Of those that came later only exact waves are missed: other peaks may go as they came.
    """
    sentences = []
    for wave in range(len(waves)):
        if np.isnan(position[-1, wave]) and free[wave] and (wave < count_at_start or exact[:, wave].any()):
            found = np.flatnonzero(~np.isnan(position[:, wave]))
            since = f"after t = {times[found[-1]]:.6g}" if found.size else "from the start"
            sentences.append(f"Wave {wave} is lost {since}: where it should be there is no peak of about its height.")
    return " ".join(sentences)


def _doubtful(frames: Frames, waves: Sequence[Followed]) -> str:
    """What is to be said of waves whose next place is not known to half the distance of the waves between which to choose."""
    sentences, length = [], frames.grid.length
    for number, wave in enumerate(waves):
        start = wave.places.get(wave.first, np.nan)
        others = [
            float(ring_distance(np.array(other.places[wave.first]), start, length))
            for other in waves
            if other is not wave and other.sign == wave.sign and wave.first in other.places
        ]
        apart = min([length, *(abs(distance) for distance in others)])
        if wave.doubt > apart / 2:
            sentences.append(
                f"Wave {number} may have been taken for another, and its speed be wrong: where it is in the next frame is "
                f"known to {wave.doubt:.3g} only, and peaks are {apart:.3g} apart; record more frames."
            )
    return " ".join(sentences)


def _left_behind(frames: Frames, waves: Sequence[Followed], places: Array, isolated: NDArray[np.bool_]) -> Array:
    """Mass, momentum and height outside the waves, shape (3, T); NaN unless all are isolated, or not there yet."""
    left = np.full((3, frames.times.size), np.nan)
    for index in range(0 if frames.hidden.any() else frames.times.size):
        if (isolated[index] | np.isnan(places[index])).all():
            left[:, index] = _outside(waves, places[index], frames.states[index, 0], frames.grid)
    return left


def _outside(waves: Sequence[Followed], places: Array, frame: Array, grid: Grid | Lattice) -> tuple[float, float, float]:
    outside = np.ones(grid.size, dtype=bool)
    for wave, place in zip(waves, places, strict=True):
        outside &= ~(np.abs(grid.offset(float(place))) <= wave.width / 2)
    rest = np.where(outside, frame, 0.0)
    return grid.spacing * float(rest.sum()), 0.5 * grid.spacing * float(rest @ rest), float(np.abs(rest).max())


def _speeds(times: Array, position: Array, isolated: NDArray[np.bool_]) -> Array:
    """Central differences of the positions where a wave was isolated before and after."""
    places = np.where(isolated, position, np.nan)
    speed = np.full_like(places, np.nan)
    if times.size > 2:
        speed[1:-1] = (places[2:] - places[:-2]) / (times[2:] - times[:-2])[:, None]
    return speed
