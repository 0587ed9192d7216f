"""One result seen in different ways: in space and time, at some times, along the paths of its waves, in wave numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.collisions import first_collision
from mol_compactons.analysis.tracking import track
from mol_compactons.errors import InputError, require
from mol_compactons.figures.results import drifts, profiles, shown, waterfall
from mol_compactons.figures.style import DASHES, LINE
from mol_compactons.results.reading import arranged, field_names, grid_of, space_of
from mol_compactons.simulation import Simulation

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SNAPSHOTS = 4
"""How many times are shown where none are named."""

SIZES = {"screen": 10.0, "journal": 8.0, "journal-wide": 8.0}
"""The size of the letters of labels; those of ticks and legends are a point smaller."""

WIDTHS = {"screen": 8.0, "journal": 3.4, "journal-wide": 7.0}
"""The widths of figures in inches: one column or two of a journal."""


def window(dataset: xr.Dataset, start: float | None = None, end: float | None = None) -> xr.Dataset:
    """The part of a result between two points.

    Raises
    ------
    InputError
        If there are not two points between them.
    """
    dataset, space = arranged(dataset), space_of(dataset)
    part = dataset.sel({space: slice(start, end)})
    low, high = float(dataset[space][0]), float(dataset[space][-1])
    require(part.sizes[space] > 1, f"The window {start} to {end} holds no two points of {space}, from {low:g} to {high:g}.")
    return part


def spacetime(dataset: xr.Dataset, axes: Axes) -> None:
    """A map of the field over space and time, white where it is zero."""
    field = profiles(dataset)
    space = space_of(dataset)
    values = shown(field)
    largest = float(np.nanmax(np.abs(values))) or 1.0
    signed = float(values.min()) < -0.02 * largest
    low, colors = (-largest, "RdBu_r") if signed else (0.0, "Blues")
    drawn = axes.pcolormesh(
        field[space].values, field["t"].values, values, cmap=colors, vmin=low, vmax=largest, shading="nearest", rasterized=True
    )
    axes.figure.colorbar(drawn, ax=axes, label=str(field.name))
    axes.set(xlabel=space, ylabel="t")


def snapshots(dataset: xr.Dataset, axes: Axes, times: Sequence[float] | NDArray[np.float64] = (), exact: bool = True) -> None:
    """Profiles at some times, and with them the exact wave where the initial data are one.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    axes : matplotlib.axes.Axes
        Where to draw.
    times : sequence of float, optional
        The frames next to these are shown; by default four, evenly spread.
    exact : bool
        Whether the exact wave is shown.

    Raises
    ------
    InputError
        If a time is beyond the result.
    """
    field, space = profiles(dataset), space_of(dataset)
    t, values = field["t"].values, shown(field)
    for number, index in enumerate(_frames_at(t, times if len(times) else np.linspace(t[0], t[-1], SNAPSHOTS))):
        axes.plot(
            field[space].values,
            values[index],
            color=f"C{number % 10}",
            linestyle=DASHES[number % len(DASHES)],
            label=f"t = {t[index]:.4g}",
        )
        wave = _exact(dataset, float(t[index])) if exact and field.name == field_names(arranged(dataset))[0] else None
        if wave is not None:
            axes.plot(*wave, color="black", linewidth=0.5, label="exact" if number == 0 else None)
    axes.set(xlabel=space, ylabel=str(field.name))
    axes.set_xlim(float(field[space][0]), float(field[space][-1]))


def _frames_at(t: NDArray[np.float64], times: Sequence[float] | NDArray[np.float64]) -> list[int]:
    """The frames next to some times; raises `InputError` where one is beyond the result."""
    for time in times:
        require(t[0] <= time <= t[-1], f"t = {time:g} is beyond the result, which goes from {t[0]:g} to {t[-1]:g}.")
    return sorted({int(np.abs(t - time).argmin()) for time in times})


def _exact(dataset: xr.Dataset, t: float) -> tuple[Any, Any] | None:
    """The points and values of the exact wave at a time, where one is known that this program can compute."""
    try:
        simulation = Simulation.from_json(str(dataset.attrs["simulation"]))
        state = simulation.exact_state(t)
    except InputError:
        return None
    return None if state is None else (simulation.grid.coordinates, state[0])


def paths(dataset: xr.Dataset, axes: Axes) -> None:
    """The places of the waves along time, around the line, and the free flight of each before its first collision."""
    tracks = track(dataset, newborn=False)
    grid, space = grid_of(arranged(dataset)), space_of(dataset)
    first = float(arranged(dataset)[space][0])
    collision = first_collision(tracks)
    t = tracks["t"].values
    for number in range(tracks.sizes["wave"]):
        places = tracks["position"].values[:, number]
        around = first + (places - first) % grid.length
        around[1:][np.abs(np.diff(around)) > grid.length / 2] = np.nan
        shift = float(collision["phase_shift"][number])
        label = f"wave {number}" + ("" if np.isnan(shift) else f", shifted by {shift:.3g}")
        axes.plot(around, t, color=f"C{number % 10}", linestyle=DASHES[number % len(DASHES)], label=label)
        speed = float(collision["speed_before"][number])
        free = first + (places[0] + speed * (t - t[0]) - first) % grid.length
        free[1:][np.abs(np.diff(free)) > grid.length / 2] = np.nan
        axes.plot(free, t, color="grey", linewidth=0.6, zorder=0, label="free flight" if number == 0 else None)
    axes.set(xlabel=space, ylabel="t", xlim=(first, first + grid.length))


def spectrum(dataset: xr.Dataset, axes: Axes) -> None:
    """The size of the Fourier coefficients of the first and the last profile: ripples of the grid stand at its right end."""
    field = profiles(dataset)
    grid = grid_of(arranged(dataset))
    values = np.asarray(field.values, dtype=float)
    k = 2 * np.pi / grid.length * np.arange(values.shape[1] // 2 + 1)
    for index, dash in ((0, "--"), (-1, "-")):
        sizes = np.abs(np.fft.rfft(values[index])) / values.shape[1]
        label = f"t = {float(field['t'][index]):.4g}"
        axes.semilogy(k[1:], np.maximum(sizes[1:], 1e-18), dash, color=LINE, linewidth=0.8, label=label)
    axes.set(xlabel="wave number", ylabel=f"|Fourier coefficient of {field.name}|")


def portrait(dataset: xr.Dataset, axes: Axes, times: Sequence[float] | NDArray[np.float64] = ()) -> None:
    """The derivative of the field against the field, at some times; a travelling wave goes round a closed curve."""
    field, space = profiles(dataset), space_of(dataset)
    t, values = field["t"].values, shown(field)
    slopes = np.gradient(values, field[space].values, axis=1)
    for number, index in enumerate(_frames_at(t, times if len(times) else (t[0], t[-1]))):
        axes.plot(
            values[index], slopes[index], DASHES[number % len(DASHES)], color=f"C{number % 10}", label=f"t = {t[index]:.4g}"
        )
    axes.set(xlabel=str(field.name), ylabel=f"d{field.name}/d{space}")


KINDS: dict[str, Callable[..., None]] = {
    "waterfall": waterfall,
    "map": spacetime,
    "snapshots": snapshots,
    "paths": paths,
    "drift": drifts,
    "spectrum": spectrum,
    "portrait": portrait,
}
"""The pictures of a result by their names; each is a function of a result and the axes to draw in."""


def picture(
    dataset: xr.Dataset,
    kind: str,
    *,
    times: Sequence[float] | NDArray[np.float64] = (),
    part: tuple[float | None, float | None] = (None, None),
    style: str = "screen",
) -> Figure:
    """One picture of a result.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    kind : str
        One of `KINDS`.
    times : sequence of float, optional
        For snapshots and portraits.
    part : (float or None, float or None)
        The points between which it is shown.
    style : {"screen", "journal", "journal-wide"}
        How large, and in which letters: for a column of a journal, or for both.

    Raises
    ------
    InputError
        If the kind or the style is unknown, or there is nothing to show.
    """
    from matplotlib.figure import Figure

    require(kind in KINDS, f"There is no picture {kind!r}; it may be {', '.join(KINDS)}.")
    require(style in WIDTHS, f"There is no style {style!r}; it may be {', '.join(WIDTHS)}.")
    whole = kind in ("paths", "spectrum", "drift")
    require(not whole or part == (None, None), f"A picture of the kind {kind} shows the whole line; leave out the window.")
    require(
        not len(times) or kind in ("snapshots", "portrait"),
        f"A picture of the kind {kind} shows all times; leave out --times.",
    )
    seen = dataset if part == (None, None) else window(dataset, *part)
    width, size = WIDTHS[style], SIZES[style]
    figure = Figure(figsize=(width, 0.68 * width), layout="constrained")
    axes = figure.subplots()
    KINDS[kind](seen, axes, **({"times": times} if len(times) else {}))
    if legend := axes.get_legend():
        legend.remove()
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        columns = min(len(handles), 2 if style == "journal" else 4)
        figure.legend(handles, labels, loc="outside lower center", ncols=columns, frameon=False, fontsize=size - 1)
    axes.set_title("" if style != "screen" else axes.get_title(), fontsize=size)
    for own in figure.axes:
        own.tick_params(labelsize=size - 1)
        own.xaxis.label.set_fontsize(size)
        own.yaxis.label.set_fontsize(size)
    return figure
