"""Where the panels of a figure stand."""

from __future__ import annotations

from matplotlib.figure import Figure


def places(figure: Figure) -> list[tuple[int, int]]:
    """The row and the column of each panel."""
    specs = [axes.get_subplotspec() for axes in figure.axes]
    return [(spec.rowspan.start, spec.colspan.start) for spec in specs if spec is not None]
