from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mol_compactons import (
    ChainCompacton,
    Compacton,
    GranularChain,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Simulation,
    Symplectic,
    compare,
    continuum_of,
    run,
)
from mol_compactons.figures import side_by_side
from tests.figures.arrangement import places

RATES: Any = ("derivative", "site_difference")


def test_dots_on_a_line_at_each_time_and_their_distance() -> None:
    """At t = 0 both are the same wave, so that the dots lie on the line."""
    chain = Simulation(
        equation=GranularChain(PowerContact(1.5)),
        grid=Lattice(40),
        scheme=NearestNeighbours(),
        initial=[Compacton(speed=1, center=10.3)],
        t_end=2,
        frames=5,
        integrator=Symplectic(step=0.05),
    )
    continuum = run(continuum_of(chain))
    comparison = compare(run(chain), continuum)
    figure = side_by_side(comparison, continuum, times=(0, 1.5))
    first, second, last = figure.axes
    assert places(figure) == [(0, 0), (1, 0), (2, 0)]
    line, dots = first.lines
    assert np.array_equal(np.asarray(dots.get_xdata()), np.arange(40))
    assert np.array_equal(np.asarray(dots.get_ydata()), comparison.R.values[0])
    on_line = np.interp(np.arange(40), np.asarray(line.get_xdata()), np.asarray(line.get_ydata()))
    assert on_line == pytest.approx(comparison.R.values[0], abs=1e-2)
    legend = first.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["continuum", "chain"]
    moved = np.asarray(second.lines[1].get_ydata())
    assert np.abs(moved - comparison.R.values[0]).max() > 0.1
    assert second.get_title() == "t = 1.5"
    assert np.array_equal(np.asarray(last.lines[0].get_ydata()), comparison.distance.values)
    figure.canvas.draw()
    label, panel = last.yaxis.label.get_window_extent(), last.get_window_extent()
    assert panel.y0 <= label.y0 < label.y1 <= panel.y1, "the name of the axis is no longer than the axis"


def test_several_chains_beside_one_continuum() -> None:
    """Each with its dots, its own colour and its distance."""
    chains = [
        Simulation(
            equation=GranularChain(PowerContact(3), ends="held"),
            grid=Lattice(40),
            scheme=NearestNeighbours(),
            initial=[ChainCompacton(speed=1, center=10.3, rate=rate)],
            t_end=2,
            frames=5,
            integrator=Symplectic(step=0.05),
        )
        for rate in RATES
    ]
    continuum = run(continuum_of(chains[0]))
    comparisons = {f"by {rate}": compare(run(chain), continuum) for rate, chain in zip(RATES, chains, strict=True)}
    first, second, last = side_by_side(comparisons, continuum, times=(0, 1.5)).axes
    legend = first.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["continuum", *comparisons]
    assert len({str(line.get_color()) for line in first.lines}) == 3
    dots = [np.asarray(line.get_ydata()) for line in second.lines[1:]]
    for drawn, distance, comparison in zip(dots, last.lines, comparisons.values(), strict=True):
        assert np.array_equal(drawn, comparison.R.values[3])
        assert np.array_equal(np.asarray(distance.get_ydata()), comparison.distance.values)
    assert np.abs(dots[0] - dots[1]).max() > 0.1
