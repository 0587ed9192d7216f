"""The page of a run: its field in motion, its waves, what it kept, what contradicts what is known, and what made it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mol_compactons.analysis.chain_and_continuum import compare, on_lattice
from mol_compactons.analysis.checkup import check_up
from mol_compactons.analysis.collisions import first_collision
from mol_compactons.analysis.drift import drift
from mol_compactons.analysis.summary import TRACK_COLUMNS, contents, cost, kept, waves_of
from mol_compactons.analysis.tracking import track
from mol_compactons.errors import InputError, require
from mol_compactons.figures.results import evenly, profiles
from mol_compactons.figures.results import shown as cut_off
from mol_compactons.pages.document import Array, Moving, Page, Picture, Section, Table
from mol_compactons.pages.plots import add_line, drawn_of, figure, plain
from mol_compactons.results.form import settings_of
from mol_compactons.results.reading import arranged, space_of
from mol_compactons.simulation import Simulation

if TYPE_CHECKING:
    import xarray as xr

MOST_FRAMES = 500
MOST_NUMBERS = 500_000
"""How many frames, and how many numbers of the field, a page has; of more some are left out."""

ROUND_OFF = 1e-15
"""Drifts below are not drawn."""

MOST_WAVES = 12
"""How many waves have a line."""

HEADINGS = {
    "wave": "wave",
    "first_seen": "seen since t",
    "t": "last clear at t",
    "position": "position",
    "height": "height",
    "speed": "speed",
    "family_speed": "speed of its height",
    "residual": "misfit of the profile",
    "compacton": "compacton",
}

BY_DAY, BY_NIGHT = (
    [[place / 4, colour] for place, colour in enumerate(colours)]
    for colours in (
        ("#0b3d6e", "#6aa5cf", "#f7f7f7", "#e48a6a", "#8c1a22"),
        ("#9fd0ff", "#2f6fa8", "#14171b", "#b5482f", "#ffb59a"),
    )
)
"""The colours of fields of both signs: zero is the paper, in light and in dark."""

SEEN = "The page is drawn by plotly; the numbers are those that mol-compactons track, doctor and info tell."


def page_of_result(dataset: xr.Dataset, status: str, continuum: xr.Dataset | None = None) -> Page:
    """The page of a run, or of a chain and its continuum.

    Parameters
    ----------
    dataset : xarray.Dataset
        The result.
    status : str
        How its run ended.
    continuum : xarray.Dataset, optional
        The result of the continuum of a chain.

    Raises
    ------
    InputError
        If there are fewer than two frames, or the two do not belong together.
    """
    whole = arranged(dataset)
    require(whole.sizes["t"] >= 2, f"The result has {whole.sizes['t']} frame(s); at least 2 are needed for a page.")
    moving, left_out = moving_of(whole, continuum)
    sections = [
        *(_comparison(whole, continuum) if continuum is not None else ()),
        *_waves(whole),
        *_conserved(whole),
        _check_up(whole),
        _settings(whole),
        _origin(whole),
    ]
    return Page(str(dataset.attrs["title"]), status, [contents(whole), kept(whole), *left_out], sections, moving)


def moving_of(dataset: xr.Dataset, continuum: xr.Dataset | None = None) -> tuple[Moving, list[str]]:
    """The first field of a result in motion, and what is said of what was left out of it."""
    field, space = profiles(dataset), space_of(dataset)
    name = str(field.name)
    frames = evenly(dataset.sizes["t"], MOST_FRAMES)
    room = MOST_NUMBERS // (frames.size * (1 if continuum is None else 2))
    points = evenly(field.sizes[space], room)
    shown = field.isel({"t": frames, space: points})
    t, x = shown["t"].values, shown[space].values
    series: list[tuple[str, Array, Array]] = [("chain" if continuum is not None else name, x, shown.values)]
    if continuum is not None:
        line = on_lattice(continuum, dataset.attrs["simulation"])
        line = line.isel(x=evenly(line.sizes["x"], room)).interp(t=np.minimum(t, float(line["t"].max())))
        series.append(("continuum", line["x"].values, line.values))
    told = []
    if frames.size < dataset.sizes["t"] or points.size < field.sizes[space]:
        shares = f"{frames.size} of {dataset.sizes['t']} frames and {points.size} of {field.sizes[space]} points"
        told = [f"Shown in motion are {shares}."]
    low, high = _limits(shown.values)
    caption = (
        f"{name} along {space} from {x[0]:.4g} to {x[-1]:.4g} and t from {t[0]:.4g} to {t[-1]:.4g}; it lies between "
        f"{low:.4g} and {high:.4g}."
    )
    return Moving(name, space, t, series, _profile(shown, space, series), _map(name, space, shown), caption), told


def _limits(*groups: Array) -> tuple[float, float]:
    """The smallest and the largest of the values that are finite; 0 and 0 where none is."""
    finite = np.concatenate([values[np.isfinite(values)] for values in groups])
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)


def _profile(field: xr.DataArray, space: str, series: Sequence[tuple[str, Array, Array]]) -> Any:
    """The profile, whose values come later."""
    drawn = figure(space, str(field.name))
    low, high = _limits(*(_cut_off(field, values) for _, _, values in series))
    room = 0.06 * ((high - low) or 1.0)
    for number, (label, x, _) in enumerate(series):
        sites = len(series) > 1 and number == 0
        add_line(drawn, label, x, np.full(x.size, np.nan), number=number)
        drawn.data[-1].update(mode="markers" if sites else "lines", line={"dash": "solid"}, marker={"size": 5})
    drawn.update_layout(yaxis={"range": [low - room, high + room]}, showlegend=len(series) > 1)
    drawn.update_xaxes(range=[float(series[0][1][0]), float(series[0][1][-1])])
    return drawn


def _cut_off(field: xr.DataArray, values: Array) -> Array:
    """The values of a field as pictures show them, where these are finite."""
    import xarray as xr

    return cut_off(xr.DataArray(np.where(np.isfinite(values), values, 0.0), name=field.name, attrs=field.attrs))


def _map(name: str, space: str, shown: xr.DataArray) -> Any:
    """The map over space and time, whose values come later, with a line at the time of the profile."""
    low, high = _limits(_cut_off(shown, shown.values))
    both = low < -0.02 * max(abs(low), abs(high)) and high > 0
    largest = max(abs(low), abs(high)) or 1.0
    colours: dict[str, Any] = {"colorscale": "Cividis", "zmin": low, "zmax": high if high > low else low + 1}
    if both:
        colours = {"zmin": -largest, "zmax": largest, "meta": {"day": BY_DAY, "night": BY_NIGHT}}
    drawn = figure(space, "t")
    drawn.add_heatmap(
        x=shown[space].values.tolist(),
        y=shown["t"].values.tolist(),
        hovertemplate=f"t = %{{y:.5g}}<br>{plain(space)} = %{{x:.5g}}<br>{plain(name)} = %{{z:.5g}}<extra></extra>",
        colorbar={"title": {"text": plain(name)}, "thickness": 12, "exponentformat": "power"},
        **colours,
    )
    t = float(shown["t"][0])
    drawn.add_shape(type="line", xref="paper", x0=0, x1=1, y0=t, y1=t, line={"color": "#e07b39", "width": 2})
    return drawn


def _waves(dataset: xr.Dataset) -> Iterator[Section]:
    """Where the waves went, and what collisions did to them."""
    try:
        tracks = track(dataset)
    except InputError as error:
        yield Section("waves", "Waves", [f"No waves are followed: {error}"])
        return
    rows = [_row_of(wave) for wave in waves_of(tracks)]
    tables = [Table("Each wave when it was last clear of all others", [HEADINGS[name] for name in HEADINGS], rows)]
    collisions = first_collision(tracks)
    collided = collisions.dropna("wave", subset=["phase_shift"]) if "wave" in collisions.dims else collisions
    if collided.sizes.get("wave"):
        names = ("moment", "phase_shift", "speed_before", "speed_after", "height_before", "height_after")
        cells = [
            [str(wave), *(_number(float(collided[name].sel(wave=wave))) for name in names)]
            for wave in collided["wave"].values.tolist()
        ]
        tables.append(Table("After the first collision", ["wave", *(name.replace("_", " ") for name in names)], cells))
    drawn = figure("t", "position")
    places, left_out = drawn_of(tracks.sizes["t"])
    for wave in tracks["wave"].values.tolist()[:MOST_WAVES]:
        add_line(drawn, f"wave {wave}", tracks["t"].values[places], tracks["position"].sel(wave=wave).values[places])
    count = len(drawn.data)
    of = "" if count == tracks.sizes["wave"] else f" of {tracks.sizes['wave']}"
    caption = f"The positions of {count}{of} wave(s) in the course of time, not wrapped.{left_out}"
    picture = Picture("paths", drawn, caption)
    said = [str(tracks.attrs[name]) for name in ("lost", "doubtful") if tracks.attrs.get(name)]
    yield Section("waves", "Waves", said, [picture] if rows else [], tables)


def _row_of(wave: dict[str, Any]) -> list[str]:
    numbers = [_number(wave[name]) for name in ("first_seen", *TRACK_COLUMNS)]
    return [str(wave["wave"]), *numbers, "yes" if wave["compacton"] else "no"]


def _number(value: float) -> str:
    return f"{value:.6g}" if np.isfinite(value) else "not known"


def _conserved(dataset: xr.Dataset) -> Iterator[Section]:
    """How well the invariants were kept."""
    changes = drift(dataset)
    if not changes.data_vars:
        return
    drawn = figure("t", "size of the drift", log="y")
    rows = []
    for name, change in changes.data_vars.items():
        sizes = np.abs(change.values)
        largest = float(sizes.max())
        rows.append([str(name), f"{largest:.2e}" if np.isfinite(largest) else "not known", str(change.attrs["relative_to"])])
        places, left_out = drawn_of(sizes.size)
        if np.nanmax(sizes, initial=0.0) > ROUND_OFF:
            visible = np.where(sizes > ROUND_OFF, sizes, np.nan)
            add_line(drawn, name, changes[change.dims[0]].values[places], visible[places])
    drawn.update_layout(showlegend=True)
    caption = f"How far each invariant is from its first value; what is below round-off is not drawn.{left_out}"
    pictures = [Picture("drift", drawn, caption)] if drawn.data else []
    yield Section("kept", "What was kept", [], pictures, [Table("Largest drift", ["invariant", "drift", "relative to"], rows)])


def _check_up(dataset: xr.Dataset) -> Section:
    try:
        rows = [[finding.check, finding.verdict, finding.sentence] for finding in check_up(dataset)]
    except InputError as error:
        return Section("doctor", "Check-up", [f"It cannot be looked at: {error}"])
    return Section(
        "doctor", "Check-up", [], [], [Table("What was seen beside what is known", ["check", "verdict", "seen"], rows)]
    )


def _settings(dataset: xr.Dataset) -> Section:
    """What was run: its parts, and what repeats it."""
    text = str(dataset.attrs["simulation"])
    pretty = json.dumps(settings_of(text), indent=1)
    try:
        markup = Simulation.from_json(text)._repr_html_()
    except InputError as error:
        return Section("settings", "Settings", [f"They cannot be read here: {error}"], code=pretty)
    return Section("settings", "Settings", markup=markup, code=pretty)


def _origin(dataset: xr.Dataset) -> Section:
    attributes = dataset.attrs
    text = [
        f"{cost(dataset)[0].upper()}{cost(dataset)[1:]}.",
        str(attributes.get("source", "The source is not stated.")),
        *str(attributes.get("history", "")).splitlines(),
    ]
    return Section("origin", "Origin and citation", [*text, *citation(attributes), SEEN])


def citation(attributes: dict[Any, Any]) -> list[str]:
    """How a result is cited."""
    program = str(attributes.get("source", "mol_compactons")).split(" (")[0]
    references = str(attributes.get("references", "")).strip()
    return [*([f"To be cited: {references}."] if references else []), f"Computed with {program}."]


def _comparison(chain: xr.Dataset, continuum: xr.Dataset) -> Iterator[Section]:
    """How far the continuum is from the chain."""
    both = compare(chain, continuum)
    drawn = figure("t", "relative L2 distance")
    places, left_out = drawn_of(both.sizes["t"])
    add_line(drawn, "distance", both["t"].values[places], both["distance"].values[places])
    last = both.isel(t=-1)
    rows = []
    for wave in range(both.sizes["wave"]):
        for name in ("position", "height", "width"):
            own, other = (float(last[f"{kind}{name}"].isel(wave=wave)) for kind in ("", "continuum_"))
            rows.append([f"{name} of wave {wave}", _number(own), _number(other)])
    largest = float(both["distance"].max())
    caption = f"The distance of the continuum from the chain in the course of time; it is {largest:.3g} at most.{left_out}"
    table = Table(f"At t = {float(last['t']):.4g}, in sites", ["quantity", "chain", "continuum"], rows)
    yield Section("comparison", "Chain and continuum", [], [Picture("distance", drawn, caption)], [table])
