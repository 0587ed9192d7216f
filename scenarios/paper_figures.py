"""The paper's figures by one command: Figs 1a, 1b, 2, 3 and 4, and the bright-dark pair that its abstract announces.

    python scenarios/paper_figures.py                   # the folder paper_figures: .pdf and .png of each, and the runs
    python scenarios/paper_figures.py --folder figs     # another folder

Each stands in the paper's arrangement, and says below it what the paper left open, what was chosen, and what differs. The
numbers in these sentences are those of the runs. Runs that are in the folder already are not made again. docs/paper_figures.md
reads them.
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from mol_compactons import Simulation, compare, continuum_of, first_collision, run, track
from mol_compactons.analysis.chain_and_continuum import on_lattice
from mol_compactons.cli.scenarios import load
from mol_compactons.figures import chain_beside_continuum, waterfall

Shorten = Callable[[Simulation], Simulation]
"""What makes another simulation of one of the figures, as a coarser one for a trial."""

Panels = Sequence[Any]


@dataclass(frozen=True)
class Plate:
    """A figure of the paper.

    Parameters
    ----------
    title : str
        What it shows.
    runs : tuple of str
        The scenarios of its panels; of a chain the continuum runs too.
    times : tuple of float
        Of a chain: the times of its panels, two in a row.
    left_open, chosen : str
        What the paper does not say, and what was taken.
    differs : callable
        What is seen here, from the results.
    """

    title: str
    runs: tuple[str, ...]
    left_open: str
    chosen: str
    differs: Callable[[Sequence[xr.Dataset]], str]
    times: tuple[float, ...] = ()


def of_one_compacton(results: Sequence[xr.Dataset]) -> str:
    (dataset,) = results
    simulation = Simulation.from_json(dataset.attrs["simulation"])
    exact = simulation.exact_state(float(dataset.t[-1]))
    assert exact is not None
    last = dataset.W.values[-1]
    error = float(np.linalg.norm(last - exact[0]) / np.linalg.norm(exact[0]))
    return f"The relative L2 error at the end is {error:.1e}, nearly all of it the viscosity."


def of_two_waves(results: Sequence[xr.Dataset]) -> str:
    tracks = track(results[-1], newborn=False)
    if tracks.attrs["lost"]:
        momentum = results[-1].momentum.values
        return f"{tracks.attrs['lost']} The run loses {100 * (1 - momentum[-1] / momentum[0]):.0f} % of its momentum."
    outcome = first_collision(tracks)
    heights = 100 * (np.abs(outcome.height_after / outcome.height_before).values - 1)
    shifts = outcome.phase_shift.values
    return (
        f"The heights change by {heights[0]:+.1f} % and {heights[1]:+.1f} %, and the shifts are {shifts[0]:+.2f} and "
        f"{shifts[1]:+.2f}; the paper calls that elastic."
    )


def of_one_and_two(results: Sequence[xr.Dataset]) -> str:
    return f"(a) {of_one_compacton(results[:1])} (b) {of_two_waves(results[1:])}"


def of_a_chain(results: Sequence[xr.Dataset]) -> str:
    last = results[0].isel(t=-1)
    ahead = (last.position - last.continuum_position).values
    waves = " and ".join(f"{one:+.2f}" for one in ahead)
    return f"At the end the chain is {waves} sites ahead, at a relative L2 distance of {float(last.distance):.2f}."


PLATES = {
    "fig1": Plate(
        "Fig. 1: a compacton of speed 1, and one that overtakes another of speed 1/4",
        ("single_compacton", "two_bright"),
        "the ends of the runs, and the length of the box of (b)",
        "t = 14, where the figure of the chain ends, and t = 40 in a box of 60; the second difference with (2h)², without "
        "which the scheme destroys the compacton",
        of_one_and_two,
    ),
    "fig2": Plate(
        "Fig. 2: two dark compactons",
        ("two_dark",),
        "all but the speeds",
        "the run of Fig. 1b with the sign changed, of which the equation makes the same",
        of_two_waves,
    ),
    "fig3": Plate(
        "Fig. 3: a compacton's data in a chain (dots) on its continuum (lines)",
        ("lattice_single",),
        "exponent, force constant, length, ends and phase",
        "the Hertz contact, n = 3/2, at the speed 1, where chain and continuum agree; 40 sites, held ends, a centre at a "
        "site; the rate of the stress with its missing factor and sign",
        of_a_chain,
        (0, 4, 9, 14),
    ),
    "fig4": Plate(
        "Fig. 4: two compactons in a chain (dots) on its continuum (lines)",
        ("lattice_collision",),
        "the parameters of Fig. 3, and both speeds",
        "c = 1 and 1/4 as in Fig. 1b, 80 sites; the slow wave moves at sqrt(c) = 1/2 in the chain and at 1/4 in the continuum",
        of_a_chain,
        (0, 3, 21.5, 31),
    ),
    "bright_dark": Plate(
        "The pair of the abstract: a bright compacton runs into a dark one",
        ("bright_dark",),
        "everything: the abstract announces such pairs, and no figure shows one",
        "the speeds, centres, grid and viscosity of Fig. 1b, the slow wave dark",
        of_two_waves,
    ),
}

simulation = load("single_compacton")


def results_of(plate: Plate, folder: Path, shorten: Shorten) -> list[xr.Dataset]:
    """The runs of a figure, from the folder where they are there; of a chain the comparison, and its continuum."""
    results = []
    for name in plate.runs:
        own = shorten(load(name))
        results.append(run(own, folder / f"{name}.nc", resume=True))
        if plate.times:
            results.append(run(continuum_of(own), folder / f"{name}_continuum.nc", resume=True))
    return [compare(*results), results[1]] if plate.times else results


def draw(plate: Plate, results: Sequence[xr.Dataset]) -> Any:
    """A figure with its panels, and below it what the paper left open, what was chosen, and what is seen."""
    from matplotlib.figure import Figure

    columns = 2 if plate.times else len(results)
    rows = len(plate.times) // 2 or 1
    figure = Figure(figsize=(5.2 * columns, 2.6 * rows + 1.7 if plate.times else 5.4), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    if plate.times:
        comparison, continuum = results
        line = on_lattice(continuum, comparison.attrs["simulation"])
        for axes, t in zip(panels, plate.times, strict=True):
            chain_beside_continuum({"chain": comparison}, line, t, axes)
            axes.set_xlabel("k")
        panels[0].legend(frameon=False, fontsize=8)
    else:
        for letter, axes, dataset in zip("ab", panels, results, strict=False):
            waterfall(dataset, axes)
            axes.set_title(f"({letter})" if len(results) > 1 else "")
    figure.suptitle(plate.title, fontsize=11)
    told = f"Left open: {plate.left_open}. Chosen: {plate.chosen}. Seen: {plate.differs(results)}"
    figure.supxlabel(told, fontsize=8, ha="left", x=0.02, wrap=True)
    return figure


def make(folder: Path, shorten: Shorten = lambda own: own, endings: Sequence[str] = ("pdf", "png")) -> dict[str, Any]:
    """All figures, also in a folder.

    Parameters
    ----------
    folder : Path
        Where to, made if it is not there.
    shorten : callable, optional
        What is run in the place of each simulation.
    endings : sequence of str
        Of the files of each.
    """
    folder.mkdir(parents=True, exist_ok=True)
    figures = {}
    for name, plate in PLATES.items():
        results = results_of(plate, folder, shorten)
        figures[name] = draw(plate, results)
        for ending in endings:
            figures[name].savefig(folder / f"{name}.{ending}", dpi=120)
        for dataset in results:
            dataset.close()
    return figures


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=Path("paper_figures"), help="where to (default: paper_figures)")
    for figure in make(parser.parse_args().folder).values():
        print(f"{figure.get_suptitle()}. {figure.get_supxlabel()}")
