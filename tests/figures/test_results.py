from typing import Any

import matplotlib
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from mol_compactons import (
    Compacton,
    CompactScheme,
    GranularChain,
    Grid,
    Lattice,
    NearestNeighbours,
    Nesterenko,
    PowerContact,
    Simulation,
    SolitaryWave,
    Symplectic,
    run,
)
from mol_compactons.analysis.drift import drift
from mol_compactons.figures.results import DEEPEST_GAP, GAPS, PROFILES, label_of, overview, profiles, shown, waterfall
from tests.figures.arrangement import places
from tests.systems import one_compacton


def test_the_overview_draws_profiles_and_drifts() -> None:
    matplotlib.use("Agg")
    dataset = run(one_compacton(frames=101))
    figure = overview(dataset)
    left, right = figure.axes
    assert places(figure) == [(0, 0), (0, 1)]
    assert len(left.lines) == PROFILES + 1  # and the bar of the amplitude
    assert {line.get_label() for line in right.lines} == {"mass", "momentum", "energy"}
    first = left.lines[0].get_ydata()
    assert np.argmax(np.asarray(first)) == np.argmax(dataset.W.values[0])
    figure.canvas.draw()


def test_each_profile_is_lifted_by_its_time_and_the_last_one_has_moved() -> None:
    """The height of the first is 12 % of the time shown, and all have its scale; a white patch hides what is behind each."""
    dataset = run(one_compacton(frames=6, t_end=5))
    left = overview(dataset).axes[0]
    scale = 0.12 * 5 / float(abs(dataset.W[0]).max())
    *curves, bar = left.lines
    assert len(curves) == len(left.collections) == 6
    assert np.ptp(np.asarray(bar.get_ydata())) == pytest.approx(scale * float(left.texts[0].get_text()))
    for line, t, profile in zip(curves, dataset.t.values, dataset.W.values, strict=True):
        assert np.array_equal(np.asarray(line.get_xdata()), dataset.x.values)
        assert np.asarray(line.get_ydata()) == pytest.approx(t + scale * profile, abs=1e-12)
    places = [float(dataset.x[np.argmax(np.asarray(line.get_ydata()))]) for line in curves]
    assert places[-1] - places[0] == pytest.approx(5, abs=float(dataset.x[1] - dataset.x[0]))
    assert [line.get_zorder() for line in curves] == sorted((line.get_zorder() for line in curves), reverse=True)
    assert max(left.get_yticks()) <= 5
    assert left.get_xlim() == (dataset.x.values[0], dataset.x.values[-1])


def test_the_curves_of_the_drifts_are_the_drifts() -> None:
    """On a logarithmic scale, from the second frame on: the first has none."""
    dataset = run(one_compacton(frames=6, t_end=5))
    right, changes = overview(dataset).axes[1], drift(dataset)
    assert right.get_yscale() == "log"
    for line in right.lines:
        change = np.abs(changes[str(line.get_label())].values[1:])
        assert change.max() > 0
        assert np.array_equal(np.asarray(line.get_xdata()), dataset.t.values[1:])
        assert np.array_equal(np.asarray(line.get_ydata()), np.maximum(change, 1e-17))


def test_where_nothing_is_conserved_the_picture_says_so() -> None:
    dataset = run(one_compacton()).drop_vars(["mass", "momentum", "energy"])
    right = overview(dataset).axes[1]
    assert not right.lines
    assert [text.get_text() for text in right.texts] == ["nothing is conserved"]
    assert not list(right.get_xticks()), "axes without a line have no scale"


def test_another_component_can_be_asked_for() -> None:
    simulation = Simulation(
        equation=Nesterenko(3), grid=Grid(20, 40), scheme=CompactScheme(), initial=[Compacton(1, 8)], t_end=1, frames=2
    )
    dataset, axes = run(simulation), Figure().subplots()
    waterfall(dataset, axes, "v")
    drawn = np.asarray(axes.lines[0].get_ydata())
    assert np.ptp(drawn) == pytest.approx(0.12)
    assert np.argmax(drawn) == np.argmax(dataset.v.values[0])
    assert axes.get_title().startswith("v(t, x)")


def test_of_displacements_the_stresses_are_drawn() -> None:
    simulation = Simulation(
        equation=GranularChain(PowerContact(1.5), form="displacements", ends="free"),
        grid=Lattice(60),
        scheme=NearestNeighbours(),
        initial=[SolitaryWave(1, 20)],
        t_end=10,
        frames=3,
        integrator=Symplectic(),
    )
    left = overview(run(simulation)).axes[0]
    assert left.get_title().startswith("R(t, k)")
    assert int(np.argmax(np.asarray(left.lines[0].get_ydata()))) + 1 == 20


