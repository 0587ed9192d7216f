"""What a page consists of, and how it becomes one HTML file.

Pictures are figures of plotly, which is written into the page. The field of a run is there once, as 32-bit floats: the map
shows all of it, and the profile one row at a time. A policy in the page forbids all that would come from elsewhere.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import InputError

Array = NDArray[np.float64]

MISSING = "A report needs plotly and jinja2; install them: pip install 'mol_compactons[report]'."


VERDICTS = {
    "well": ("agrees", "converged", "complete"),
    "open": ("doubtful", "converging"),
    "ill": ("contradicts", "not converged", "failed"),
}
"""What words in cells mean."""

LONGEST_UNBROKEN = 24
"""How many characters a cell has that stands in one line."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure of plotly.

    Parameters
    ----------
    name : str
        Of its place in the page.
    figure : plotly Figure
        What is drawn.
    caption : str
        What stands below it, and what a screen reader says.
    choices : dict
        For each word of a list to choose from, which traces are seen; empty where all are.
    height : int
        In pixels, where it is not the usual one.
    """

    name: str
    figure: Any
    caption: str
    choices: dict[str, list[int]] | None = None
    height: int | None = None


@dataclass(frozen=True)
class Table:
    """A table.

    Parameters
    ----------
    caption : str
        What it is about.
    headings : sequence of str
        Of its columns; the first names the rows.
    rows : sequence of sequences of str
        Its cells.
    sortable : bool
        Whether a reader may sort its rows by any column.
    """

    caption: str
    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    sortable: bool = False


@dataclass(frozen=True, eq=False)
class Section:
    """A part of a page.

    Parameters
    ----------
    name, title : str
        Of its place, and its heading.
    text : sequence of str
        Paragraphs.
    pictures, tables : sequence
        What follows.
    markup : str
        HTML that this program made.
    code : str
        What is to be copied.
    """

    name: str
    title: str
    text: Sequence[str] = ()
    pictures: Sequence[Picture] = ()
    tables: Sequence[Table] = ()
    markup: str = ""
    code: str = ""


@dataclass(frozen=True, eq=False)
class Moving:
    """A field in the course of time, as a profile that moves and as a map.

    Parameters
    ----------
    name, space : str
        Of the field and of its coordinate.
    t : array, shape (frames,)
        The times.
    series : sequence of (str, array, array)
        What is drawn in the profile: its label, its points, and its values, shape (frames, points); the first is on the map.
    profile, map : plotly Figure
        The figures, without the values.
    caption : str
        What is seen.
    """

    name: str
    space: str
    t: Array
    series: Sequence[tuple[str, Array, Array]]
    profile: Any
    map: Any
    caption: str

    @property
    def encoded(self) -> str:
        """All values as little-endian 32-bit floats in base64."""
        with np.errstate(over="ignore"):  # what is beyond these floats is a gap in the picture
            flat = np.concatenate([np.ravel(values) for _, _, values in self.series]).astype("<f4")
        return base64.b64encode(flat.tobytes()).decode()

    @property
    def places(self) -> list[dict[str, int]]:
        """Where each series begins among the values, and how many points it has."""
        sizes = [values.size for _, _, values in self.series]
        starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
        return [
            {"start": int(start), "points": int(points.size)}
            for start, (_, points, _) in zip(starts, self.series, strict=True)
        ]


@dataclass(frozen=True, eq=False)
class Page:
    """A page.

    Parameters
    ----------
    title, status : str
        Its heading, and how what it is about ended.
    lead : sequence of str
        What it is about, in a few lines.
    sections : sequence of Section
        Its parts.
    moving : Moving, optional
        The field of a run.
    """

    title: str
    status: str
    lead: Sequence[str]
    sections: Sequence[Section]
    moving: Moving | None = None


def rendered(page: Page) -> str:
    """A page as HTML.

    Raises
    ------
    InputError
        If plotly or jinja2 is not installed.
    """
    try:
        from jinja2 import Environment, StrictUndefined
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise InputError(MISSING) from None
    sources = {name: files(__package__).joinpath(f"page.{name}").read_text(encoding="utf-8") for name in ("html", "css", "js")}
    template = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    scripts = [get_plotlyjs(), sources["js"]]
    return template.from_string(sources["html"]).render(
        page=page,
        look=look_of,
        verdict_of=verdict_of,
        style=sources["css"],
        scripts=scripts,
        policy=policy_for(scripts),
        data=as_data(_for_script(page)),
        field=page.moving.encoded if page.moving else "",
    )


def verdict_of(word: str) -> str:
    """What a word means: "well", "open", "ill", or "" where it is no verdict."""
    return next((look for look, words in VERDICTS.items() if word in words), "")


def look_of(cell: str) -> str:
    """The classes of a cell: what a verdict means, and whether it is a line or less, which is not broken."""
    return f"{verdict_of(cell)} {'short' if len(cell) <= LONGEST_UNBROKEN else 'long'}".strip()


def policy_for(scripts: Sequence[str]) -> str:
    """The policy of a page: nothing is loaded, and no script runs but these."""
    own = " ".join(f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}'" for script in scripts)
    return f"default-src 'none'; script-src {own}; style-src 'unsafe-inline'; img-src data: blob:; font-src data:"


def _for_script(page: Page) -> dict[str, Any]:
    pictures = [
        {"name": one.name, "choices": one.choices or {}, **_figure(one.figure)}
        for section in page.sections
        for one in section.pictures
    ]
    moving = page.moving
    if moving is None:
        return {"pictures": pictures, "moving": None}
    return {
        "pictures": pictures,
        "moving": {
            "t": moving.t.tolist(),
            "places": moving.places,
            "profile": _figure(moving.profile),
            "map": _figure(moving.map),
        },
    }


def _figure(figure: Any) -> dict[str, Any]:
    whole = json.loads(figure.to_json())
    return {"data": whole["data"], "layout": whole["layout"]}


def as_data(content: Any) -> str:
    """JSON that may stand in an element of a page: it holds nothing that could end this."""
    return json.dumps(content).replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
