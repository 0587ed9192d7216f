from __future__ import annotations

import numpy as np
import pytest

from mol_compactons.figures import sweep_overview
from mol_compactons.figures.sweeps import MOST_LINES
from mol_compactons.studies.plan import product, together
from mol_compactons.studies.table import table
from tests.studies.sweeps import small
from tests.studies.test_table import row


def test_each_quantity_is_drawn_against_the_first_axis_with_a_line_for_each_of_the_others() -> None:
    plan = product(small(), {"grid.size": [60, 80, 100], "scheme.viscosity": [1e-4, 1e-2]}).described()
    rows = [
        row([[size, place]], drift=10.0 ** -(size + 3 * place), speed_after=[1.0 + size, 0.5 * place])
        for size in range(3)
        for place in range(2)
    ]
    figure = sweep_overview(table(plan, rows).drop_vars("seconds"))
    drift, speed = figure.axes[:2]
    assert (drift.get_title(), speed.get_title()) == ("drift", "speed after the first collision")
    assert [np.asarray(line.get_xdata()).tolist() for line in drift.lines] == [[60, 80, 100]] * 2
    assert np.asarray(drift.lines[1].get_ydata()) == pytest.approx([1e-3, 1e-4, 1e-5])
    assert (drift.get_yscale(), speed.get_yscale(), drift.get_xscale()) == ("log", "linear", "linear")
    assert len(speed.lines) == 4
    assert len({(line.get_marker(), line.get_linestyle()) for line in speed.lines}) == 4, "told apart in grey"
    assert drift.get_xlabel() == "grid.size"
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[:2] == ["viscosity 0.0001", "viscosity 0.01"]
    assert "viscosity 0.01, wave 1" in labels
    figure.canvas.draw()


def test_words_stand_below_their_members_and_what_is_not_known_is_left_out() -> None:
    plan = product(small(), {"integrator": ["Rosenbrock()", "IDA()"]}).described()
    figure = sweep_overview(table(plan, [row([[0]], height=1.0), row([[1]], "failed")]))
    assert "how long the member took [s]" in [axes.get_title() for axes in figure.axes]
    assert [text.get_text() for text in figure.axes[0].get_xticklabels()] == ["Rosenbrock()", "IDA()"]
    assert not figure.legends
    members = together(small(), {"grid.size": [60, 80], "t_end": [1, 2]}).described()
    figure = sweep_overview(table(members, [row([[1]], height=2.0)]))
    assert np.isnan(np.asarray(figure.axes[0].lines[0].get_ydata())[0])
    assert figure.axes[0].get_xlabel() == "member"
    figure.canvas.draw()


def test_a_panel_has_no_more_lines_than_can_be_told_apart() -> None:
    count = MOST_LINES + 5
    plan = product(small(), {"grid.size": [60, 80], "t_end": list(range(1, count + 1))}).described()
    figure = sweep_overview(table(plan, [row([[size, t]], height=1.0 + t) for size in range(2) for t in range(count)]))
    assert len(figure.axes[0].lines) == MOST_LINES
