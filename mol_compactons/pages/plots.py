"""Figures of plotly as the pages have them: told apart by marks and dashes too, and readable in light and in dark."""

from __future__ import annotations

import html
from typing import Any

import numpy as np

from mol_compactons.errors import InputError
from mol_compactons.figures.results import evenly
from mol_compactons.pages.document import MISSING

COLOURS = ("#3b82c4", "#e07b39", "#3a9d6e", "#b56bb0", "#b08a00", "#8a8f98")
"""Of one line after the other, on white as on black."""

DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")

SYMBOLS = ("circle", "square", "diamond", "cross", "triangle-up", "x")

MOST_POINTS = 600
"""How many points of a series in time are drawn."""


def library() -> Any:
    """The module plotly.graph_objects; raises `InputError` where it is not installed."""
    try:
        from plotly import graph_objects
    except ImportError:
        raise InputError(MISSING) from None
    return graph_objects


def plain(text: object) -> str:
    """A text that plotly takes for no markup."""
    return html.escape(str(text), quote=False)


def figure(across: str, up: str, *, log: str = "") -> Any:
    """An empty figure.

    Parameters
    ----------
    across, up : str
        The labels of the axes.
    log : str
        Which axes are logarithmic: "", "x", "y" or "xy".
    """
    drawn = library().Figure()
    drawn.update_layout(
        template="none",
        margin={"l": 66, "r": 16, "t": 12, "b": 48},
        font={"size": 13},
        legend={"orientation": "h", "yanchor": "bottom", "y": 1.02, "x": 0},
        hovermode="closest",
    )
    for axis, label in (("x", across), ("y", up)):
        settings: dict[str, Any] = {"title": {"text": plain(label)}, "automargin": True, "zeroline": False}
        settings["exponentformat"] = "power"
        if axis in log:
            settings["type"] = "log"
        drawn.update_layout({f"{axis}axis": settings})
    return drawn


def drawn_of(count: int) -> tuple[Any, str]:
    """Which points of a series in time are drawn, and a sentence on that where some are left out."""
    places = evenly(count, MOST_POINTS)
    return places, f" Drawn are {places.size} of {count} points." if places.size < count else ""


def add_line(
    drawn: Any, label: object, x: Any, y: Any, *, marks: bool = False, number: int | None = None, **more: Any
) -> None:
    """Add a line, and marks on it if these are few; what is no number is left out.

    Parameters
    ----------
    drawn : plotly Figure
        Where to.
    label : object
        Its name.
    x, y : array
        Its points.
    marks : bool
        Whether the points are marked.
    number : int, optional
        Which of the looks it has; by default the next one.
    """
    index = len(drawn.data) if number is None else number
    look = {"color": COLOURS[index % len(COLOURS)], "dash": DASHES[index % len(DASHES)], "width": 1.8}
    drawn.add_scatter(
        name=plain(label),
        x=cleaned(x),
        y=cleaned(y),
        mode="lines+markers" if marks else "lines",
        line=look,
        marker={"symbol": SYMBOLS[index % len(SYMBOLS)], "size": 7},
        **more,
    )


def cleaned(values: Any) -> list[Any]:
    """Values as plotly takes them: None for what is no number, and words as they are."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        return [plain(value) for value in array.tolist()]
    return [value if np.isfinite(value) else None for value in array.tolist()]
