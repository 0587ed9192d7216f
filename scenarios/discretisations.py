"""The discretisations beside each other on a smooth wave, a compacton and a collision: error, order, drift and cost.

The compact scheme with each of its second differences, the conservative one of the orders 2, 4 and 6, and the pseudo-spectral
one, for n = 3/2, 2 and 3. The smooth periodic wave and the compacton are exact and run without viscosity where a scheme stands
without; the others have one of 0.03 in grid units, of sixth order, which vanishes with the grid. So have all in the collision,
whose errors are those against a run on four times as many points, by the conservative scheme of order 6. A period of the
smooth wave has 16 to 128 points, the boxes of the compactons 150 to 600.

    python scenarios/discretisations.py                   # all of it, discretisations.nc and .png: half an hour
    python scenarios/discretisations.py --quick           # n = 3, and coarser grids: two minutes

What was interrupted goes on from where it was. docs/discretisations.md reads the result.
"""

import argparse
import math
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import xarray as xr

from mol_compactons import (
    Compacton,
    CompactScheme,
    ConservativeScheme,
    Family,
    FourierScheme,
    GranularCompacton,
    Grid,
    Midpoint,
    PeriodicWave,
    Processes,
    Rosenbrock,
    Simulation,
    converge,
    run,
)
from mol_compactons.figures import scheme_errors, schemes_overview
from mol_compactons.results.opening import write_tree
from mol_compactons.schemes.base import Scheme
from mol_compactons.studies import compare_schemes

SCHEMES: dict[str, Scheme] = {
    "compact, wide": CompactScheme("wide", viscosity_order=6),
    "compact, nearest": CompactScheme("nearest", viscosity_order=6),
    "compact, five_point": CompactScheme("five_point", viscosity_order=6),
    "conservative, order 2": ConservativeScheme(order=2, viscosity_order=6),
    "conservative, order 4": ConservativeScheme(order=4, viscosity_order=6),
    "conservative, order 6": ConservativeScheme(order=6, viscosity_order=6),
    "Fourier": FourierScheme(viscosity_order=6),
}

STABLE = ("compact, wide", "conservative, order 2", "conservative, order 4", "conservative, order 6")
"""Those that take a compacton across the grid without viscosity; the Fourier scheme can too, but its ripples last."""

VISCOSITY = 0.03

DEFAULT = SCHEMES["conservative, order 4"]


def smooth_wave(n: float) -> Simulation:
    """One period of a smooth travelling wave half way between the flat one and the compacton."""
    equation = GranularCompacton(n)
    wave = PeriodicWave(speed=1, crest=(1 + equation.compacton(1).amplitude) / 2 if n != 3 else 1.5**0.5)
    return Simulation(
        title="A smooth periodic wave",
        equation=equation,
        grid=Grid(length=wave.period(equation), size=128),
        scheme=DEFAULT,
        initial=[wave],
        t_end=0.5,
        frames=11,
        integrator=Midpoint(step=0.01, order=4),
    )


def compacton(n: float) -> Simulation:
    """One compacton of speed 1."""
    return Simulation(
        title="A compacton",
        equation=GranularCompacton(n),
        grid=Grid(length=40 if n < 2 else 30, size=600),
        scheme=DEFAULT,
        initial=[Compacton(speed=1, center=10)],
        t_end=4,
        frames=21,
        integrator=Rosenbrock(rtol=1e-5),
    )


def collision(n: float) -> Simulation:
    """A compacton of speed 1 overtakes one of speed 1/4, begins beside it, and has just passed it at the end."""
    equation = GranularCompacton(n)
    width = equation.compacton(1).width
    return Simulation(
        title="A collision of two compactons",
        equation=equation,
        grid=Grid(length=math.ceil(4.5 * width), size=600),
        scheme=DEFAULT.with_viscosity(0, VISCOSITY),
        initial=[Compacton(speed=1, center=width), Compacton(speed=0.25, center=2.05 * width)],
        t_end=math.ceil(2.8 * width),
        frames=4 * math.ceil(2.8 * width) + 1,
        integrator=Rosenbrock(rtol=1e-5),
    )


