from __future__ import annotations

from itertools import pairwise

from matplotlib.colors import is_color_like
from matplotlib.lines import Line2D, lineStyles

from mol_compactons.figures.style import DASHES, LINE, MARKERS, told_apart


def test_what_tells_lines_apart_is_known_to_matplotlib_and_different() -> None:
    assert is_color_like(LINE)
    assert len(set(MARKERS)) == len(MARKERS)
    assert len({lineStyles[dash] for dash in DASHES}) == len(DASHES) == 4
    assert all(Line2D([], [], marker=marker).get_marker() == marker for marker in MARKERS)


def test_lines_differ_in_their_marks_as_long_as_there_are_marks() -> None:
    """Neighbours differ in their dashes too."""
    made = [told_apart(number) for number in range(len(MARKERS))]
    assert len({one["marker"] for one in made}) == len(MARKERS)
    assert all(one["linestyle"] != following["linestyle"] for one, following in pairwise(made))
    assert Line2D([], [], **told_apart(len(MARKERS))).get_marker() == MARKERS[0]
