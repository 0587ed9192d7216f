"""What the first collision of each wave did to it, from its tracks, and whether that has settled."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.flights import Frames, Path, free_flights
from mol_compactons.analysis.settling import WINDOWS, line_through, reading_noise, remaining, windows
from mol_compactons.analysis.sighting import RECOGNISED
from mol_compactons.errors import require
from mol_compactons.results.schema import describe

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

PER_WAVE = (
    *("moment", "phase_shift", "speed_before", "speed_after", "height_before", "height_after"),
    *("scatter", "flight_end", "incoming_noise", "misfit"),
)

MEASURES = ("phase_shift", "speed", "height", "mismatch")
"""What is measured of a wave in each window of free flight."""

LEFT = ("mass_left", "momentum_left", "height_left")
"""What the waves left behind."""


def first_collision(tracks: xr.Dataset) -> xr.Dataset:
    """What the first collision of each wave did to it, and whether that has settled.

    A straight line through the positions in free flight before the collision gives the incoming wave. Free flight after it
    lasts until the wave meets anything: another wave, or what a collision left behind on the ring. It is divided into three
    windows, whose ends follow each other by one ratio in the time since the collision; a line through each gives the
    outgoing wave. The moment of a collision is when the incoming lines meet; there the outgoing line lies ahead of the
    incoming one by the phase shift. Values after are those of the last window, or of the second half of a flight that is too
    short for windows.

    Parameters
    ----------
    tracks : xarray.Dataset
        What `track` returned.

    Returns
    -------
    xarray.Dataset
        Along wave: ``moment``, ``phase_shift``, ``speed_before``, ``speed_after``, ``height_before``, ``height_after`` (means
        over the same times), ``scatter`` (the largest distance of a position from its line), ``flight_end`` (the last time of
        free flight after the collision, or else of the first), ``incoming_noise`` (the standard error of the incoming line at
        the moment), ``misfit`` (the mean residual of the fit of the exact wave, over the same times as the values after, or
        else before); NaN for what there is not: a wave that did not collide has no values after, nor has one that only met
        waves born later, as when it sheds them. ``mass_left``, ``momentum_left``, ``height_left``: means over the last window
        of the time in which all waves that collided are free, NaN without one.

        Along wave and window, of the flight after the collision or else of the first: ``window_t`` (the middle, since the
        collision or the start), ``window_phase_shift``, ``window_speed``, ``window_height``, ``window_mismatch`` (the speed
        less that of a compacton as high); along wave the standard errors of the last, ``phase_shift_noise`` and so on; the
        same of what is left, along window. ``phase_shift_settling`` and so on: how far each may be from what it tends to, as
        `remaining` says, and no less than `least_change` does. ``phase_shift_reading`` and so on: how exactly each is read,
        as `readings` says. NaN where there are no windows. ``mass_left_reading`` and so on: half of the range in
        the last window, and what the misfits of the waves leave open.

    Raises
    ------
    InputError
        If there are no tracks.
    """
    import xarray as xr

    require("wave" in tracks.sizes, "There are no tracks; give what track() returned.")
    tracks = tracks.transpose("t", "wave", ...)
    paths = free_flights(tracks)
    of_height = family_speeds(tracks)
    rows = [_of_wave(path, tracks.isel(wave=wave), of_height[:, wave]) for wave, path in enumerate(paths)]
    along_wave = {name: np.array([row[name] for row in rows]) for name in _nothing()}
    dimensions = {name: ("wave", "window")[: value.ndim] for name, value in along_wave.items()}
    free = [(path, row) for path, row in zip(paths, rows, strict=True) if path is not None and path.after.size]
    left = _left(tracks, [path for path, _ in free], _open_parts(free))
    dimensions |= {name: ("window",) * np.ndim(value) for name, value in left.items()}
    return xr.Dataset(
        {name: (dimensions[name], value, describe(name)) for name, value in (along_wave | left).items()},
        {"wave": tracks["wave"]},
    )


def family_speeds(tracks: xr.Dataset) -> Array:
    """The speed of the solitary wave as high as each wave, shape (t, wave); NaN where its profile is not that of one.

    A wave on a background, or one that is just out of a collision, has a height to which no speed belongs.
    """
    if "family_speed" not in tracks:
        return np.full(tracks["height"].shape, np.nan)
    return np.where(tracks["residual"].values <= RECOGNISED, tracks["family_speed"].values, np.nan)


def _nothing() -> dict[str, float | Array]:
    """What is said of a wave of which nothing is known."""
    judged = (f"{name}_{what}" for name in MEASURES[:-1] for what in ("settling", "reading"))
    single = (*PER_WAVE, *(f"{name}_noise" for name in MEASURES), *judged)
    return dict.fromkeys(single, np.nan) | {f"window_{name}": np.full(WINDOWS, np.nan) for name in ("t", *MEASURES)}


def _of_wave(path: Path | None, track: xr.Dataset, of_height: Array) -> dict[str, float | Array]:
    """Everything along wave, of one wave."""
    values = _nothing()
    if path is None:
        return values
    times, heights = track["t"].values, track["height"].values
    flight = path.after if path.after.size else path.before
    since = path.moment if path.after.size else float(times[0])
    parts = windows(times, flight, since)
    values |= {
        "speed_before": path.incoming.slope,
        "height_before": heights[path.before].mean(),
        "scatter": path.incoming.scatter,
        "flight_end": times[flight[-1]],
        "misfit": _misfit(track, path.before),
    }
    if path.after.size:
        last = parts[-1] if parts else flight[flight.size // 2 :]
        outgoing = line_through(times[last], path.positions[last])
        values |= {
            "moment": path.moment,
            "phase_shift": outgoing.at(path.moment) - path.place,
            "speed_after": outgoing.slope,
            "height_after": heights[last].mean(),
            "misfit": _misfit(track, last),
            "scatter": max(path.incoming.scatter, outgoing.scatter),
        }
    if not parts:
        return values
    seen = _of_windows(path, parts, since, times, heights, of_height)
    return values | seen | readings(seen, heights[parts[-1]], float(values["misfit"]), path.width)


def _misfit(track: xr.Dataset, frames: Frames) -> float:
    """The mean residual of the fits in some frames, NaN where the tracks have none."""
    return _mean(track["residual"].values[frames]) if "residual" in track else np.nan


def _mean(values: Array) -> float:
    """The mean of the numbers among some values; NaN where there are none."""
    known = values[~np.isnan(values)]
    return float(known.mean()) if known.size else np.nan


def _of_windows(
    path: Path, parts: list[Frames], since: float, times: Array, heights: Array, of_height: Array
) -> dict[str, float | Array]:
    """What was measured in each window, the standard errors, and how far each may be from what it tends to."""
    lines = [line_through(times[part], path.positions[part]) for part in parts]
    tops = [line_through(times[part], heights[part]) for part in parts]
    t = np.array([line.t - since for line in lines])
    seen = {
        "phase_shift": np.array([line.at(path.moment) - path.place for line in lines]),
        "speed": np.array([line.slope for line in lines]),
        "height": np.array([top.value for top in tops]),
        "mismatch": np.array(
            [line.slope - np.copysign(_mean(of_height[part]), line.slope) for line, part in zip(lines, parts, strict=True)]
        ),
    }
    noises = {
        "phase_shift": lines[-1].noise_at(path.moment),
        "speed": lines[-1].slope_noise,
        "height": tops[-1].value_noise,
        "mismatch": lines[-1].slope_noise,
    }
    to_go = {name: remaining(t, seen[name], noises[name]) for name in MEASURES[:-1]}
    least = least_change(t[-1], seen["speed"][-1], seen["height"][-1], seen["mismatch"][-1])
    return {
        "incoming_noise": path.incoming.noise_at(path.moment),
        "window_t": t,
        **{f"window_{name}": values for name, values in seen.items()},
        **{f"{name}_noise": noise for name, noise in noises.items()},
        **{f"{name}_settling": max(value, abs(least[name])) for name, value in to_go.items()},
    }


def readings(seen: Mapping[str, float | Array], heights: Array, misfit: float, width: float) -> dict[str, float]:
    """How exactly the phase shift, the speed and the height of a wave are read from the frames.

    Twice the standard error of the lines through the readings, and of a height that of a single reading, whose error is
    that of its place between the points: the mean of many has it too. And what the misfit r leaves open: another reading,
    as that of the top, differs from the fit by about r times the height, and by r / 4 times the support in its place,
    before the collision and after it. A line through a flight that is curved has few independent residuals, and so a
    large error.

    Parameters
    ----------
    seen : mapping
        ``phase_shift_noise``, ``speed_noise``, ``height_noise`` and ``incoming_noise``, the standard errors.
    heights : array
        The readings in the last window.
    misfit : float
        The relative L2 residual of the fit; NaN where none was made: the readings then are tops of quartics, whose errors
        are those of the grid.
    width : float
        The length of the support.

    Returns
    -------
    dict
        ``phase_shift_reading``, ``speed_reading`` and ``height_reading``.
    """
    open_part = 0.0 if np.isnan(misfit) else misfit
    incoming = 0.0 if np.isnan(seen["incoming_noise"]).any() else float(seen["incoming_noise"])
    single = float(np.nan_to_num(reading_noise(heights)))
    return {
        "phase_shift_reading": 2 * (float(seen["phase_shift_noise"]) + incoming) + 0.5 * open_part * width,
        "speed_reading": 2 * float(seen["speed_noise"]),
        "height_reading": 2 * max(float(seen["height_noise"]), single) + open_part * abs(float(heights.mean())),
    }


def least_change(t: float, speed: float, height: float, mismatch: float) -> dict[str, float]:
    """How far a wave has to change at least whose speed and height do not belong together.

    Until they do, one of them changes: the speed by their distance, the height by up to twice the part of itself that the
    speed changes by (c ~ M^(n-1), n >= 3/2), and the phase shift by the distance times the time.

    Parameters
    ----------
    t : float
        The time since the collision.
    speed, height : float
        Those of the wave.
    mismatch : float
        The speed less that of a compacton as high; NaN where that is not known.

    Returns
    -------
    dict
        The signed changes of the phase shift, the speed and the height; 0 where nothing is known.
    """
    apart = 0.0 if np.isnan(mismatch) else float(mismatch)
    part = apart / max(abs(float(speed)), abs(apart)) if apart else 0.0
    return {"phase_shift": apart * float(t), "speed": apart, "height": 2 * part * float(height)}


def _left(tracks: xr.Dataset, paths: list[Path], open_parts: Mapping[str, float]) -> dict[str, float | Array]:
    """What is left behind, while all waves that collided are free, and what their misfits leave open about it."""
    single = [f"{name}{what}" for name in LEFT for what in ("", "_noise", "_settling", "_reading")]
    values: dict[str, float | Array] = dict.fromkeys(single, np.nan)
    values |= {f"window_{name}": np.full(WINDOWS, np.nan) for name in ("t_left", *LEFT)}
    if not paths:
        return values
    times, since = tracks["t"].values, max(path.moment for path in paths)
    common = np.arange(max(path.after[0] for path in paths), min(path.after[-1] for path in paths) + 1)
    for name in LEFT:
        series = tracks[name].values
        known = common[~np.isnan(series[common])]
        parts = windows(times, known, since)
        if known.size:
            values[name] = series[parts[-1] if parts else known[known.size // 2 :]].mean()
        if not parts:
            continue
        t = np.array([times[part].mean() - since for part in parts])
        means = np.array([series[part].mean() for part in parts])
        # The distance from a line is the noise with which a change from window to window is compared: the range would
        # count what goes on changing as noise.
        noise = line_through(times[parts[-1]], series[parts[-1]]).scatter
        values |= {"window_t_left": t, f"window_{name}": means, f"{name}_noise": noise}
        values[f"{name}_settling"] = remaining(t, means, noise)
        # A largest value has no standard error: half its range is left open.
        values[f"{name}_reading"] = 0.5 * np.ptp(series[parts[-1]]) + open_parts[name]
    return values


def _open_parts(free: list[tuple[Path, dict[str, float | Array]]]) -> dict[str, float]:
    """What the misfits of waves that are free after their collision leave open about what is left.

    A wave that is no solitary one has yet to shed what it differs by, or to take it in. It holds about half of its height
    times its support, and as much of the squares; a relative misfit r is that part of it, and r^2 of its square.
    """
    mass = momentum = 0.0
    for path, row in free:
        misfit, height = np.nan_to_num(float(row["misfit"])), abs(float(row["height_after"]))
        mass += 0.5 * misfit * height * path.width
        momentum += 0.25 * misfit**2 * height**2 * path.width
    return {"mass_left": mass, "momentum_left": momentum, "height_left": 0.0}