@dataclass(frozen=True)
class Problem:
    """What the schemes are tried on.

    Parameters
    ----------
    simulation : callable
        A simulation for each n.
    sizes : tuple of int
        Those of its grid.
    tolerances : tuple of float
        Or steps.
    viscosity : float
        In grid units.
    stable : bool
        Whether every scheme stands without viscosity.
    needs_reference : bool
        Whether no exact solution is known.
    """

    simulation: Callable[[float], Simulation]
    sizes: tuple[int, ...]
    tolerances: tuple[float, ...]
    viscosity: float = VISCOSITY
    stable: bool = False
    needs_reference: bool = False

    def families(self, quick: bool) -> Iterator[tuple[list[str], Family]]:
        """The runs that are made, and the names of their schemes: those with no viscosity, and those with some."""
        bare = [name for name in SCHEMES if self.stable or (self.viscosity == 0 and name in STABLE)]
        damped = [name for name in SCHEMES if name not in bare]
        for names, viscosity in ((bare, 0.0), (damped, VISCOSITY)):
            if names:
                yield (
                    names,
                    Family(
                        sizes=self.sizes[: -1 if quick else None],
                        schemes=tuple(SCHEMES[name] for name in names),
                        grid_viscosities=(viscosity,),
                        tolerances=self.tolerances,
                    ),
                )


PROBLEMS = {
    "smooth wave": Problem(smooth_wave, (16, 32, 64, 128), (0.02, 0.01), 0.0, stable=True),
    "compacton": Problem(compacton, (150, 300, 600), (1e-4, 1e-5), 0.0),
    "collision": Problem(collision, (150, 300, 450), (1e-4, 1e-5), needs_reference=True),
}

EXPONENTS = (1.5, 2.0, 3.0)

simulation = collision(n=3)


def references(problem: Problem, n: float, folder: Path) -> list[xr.Dataset]:
    """Runs on grids twice and four times as fine as the finest, by the conservative scheme of order 6."""
    scheme = SCHEMES["conservative, order 6"].with_viscosity(0, problem.viscosity)
    own = replace(problem.simulation(n), scheme=scheme)
    sizes = [factor * max(problem.sizes) for factor in (2, 4)]
    return [
        run(replace(own, grid=replace(own.grid, size=size)), folder / f"reference_n{n:g}_{size}.nc", resume=True)
        for size in sizes
    ]


def study(folder: Path, quick: bool) -> xr.Dataset:
    """The whole study: one Dataset along problem, scheme, size and n."""
    tables = []
    for name, problem in PROBLEMS.items():
        for n in EXPONENTS[-1:] if quick else EXPONENTS:
            for schemes, family in problem.families(quick):
                place = f"{name}, n = {n:g}, viscosity {family.grid_viscosities[0]:g}"
                tree = converge(
                    problem.simulation(n),
                    family,
                    partial(print, f"{place}:", flush=True),
                    engine=Processes(),
                    folder=folder / place.replace(", ", "_").replace(" = ", "").replace(" ", "_"),
                )
                finer = references(problem, n, folder) if problem.needs_reference else []
                table = compare_schemes(tree, finer).assign_coords(scheme=schemes)
                tables.append(table.drop_vars("reference").expand_dims(problem=[name]))
    whole = xr.merge(tables, join="outer", compat="no_conflicts", combine_attrs="drop_conflicts")
    words = {name: one.fillna("").astype(str) for name, one in whole.data_vars.items() if one.dtype == object}
    return (
        whole.assign(words)
        .reindex(problem=list(PROBLEMS), scheme=list(SCHEMES))
        .assign_attrs(title="Discretisations beside each other")
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="n = 3 alone, and coarser grids")
    quick = parser.parse_args().quick
    folder = Path("discretisations_quick_members" if quick else "discretisations_members")
    folder.mkdir(exist_ok=True)
    result = study(folder, quick)
    write_tree(result, "discretisations.nc")
    scheme_errors(result).savefig("discretisations.png", dpi=100)
    schemes_overview(result).savefig("discretisations_costs.png", dpi=100)
    shutil.rmtree(folder)
    print(result)
