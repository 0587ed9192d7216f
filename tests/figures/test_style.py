from __future__ import annotations

from matplotlib.colors import is_color_like
from matplotlib.lines import Line2D, lineStyles

from mol_compactons.figures.style import DASHES, LINE, MARKERS


def test_what_tells_lines_apart_is_known_to_matplotlib_and_different() -> None:
    assert is_color_like(LINE)
    assert len(set(MARKERS)) == len(MARKERS)
    assert len({lineStyles[dash] for dash in DASHES}) == len(DASHES) == 4
    assert all(Line2D([], [], marker=marker).get_marker() == marker for marker in MARKERS)
