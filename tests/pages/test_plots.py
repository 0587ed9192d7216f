from __future__ import annotations

import json
import sys

import numpy as np
import pytest

from mol_compactons import InputError
from mol_compactons.pages import plots


def test_lines_are_told_apart_without_colour() -> None:
    drawn = plots.figure("x", "y")
    for number in range(6):
        plots.add_line(drawn, number, [0, 1], [0, number], marks=True)
    looks = {(one.line.dash, one.marker.symbol) for one in drawn.data}
    assert len(looks) == 6


def test_a_text_is_no_markup_and_what_is_no_number_is_left_out() -> None:
    drawn = plots.figure("<a href='x'>", "y")
    plots.add_line(drawn, "<b>", [0.0, np.nan], [np.inf, 1.0])
    told = json.loads(drawn.to_json())
    assert told["layout"]["xaxis"]["title"]["text"] == "&lt;a href='x'&gt;"
    assert told["data"][0]["name"] == "&lt;b&gt;"
    assert (told["data"][0]["x"], told["data"][0]["y"]) == ([0.0, None], [None, 1.0])


def test_of_a_long_series_some_points_are_drawn_and_the_caption_says_so() -> None:
    places, told = plots.drawn_of(plots.MOST_POINTS)
    assert (places.size, told) == (plots.MOST_POINTS, "")
    places, told = plots.drawn_of(20_000)
    assert (places[0], places[-1], places.size) == (0, 19_999, plots.MOST_POINTS)
    assert told == f" Drawn are {plots.MOST_POINTS} of 20000 points."


def test_where_plotly_is_missing_one_sentence_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "plotly", None)
    with pytest.raises(InputError, match=r"needs plotly and jinja2; install them: pip install 'mol_compactons\[report\]'"):
        plots.figure("x", "y")
