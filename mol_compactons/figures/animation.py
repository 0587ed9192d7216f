"""Films of results: profiles that move, of one run or of several, seen from the laboratory or from what moves along."""

from __future__ import annotations

import itertools
import math
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.chain_and_continuum import on_lattice
from mol_compactons.errors import InputError, require
from mol_compactons.figures.results import evenly, profiles, shown
from mol_compactons.figures.style import DASHES, LINE
from mol_compactons.progress import PICTURES, Show, show_nobody, showing_progress
from mol_compactons.results.places import check_target, written_whole
from mol_compactons.results.reading import field_names, space_of

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

MOST_FRAMES = 400
"""How many pictures a film has unless told otherwise."""

DPI = 100
PANEL = (12.0, 3.6)
"""The size of a panel in inches; the pixels are even numbers, as films need them."""

MARGIN = 0.06
"""The room above the highest and below the lowest value, relative to the range."""

ONE_LINE = 120
"""How many signs of labels stand beside each other above a film; longer ones stand below each other."""

COLORS = 64
"""How many colours a GIF has."""

COLOURS = (LINE, "#c55a11", "#548235", "#7f6084")
"""Of runs on one axis; their dashes tell them apart in grey."""

ENDINGS = (".mp4", ".gif", ".webp")


@dataclass(frozen=True, eq=False)
class Course:
    """The profiles of one run, ready to be drawn.

    Parameters
    ----------
    label : str
        What it is called.
    t, x : array
        Its times and points.
    values : array, shape (times, points)
        The field.
    name : str
        That of the field.
    space : str
        That of the coordinate.
    period : float
        After how long a distance the line closes.
    """

    label: str
    t: Array
    x: Array
    values: Array
    name: str
    space: str
    period: float

    def at(self, t: float, speed: float) -> Array:
        """The profile at the frame next to a time, seen from what moves with a speed; the line is a ring."""
        frame = int(np.abs(self.t - t).argmin())
        profile: Array = self.values[frame]
        if not speed:
            return profile
        places = (self.x + speed * self.t[frame] - self.x[0]) % self.period
        return np.asarray(np.interp(places, np.append(self.x - self.x[0], self.period), np.append(profile, profile[0])))

    @property
    def limits(self) -> tuple[float, float]:
        """The range that is shown."""
        low, high = float(self.values.min()), float(self.values.max())
        room = MARGIN * ((high - low) or 1.0)
        return low - room, high + room


def courses(datasets: Sequence[xr.Dataset], labels: Sequence[str] = ()) -> list[Course]:
    """What a film shows of results; a continuum beside a chain is shown in the coordinates of the chain.

    Parameters
    ----------
    datasets : sequence of xarray.Dataset
        Results; that of a chain first, if there are a chain and its continuum.
    labels : sequence of str, optional
        What they are called; by default by their titles.
    """
    chain = next((one for one in datasets if space_of(one) == "k"), None)
    made = []
    for index, dataset in enumerate(datasets):
        field = profiles(dataset)
        if chain is not None and space_of(dataset) == "x":
            field = on_lattice(dataset, str(chain.attrs["simulation"])).rename(field_names(dataset)[0])
        space = space_of(dataset)
        x = field[space].values
        label = labels[index] if labels else str(dataset.attrs.get("title", "")).split(";")[0]
        values = shown(field)
        require(values.shape[0] > 1, f"A film needs results of two frames or more; {label or 'one'} has {values.shape[0]}.")
        require(bool(np.isfinite(values).all()), f"{label or 'A result'} holds NaN or infinity, of which no film can be made.")
        period = float(x[1] - x[0]) * x.size
        made.append(Course(label, field["t"].values, x, values, str(field.name), str(space), period))
    return made


def animate(
    datasets: Sequence[xr.Dataset],
    path: str | Path,
    *,
    labels: Sequence[str] = (),
    together: bool = False,
    speed: float = 0.0,
    rate: float = 25.0,
    most_frames: int = MOST_FRAMES,
    overwrite: bool = False,
    progress: bool | None = None,
) -> int:
    """Make a film of results.

    Parameters
    ----------
    datasets : sequence of xarray.Dataset
        Results; a chain and its continuum are shown in the coordinates of the chain.
    path : str or Path
        Where to: the ending says which kind, ``.mp4`` (needs imageio-ffmpeg, the extra ``film``), ``.gif`` or ``.webp``.
    labels : sequence of str, optional
        What the results are called.
    together : bool
        Whether all are drawn on one axis, or each has its own.
    speed : float
        That of the frame from which the waves are seen; 0 for the laboratory.
    rate : float
        Pictures for each second.
    most_frames : int
        How many pictures at most; of more frames some are left out.
    overwrite : bool
        Whether a file that exists may be replaced.
    progress : bool, optional
        Whether to show how many pictures are drawn, as for `mol_compactons.run`.

    Returns
    -------
    int
        How many pictures the film has.

    Raises
    ------
    InputError
        If there is nothing to show, the ending is another, a number is out of range, or the file cannot be written.
    """
    path = Path(path)
    require(len(datasets) > 0, "There is no result to make a film of; give one.")
    require(not labels or len(labels) == len(datasets), f"There are {len(datasets)} results and {len(labels)} labels.")
    require(path.suffix.lower() in ENDINGS, f"{path} must end in {', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}, to be a film.")
    require(0.1 <= rate <= 100, f"rate = {rate:g} pictures a second must lie between 0.1 and 100.")
    require(2 <= most_frames <= 10**5, f"most_frames = {most_frames} must lie between 2 and 100000.")
    require(abs(speed) < 1e9, f"speed = {speed:g} must lie between -1e9 and 1e9.")
    check_target(path, overwrite)
    films = courses(datasets, labels)
    times = _times(films, most_frames)
    write = _write_mp4 if path.suffix.lower() == ".mp4" else _write_by_pillow
    with written_whole(path) as part, showing_progress(times.size, PICTURES, progress) as show:
        write(part, _pictures(films, times, together, speed, show), rate)
    return times.size


