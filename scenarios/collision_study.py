"""What a collision of two bright compactons does to them, n = 2 and 3: phase shifts, heights and ripple with error bars.

The paper says that compactons "completely reestablish their shapes" after a collision. The parameters are those of its Fig.
1b on a grid that starts a little farther apart. Two limits are computed and kept apart: the conservative one, whose
viscosity nu h^5 vanishes with the grid, and the viscous one, h -> 0 before eps -> 0, both by the conservative and the
compact scheme. Two bright waves keep their sign, so that the compact scheme needs no larger viscosity than the other.

After the collision the slow wave goes on changing its speed, for n = 2 until t = 90 and later. The boxes are so long that no
wave meets what was left behind before the end. For n = 3 a longer time would add more of the viscosity than it settles. All
four studies take about an hour, most of it the viscous limit of n = 2; docs/schemes.md has the numbers.
"""

import sys

import xarray as xr

from mol_compactons import (
    Compacton,
    CompactScheme,
    ConservativeScheme,
    GranularCompacton,
    Grid,
    Rosenbrock,
    Simulation,
)
from mol_compactons.figures import convergence_overview
from mol_compactons.results.opening import write_tree
from mol_compactons.schemes.base import Scheme
from mol_compactons.studies.convergence import converge
from mol_compactons.studies.family import Family
from mol_compactons.studies.report import differences_of_limits, report

LENGTHS = {2: 130.0, 3: 80.0}
ENDS = {2: 120.0, 3: 70.0}
"""The boxes and the times that the waves of each n need to settle."""

FINEST = {2: 2600, 3: 800}
"""Points for a spacing of 0.05 and 0.1: on finer grids the compact scheme blows up for n = 3."""

COMPACT = CompactScheme(second_difference="five_point", viscosity_order=6)


def conservative(n: float, finest: int = 0, other: Scheme = COMPACT) -> Family:
    """The family whose viscosity vanishes with the grid, with points of `FINEST` where nothing else is said."""
    finest = finest or FINEST[int(n)]
    return Family(
        sizes=(finest // 4, finest // 2, finest),
        schemes=(ConservativeScheme(order=4, viscosity_order=6), other),
        grid_viscosities=(0.1, 0.03),
        tolerances=(1e-4, 1e-5),
    )


def viscous(n: float) -> Family:
    """The family whose viscosity stays while the grid is refined; waves with a kink lose more by it, and need finer grids."""
    finest = int(LENGTHS[int(n)] / (0.05 if n == 2 else 0.025))
    return Family(
        sizes=(finest // 4, finest // 2, finest),
        schemes=(ConservativeScheme(order=4), CompactScheme(second_difference="five_point")),
        viscosities=(8e-3, 4e-3, 2e-3) if n == 2 else (2e-3, 1e-3, 5e-4),
        tolerances=(1e-4, 1e-5),
    )


def collision(n: float, sign: int = 1) -> Simulation:
    """A bright compacton of speed 1 behind one of speed 1/4, bright or dark."""
    t_end = ENDS[int(n)]
    return Simulation(
        title=f"A bright and a {'bright' if sign > 0 else 'dark'} compacton",
        equation=GranularCompacton(n),
        grid=Grid(length=LENGTHS[int(n)], size=FINEST[int(n)]),
        scheme=ConservativeScheme(order=4, grid_viscosity=0.03, viscosity_order=6),
        initial=[Compacton(speed=1, center=8), Compacton(speed=1 / 4, center=20, sign=sign)],
        t_end=t_end,
        frames=4 * int(t_end) + 1,
        integrator=Rosenbrock(rtol=1e-5),
    )


def study(simulation: Simulation, name: str, families: dict[str, Family]) -> None:
    """Both limits of a collision: printed, stored and drawn."""
    summaries = []
    for limit, family in families.items():
        tree = converge(simulation, family, lambda line: print(line, file=sys.stderr))
        write_tree(tree, f"{name}_{limit}.nc")
        convergence_overview(tree).savefig(f"{name}_{limit}.png")
        print(simulation.headline, *report(tree), sep="\n", flush=True)
        summaries.append(tree["summary"].to_dataset())
    print(*differences_of_limits(xr.concat(summaries, "limit", join="outer")), sep="\n", flush=True)


simulation = collision(n=3)

if __name__ == "__main__":
    for n in (2, 3):
        study(collision(n), f"collision_study_n{n}", {"conservative": conservative(n), "viscous": viscous(n)})
