from __future__ import annotations

import numpy as np
import pytest

from mol_compactons.analysis.stability import StabilityStudy, report
from mol_compactons.figures import stability_overview
from tests.figures.arrangement import places


def test_the_functional_and_the_eigenvalues_of_the_report_are_drawn() -> None:
    dataset = report(StabilityStudy(n=3, sizes=(20, 40, 80)))
    figure = stability_overview(dataset)
    left, right = figure.axes
    assert places(figure) == [(0, 0), (0, 1)]
    curve = left.lines[0]
    factor, functional = (np.asarray(data) for data in (curve.get_xdata(), curve.get_ydata()))
    assert np.array_equal(functional, dataset.functional.values)
    assert factor[functional.argmin()] == pytest.approx(1, abs=0.05)
    drawn = [line for line in right.lines if len(np.asarray(line.get_xdata())) == dataset.sizes["resolution"]]
    assert len(drawn) == dataset.sizes["constraint"] * dataset.sizes["mode"]
    free = dataset.eigenvalue.sel(constraint="free", mode=0)
    assert np.array_equal(np.asarray(drawn[0].get_xdata()), free.resolution.values)
    assert np.array_equal(np.asarray(drawn[0].get_ydata()), free.values)
    assert right.get_legend() is None, "it would cover a line"
    (legend,) = figure.legends
    assert [tick.get_text() for tick in right.get_xticklabels()] == ["20", "40", "80"]
    assert [text.get_text() for text in legend.get_texts()] == ["free perturbations", "constrained perturbations"]
    figure.canvas.draw()
