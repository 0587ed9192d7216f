"""One result seen in different ways: in space and time, at some times, along the paths of its waves, in wave numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.collisions import first_collision
from mol_compactons.analysis.tracking import track
from mol_compactons.errors import require
from mol_compactons.figures.references import beside_of, exact_profile, profile_at
from mol_compactons.figures.results import drifts, label_of, profiles, shown, waterfall
from mol_compactons.figures.style import DASHES, LINE, MARKERS
from mol_compactons.results.reading import arranged, field_names, grid_of, space_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SNAPSHOTS = 4
"""How many times are shown where none are named."""

SIGNED = 0.02
"""A field has both signs in a map where it is more than this below zero, relative to the largest value."""

OUTLINE = 0.25
"""How far below zero, relative to the largest value, a dashed line is drawn in a map."""

ROUNDING = 1e-14
"""Fourier coefficients smaller than this are rounding errors, relative to the largest one."""

SIZES = {"screen": 10.0, "journal": 8.0, "journal-wide": 8.0}
"""The size of the letters of labels; those of ticks and legends are a point smaller."""

FINE = 0.7
"""The widths of lines in one column of a journal, relative to those on the screen."""

WIDTHS = {"screen": 8.0, "journal": 3.4, "journal-wide": 7.0}
"""The widths of figures in inches: one column or two of a journal."""


def window(dataset: xr.Dataset, start: float | None = None, end: float | None = None) -> xr.Dataset:
    """The part of a result between two points.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    start : float, optional
        The left one; by default the first of the line.
    end : float, optional
        The right one; by default the last of the line.

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
    """A map of the field over space and time, white where it is zero.

    Where it has both signs, dashed lines stand around what is far below zero: in grey both signs are dark.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    axes : matplotlib.axes.Axes
        Where to draw.
    """
    field = profiles(dataset)
    space = space_of(dataset)
    values = shown(field)
    x, t = field[space].values, field["t"].values
    largest = float(np.nanmax(np.abs(values))) or 1.0
    lowest = float(np.nanmin(values))
    low, colors = (-largest, "RdBu_r") if lowest < -SIGNED * largest else (0.0, "Blues")
    drawn = axes.pcolormesh(x, t, values, cmap=colors, vmin=low, vmax=largest, shading="nearest", rasterized=True)
    if lowest < -OUTLINE * largest:
        axes.contour(x, t, values, levels=[-OUTLINE * largest], colors="black", linewidths=0.5, linestyles="dashed")
    axes.figure.colorbar(drawn, ax=axes, label=label_of(field))
    axes.set(xlabel=space, ylabel="t")


def snapshots(
    dataset: xr.Dataset,
    axes: Axes,
    times: Sequence[float] | NDArray[np.float64] = (),
    exact: bool = True,
    beside: xr.Dataset | None = None,
    called: str = "second result",
) -> None:
    """Profiles at some times on those of what they are seen beside: the exact wave, where one is known, or another result.

    A chain beside its continuum is drawn as marks at its sites, as in the paper's Figs 3 and 4.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    axes : matplotlib.axes.Axes
        Where to draw.
    times : sequence of float, optional
        The frames next to these are shown; by default four, evenly spread.
    exact : bool
        Whether the exact wave is shown, if no other result is.
    beside : xarray.Dataset, optional
        Another result on the same line or, of a chain, its continuum.
    called : str
        What the other result is called.

    Raises
    ------
    InputError
        If a time is beyond a result, or the two have no space in common.
    """
    field, space = profiles(dataset), space_of(dataset)
    t, values = field["t"].values, shown(field)
    other = None if beside is None else beside_of(dataset, beside)
    exact = exact and beside is None and field.name == field_names(arranged(dataset))[0]
    marked = beside is not None and space_of(beside) != space
    frames = _frames_at(t, times if len(times) else np.linspace(t[0], t[-1], SNAPSHOTS))
    below = None
    for number, index in enumerate(frames):
        dash = MARKERS[number % len(MARKERS)] if marked else DASHES[number % len(DASHES)]
        when = float(t[index])
        axes.plot(
            field[space].values, values[index], dash, color=f"C{number % 10}", markersize=3, label=f"t = {when:.4g}", zorder=3
        )
        curve = exact_profile(dataset, when) if exact else None if other is None else profile_at(other, when)
        if curve is not None:
            (below,) = axes.plot(*curve, color="0.72", linewidth=1.0 if marked else 3.5, zorder=1)
    if below is not None:
        below.set_label("exact" if exact else called)
    axes.set(xlabel=space, ylabel=label_of(field))
    axes.set_xlim(float(field[space][0]), float(field[space][-1]))


