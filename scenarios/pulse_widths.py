"""The chain against its continuum, over the exponent n and the width of the pulse.

A Gaussian pulse of stress falls apart into two, one to each side. The chain and Nesterenko's equation, on one point for each
site, start from the same and are compared after half the width of the pulse in time, before its halves steepen. On waves of
little height the continuum has the dispersion of the chain but for its next term, which falls with the fourth power of the
width. On this pulse the distance falls with the second: nonlinear terms of dispersion differ already in the first. Printed,
stored and drawn are the distance and the power at which it falls, for n = 3/2, 2 and 3 and widths of 4 to 32 grains:
`python scenarios/pulse_widths.py`, a minute.
"""

from dataclasses import replace

import numpy as np
import xarray as xr

from mol_compactons import (
    IDA,
    CompactScheme,
    Formula,
    GranularChain,
    Grid,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Processes,
    Simulation,
    Symplectic,
    run,
    sweep,
)
from mol_compactons.results.opening import write_tree
from mol_compactons.studies import Axis, Plan

EXPONENTS = (1.5, 2.0, 3.0)
WIDTHS = (4, 8, 16, 32)

PULSE = "1 + 0.5 * exp(-(x - middle)**2 / width**2)"


def chain(n: float, width: int) -> Simulation:
    """A chain that is under the stress 1, with a pulse half as high."""
    size = 16 * width
    return Simulation(
        title="A pulse in a chain under stress",
        equation=GranularChain(PowerContact(n=n)),
        grid=Lattice(size=size),
        scheme=NearestNeighbours(),
        initial=[Formula(PULSE, parameters={"middle": size / 2, "width": width})],
        t_end=width / 2,
        frames=11,
        integrator=Symplectic(step=0.02, order=6),
    )


def continuum(discrete: Simulation) -> Simulation:
    """Nesterenko's equation with the same pulse, on one point for each site."""
    assert isinstance(discrete.equation, GranularChain)
    size = discrete.grid.size
    return replace(
        discrete,
        equation=discrete.equation.law.continuum,
        grid=Grid(length=size, size=size),
        scheme=CompactScheme("five_point", viscosity=0),
        integrator=IDA(rtol=1e-8),
    )


def distance(dataset: xr.Dataset) -> float:
    """How far the continuum is from the chain at the end, in L2, relative to the pulse."""
    smooth = run(continuum(Simulation.from_json(dataset.attrs["simulation"]))).S.values[-1]
    discrete = dataset.R.values[-1]
    return float(np.linalg.norm(discrete - smooth) / np.linalg.norm(discrete - 1))


simulation = chain(3, 8)

PLAN = Plan(
    simulation,
    [
        Axis({"equation.law.n": EXPONENTS}),
        Axis(
            {
                "initial.0.parameters.width": WIDTHS,
                "initial.0.parameters.middle": [8 * width for width in WIDTHS],
                "grid.size": [16 * width for width in WIDTHS],
                "t_end": [width / 2 for width in WIDTHS],
            }
        ),
    ],
)

if __name__ == "__main__":
    from matplotlib.figure import Figure

    table = sweep(PLAN, folder="pulse_widths", engine=Processes(), quantities={"distance": distance}, tracked=False)
    table = table.swap_dims(member_1="width")
    ratio = np.log(table.distance.values[:, :-1] / table.distance.values[:, 1:]) / np.log(2)
    table["order"] = ("n", "width"), np.column_stack([np.full(len(EXPONENTS), np.nan), ratio])
    table["order"].attrs = {"long_name": "power of the width at which the distance falls", "units": "1"}
    write_tree(table, "pulse_widths.nc")
    print(table.distance.to_pandas(), table.order.to_pandas(), sep="\n")
    figure = Figure(figsize=(5, 4), layout="constrained")
    axes = figure.subplots()
    for n, marker in zip(EXPONENTS, "osd", strict=True):
        axes.loglog(WIDTHS, table.distance.sel(n=n), marker=marker, label=f"n = {n:g}")
    axes.loglog(WIDTHS, float(table.distance.max()) * (WIDTHS[0] / np.array(WIDTHS)) ** 2.0, color="lightgrey", zorder=0)
    axes.set(xlabel="width of the pulse, in grains", ylabel="relative distance of chain and continuum")
    axes.legend()
    figure.savefig("pulse_widths.png", dpi=150)
