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


@pytest.mark.parametrize(("last", "ticks"), [(3.0, "D2"), (1e6, 1)])
def test_logarithmic_axes_have_as_many_ticks_as_have_room(last: float, ticks: object) -> None:
    drawn = plots.figure("x", "y", log="x")
    plots.add_line(drawn, "a", [1.0, last], [1.0, 2.0])
    assert plots.settled(drawn).layout.xaxis.dtick == ticks
    assert plots.settled(drawn).layout.yaxis.dtick is None


def test_where_plotly_is_missing_one_sentence_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "plotly", None)
    with pytest.raises(InputError, match=r"needs plotly and jinja2; install them: pip install 'mol_compactons\[report\]'"):
        plots.figure("x", "y")