def _times(films: Sequence[Course], most_frames: int) -> Array:
    """The times of the pictures: those of the run with the most frames, as far as all go."""
    end = min(float(one.t[-1]) for one in films)
    longest = max((one.t[one.t <= end * (1 + 1e-12)] for one in films), key=len)
    return np.asarray(longest[evenly(longest.size, most_frames)])


def _pictures(
    films: Sequence[Course], times: Array, together: bool, speed: float, show: Show = show_nobody
) -> Iterator[Picture]:
    """The pictures, one after the other: what does not move is drawn once."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows = 1 if together else len(films)
    figure = Figure(figsize=(PANEL[0], PANEL[1] * rows), dpi=DPI, layout="constrained")
    canvas: Any = FigureCanvasAgg(figure)
    panels = figure.subplots(rows, 1, squeeze=False)[:, 0]
    lines = []
    for index, one in enumerate(films):
        axes = panels[0 if together else index]
        color, dash = COLOURS[index % len(COLOURS)], DASHES[index % len(DASHES)]
        lines.append(axes.plot(one.x, one.values[0], color=color, linestyle=dash if together else "-", label=one.label)[0])
        axes.set(xlabel=_across(one, speed), ylabel=one.name, xlim=(one.x[0], one.x[-1]))
        limits = [other.limits for other in (films if together else (one,))]
        axes.set_ylim(min(low for low, _ in limits), max(high for _, high in limits))
        if not together:
            axes.set_title(one.label, fontsize=10, parse_math=False)
    if together:
        named = [one.label.lstrip("_") for one in films]
        columns = len(films) if sum(map(len, named)) < ONE_LINE else 1
        legend = figure.legend(lines, named, loc="outside upper center", ncols=columns, fontsize=9, frameon=False)
        for text in legend.get_texts():
            text.set_parse_math(False)
    digits = int(np.clip(1 - math.floor(math.log10(float(np.diff(times).min()))), 0, 15))
    clock = panels[0].text(0.01, 0.96, "t = 0", transform=panels[0].transAxes, va="top", animated=True)
    for line in lines:
        line.set_animated(True)
    canvas.draw()
    background = canvas.copy_from_bbox(figure.bbox)
    for number, t in enumerate(times):
        canvas.restore_region(background)
        for line, one in zip(lines, films, strict=True):
            line.set_ydata(one.at(float(t), speed))
            line.axes.draw_artist(line)
        clock.set_text(f"t = {t:.{digits}f}")
        panels[0].draw_artist(clock)
        yield np.asarray(canvas.buffer_rgba()).copy()
        show(number + 1)


def _across(one: Course, speed: float) -> str:
    return one.space if not speed else f"{one.space} - {speed:g} t"


def _write_mp4(path: Path, pictures: Iterator[Picture], rate: float) -> None:
    try:
        import imageio_ffmpeg
    except ImportError:
        raise InputError("A film as .mp4 needs imageio-ffmpeg: pip install 'mol_compactons[film]'; or end in .webp.") from None
    first = next(pictures)
    size = f"{first.shape[1]}x{first.shape[0]}"
    raw = ["-f", "rawvideo", "-pix_fmt", "rgba", "-s", size, "-r", f"{rate:g}", "-i", "-"]
    coded = ["-an", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "18", "-movflags", "+faststart", str(path)]
    try:
        command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-loglevel", "error", *raw, *coded]
        encoder = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    except (OSError, RuntimeError) as error:
        raise InputError(f"The encoder of films cannot be started ({error}); end the name in .webp or .gif.") from None
    with encoder:
        assert encoder.stdin is not None
        assert encoder.stderr is not None
        try:
            for picture in itertools.chain([first], pictures):
                encoder.stdin.write(picture.tobytes())
            encoder.stdin.close()
        except BrokenPipeError:
            pass  # it says why
        said = encoder.stderr.read().decode(errors="replace").strip()
    if encoder.returncode != 0:
        reason = said.splitlines()[-1] if said else f"status {encoder.returncode}"
        raise InputError(f"The film could not be encoded ({reason}); end its name in .webp or .gif.")


def _write_by_pillow(path: Path, pictures: Iterator[Picture], rate: float) -> None:
    from PIL import Image

    images: Any = (Image.fromarray(picture).convert("RGB") for picture in pictures)
    if path.suffix.lower() == ".gif":  # Pillow's own choice of colours takes four times as long
        images = (image.quantize(COLORS, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE) for image in images)
    first = next(images)
    first.save(path, save_all=True, append_images=images, duration=round(1000 / rate), loop=0)