def test_few_frames_are_drawn_once_each() -> None:
    figure = overview(run(one_compacton(frames=3)))
    assert len(figure.axes[0].lines) == 3 + 1


def test_the_order_of_dimensions_changes_nothing() -> None:
    """Even of a square result, of which nothing else tells time from space."""
    dataset = run(one_compacton(frames=150))
    assert dataset.sizes["t"] == dataset.sizes["x"]
    lines, others = (overview(result).axes[0].lines for result in (dataset, dataset.transpose("x", "t")))
    assert len(lines) == PROFILES + 1
    for line, other in zip(lines, others, strict=True):
        assert np.array_equal(np.asarray(line.get_ydata()), np.asarray(other.get_ydata()))


def test_waves_that_point_down_are_seen_from_below() -> None:
    """The later profile is nearer, and hides what is above it; the picture is that of the bright wave turned over."""
    dark, bright = (overview(run(one_compacton(frames=6, t_end=5, sign=sign))).axes[0] for sign in (-1, 1))
    orders = [line.get_zorder() for line in dark.lines[:-1]]
    assert orders == sorted(orders)
    for line, other, t in zip(dark.lines[:-1], bright.lines[:-1], range(6), strict=True):
        assert np.asarray(line.get_ydata()) - t == pytest.approx(t - np.asarray(other.get_ydata()), abs=1e-5)
    tops = [float(np.asarray(patch.get_paths()[0].vertices)[:, 1].max()) for patch in dark.collections]
    assert len(set(tops)) == 1


def test_an_opened_gap_does_not_crush_the_waves() -> None:
    stress = xr.DataArray([[0.0, 1.0, 0.0], [0.0, 0.5, -50.0]], dims=("t", "k"), name="R")
    gap = stress.assign_attrs({GAPS: True})
    assert shown(gap).min() == -DEEPEST_GAP
    assert label_of(gap) == "R, cut off at -0.5"
    assert shown(stress).min() == -50
    assert label_of(stress) == "R"


def one_wave_of_a_chain(kind: Any, sign: int) -> Simulation:
    return Simulation(
        equation=GranularChain(PowerContact(n=2, linear=float(kind == "rarefaction"), kind=kind)),
        grid=Lattice(40),
        scheme=NearestNeighbours(),
        initial=[SolitaryWave(speed=1.4, center=15, sign=sign)],
        t_end=5,
        frames=6,
        integrator=Symplectic(step=0.1),
    )


def test_a_dark_wave_of_a_chain_is_no_gap() -> None:
    """Of contacts that pull, a negative stress is a wave, and is shown whole; of those that part, it is a gap."""
    dark = run(one_wave_of_a_chain("rarefaction", -1))
    left = overview(dark).axes[0]
    assert np.array_equal(shown(profiles(dark)), dark.R.values)
    assert float(left.texts[0].get_text()) == 1
    assert GAPS not in dark.R.attrs
    bright = run(one_wave_of_a_chain("one_sided", 1))
    assert profiles(bright).attrs[GAPS]


def test_the_frame_of_a_waterfall_is_in_front_of_what_hides() -> None:
    for sign in (-1, 1):
        left = overview(run(one_compacton(frames=50, sign=sign))).axes[0]
        frame = min(spine.get_zorder() for spine in left.spines.values())
        assert all(patch.get_zorder() < frame for patch in left.collections)


def test_a_wave_far_from_zero_begins_at_its_time() -> None:
    """W between 4 and 6 is drawn from its lowest value on, which the picture says."""
    x, t = np.linspace(0, 6, 60, endpoint=False), np.linspace(0, 10, 11)
    wave = xr.Dataset({"W": (("t", "x"), 5 + np.sin(x[None, :] - t[:, None]))}, {"t": t, "x": x}, run(one_compacton()).attrs)
    wave.W.attrs = run(one_compacton()).W.attrs
    for sign, said in ((1, "W - 4"), (-1, "W + 4")):
        axes = Figure().subplots()
        waterfall(wave.assign(W=(sign * wave.W).assign_attrs(wave.W.attrs)), axes)
        assert axes.get_title() == f"{said}, lifted by its time"
        assert axes.get_ylabel() == f"t, and {said}"
        first = np.asarray(axes.lines[0].get_ydata())
        assert np.abs(first).min() == pytest.approx(0, abs=0.01)
        assert np.abs(first).max() == pytest.approx(0.12 * 10, rel=0.01)


def test_drifts_are_told_apart_in_grey_and_their_legend_covers_nothing() -> None:
    figure = overview(run(one_compacton(frames=21)))
    figure.canvas.draw()
    right = figure.axes[1]
    assert len({line.get_linestyle() for line in right.lines}) == len(right.lines) == 3
    legend = right.get_legend()
    assert legend is not None
    assert legend.get_window_extent().y1 <= right.get_window_extent().y0
