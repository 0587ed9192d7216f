import matplotlib
import numpy as np

from mol_compactons import GranularChain, Lattice, NearestNeighbours, PowerContact, Simulation, SolitaryWave, Symplectic, run
from mol_compactons.figures.results import PROFILES, overview
from tests.systems import one_compacton


def test_the_overview_draws_profiles_and_drifts() -> None:
    matplotlib.use("Agg")
    dataset = run(one_compacton(frames=101))
    figure = overview(dataset)
    left, right = figure.axes
    assert len(left.lines) == PROFILES
    assert {line.get_label() for line in right.lines} == {"mass", "momentum", "energy"}
    first = left.lines[0].get_ydata()
    assert np.argmax(np.asarray(first)) == np.argmax(dataset.W.values[0])
    figure.canvas.draw()


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
    assert len(figure.axes[0].lines) == 3


def test_the_order_of_dimensions_changes_nothing() -> None:
    """Even of a square result, of which nothing else tells time from space."""
    dataset = run(one_compacton(frames=150))
    assert dataset.sizes["t"] == dataset.sizes["x"]
    lines, others = (overview(result).axes[0].lines for result in (dataset, dataset.transpose("x", "t")))
    assert len(lines) == PROFILES
    for line, other in zip(lines, others, strict=True):
        assert np.array_equal(np.asarray(line.get_ydata()), np.asarray(other.get_ydata()))