def _frames_at(t: NDArray[np.float64], times: Sequence[float] | NDArray[np.float64]) -> list[int]:
    """The frames next to some times; raises `InputError` where one is beyond the result."""
    for time in times:
        require(t[0] <= time <= t[-1], f"t = {time:g} is beyond the result, which goes from {t[0]:g} to {t[-1]:g}.")
    return sorted({int(np.abs(t - time).argmin()) for time in times})


def paths(dataset: xr.Dataset, axes: Axes) -> None:
    """The places of the waves along time, around the line, and the free flight of each before its first collision.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    axes : matplotlib.axes.Axes
        Where to draw.
    """
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
    """The size of the Fourier coefficients of the first and the last profile: ripples of the grid stand at its right end.

    What is zero but for rounding errors is left out.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    axes : matplotlib.axes.Axes
        Where to draw.
    """
    field = profiles(dataset)
    grid = grid_of(arranged(dataset))
    values = np.asarray(field.values, dtype=float)
    k = 2 * np.pi / grid.length * np.arange(values.shape[1] // 2 + 1)
    for index, dash in ((0, "--"), (-1, "-")):
        sizes = np.abs(np.fft.rfft(values[index])) / values.shape[1]
        seen = (k > 0) & (sizes > ROUNDING * sizes.max())
        label = f"t = {float(field['t'][index]):.4g}" + ("" if seen.any() else ": zero")
        axes.semilogy(k[seen], sizes[seen], dash, color=LINE, linewidth=0.8, label=label)
    axes.set(xlabel="wave number", ylabel=f"|Fourier coefficient of {field.name}|")


def portrait(dataset: xr.Dataset, axes: Axes, times: Sequence[float] | NDArray[np.float64] = ()) -> None:
    """The derivative of the field against the field, at some times; a travelling wave goes round a closed curve.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    axes : matplotlib.axes.Axes
        Where to draw.
    times : sequence of float, optional
        The frames next to these are shown; by default the first and the last.
    """
    field, space = profiles(dataset), space_of(dataset)
    t, values = field["t"].values, shown(field)
    slopes = _slopes(values, field[space].values, grid_of(arranged(dataset)).length if space == "x" else np.inf)
    for number, index in enumerate(_frames_at(t, times if len(times) else (t[0], t[-1]))):
        axes.plot(
            values[index], slopes[index], DASHES[number % len(DASHES)], color=f"C{number % 10}", label=f"t = {t[index]:.4g}"
        )
    axes.set(xlabel=label_of(field), ylabel=f"d{field.name}/d{space}")


def _slopes(values: NDArray[np.float64], x: NDArray[np.float64], period: float) -> NDArray[np.float64]:
    """The derivative by central differences, which go around where the points are a whole period."""
    spacing = float(x[1] - x[0])
    if not np.isclose(spacing * x.size, period):
        return np.asarray(np.gradient(values, x, axis=1))
    return (np.roll(values, -1, axis=1) - np.roll(values, 1, axis=1)) / (2 * spacing)


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
    beside: xr.Dataset | None = None,
    called: str = "second result",
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
    beside : xarray.Dataset, optional
        For snapshots: another result, or the continuum of a chain.
    called : str
        What the other result is called.

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
    require(beside is None or kind == "snapshots", f"A picture of the kind {kind} shows one result; leave out the second.")
    seen = dataset if part == (None, None) else window(dataset, *part)
    more: dict[str, Any] = {"times": times} if len(times) else {}
    more |= {} if beside is None else {"beside": beside, "called": called}
    width = WIDTHS[style]
    figure = Figure(figsize=(width, 0.68 * width), layout="constrained")
    KINDS[kind](seen, figure.subplots(), **more)
    _dress(figure, style)
    return figure


def _dress(figure: Figure, style: str) -> None:
    """Give a figure the letters and lines of a style, and its legend a place where it covers nothing."""
    axes, size = figure.axes[0], SIZES[style]
    if legend := axes.get_legend():
        legend.remove()
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        columns = min(len(handles), 2 if style == "journal" else 4)
        figure.legend(handles, labels, loc="outside lower center", ncols=columns, frameon=False, fontsize=size - 1)
    axes.set_title("" if style != "screen" else axes.get_title(), fontsize=size)
    if style == "journal":
        for line in axes.lines:
            line.set_linewidth(FINE * line.get_linewidth())
    for own in figure.axes:
        own.tick_params(which="both", labelsize=size - 1)
        own.xaxis.label.set_fontsize(size)
        own.yaxis.label.set_fontsize(size)
