"""The impulse of the paper's Fig. 3: compacton data in the chain, beside the continuum, at t = 0, 4, 9 and 14.

The paper names neither the exponent nor the length nor the phase I; these are the Hertz contact, n = 3/2, 40 sites and a
centre at a site, and n = 3 beside it, whose waves are little wider than a grain. The ends are held and the rate of the stress
is the derivative of the moving shape, as in the paper. Beside it runs the other way to take a compacton: grains with the
velocity of the continuum, so that the rate is a difference between neighbours. For n = 3 the two are different experiments,
and with the derivative the wave that comes out depends on where between the sites the centre lies, which the last table
shows.

The speed is c = 1, the only one at which chain and continuum agree (the chain has V = sqrt(c A)). The chain's own exact wave
runs too: it keeps its shape, where the compacton's data shed a little. docs/lattice.md discusses the numbers.
"""

from dataclasses import replace
from typing import Literal

import numpy as np

from mol_compactons import (
    ChainCompacton,
    GranularChain,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Simulation,
    SolitaryWave,
    Symplectic,
    run,
    track,
)
from mol_compactons.analysis.chain_and_continuum import compare, continuum_of, two_way_continuum_of

Rate = Literal["derivative", "site_difference"]
RATES: tuple[Rate, ...] = ("derivative", "site_difference")

simulation = Simulation(
    title="A compacton in a chain (Fig. 3)",
    equation=GranularChain(PowerContact(n=3 / 2), ends="held"),
    grid=Lattice(size=40),
    scheme=NearestNeighbours(),
    initial=[ChainCompacton(speed=1, center=10)],
    t_end=14,
    frames=141,
    integrator=Symplectic(step=0.02),
)


def started(chain: Simulation, rate: Rate, center: float = 10.0) -> Simulation:
    """The chain with one of the two rates of the stress, and another centre."""
    return replace(chain, initial=[ChainCompacton(speed=1, center=center, rate=rate)])


def study(chain: Simulation, name: str) -> None:
    """Chain with both rates, both continua and the exact wave of the chain: stored, drawn, and compared at the end."""
    from mol_compactons.figures import side_by_side

    smooth = run(continuum_of(chain), f"{name}_continuum.nc", overwrite=True)
    chains = {rate: run(started(chain, rate), f"{name}_{rate}.nc", overwrite=True) for rate in RATES}
    comparisons = {rate: compare(discrete, smooth) for rate, discrete in chains.items()}
    side_by_side({f"chain, {rate}": result for rate, result in comparisons.items()}, smooth, (0, 4, 9, 14)).savefig(
        f"{name}.png"
    )
    two_way = compare(chains["derivative"], run(two_way_continuum_of(chain)))
    print(f"{chain.headline}, t = {chain.t_end:g}: position, height and width, and the relative L2 distance from the chain")
    for rate, result in comparisons.items():
        last = result.isel(t=-1, wave=0)
        shape = chain.equation.solitary_shape(float(last.height))
        print(
            f"  chain, {rate}: {float(last.position):.3f} {float(last.height):.4f} {shape.half_width if shape else np.nan:.4f}"
        )
        print(f"    residual of the fit {float(last.residual):.1e}, distance {float(last.distance):.3f}")
    for label, result in (
        ("granular compacton equation", comparisons["derivative"]),
        ("Nesterenko's equation", two_way),
    ):
        last = result.isel(t=-1, wave=0)
        values = [float(last[f"continuum_{quantity}"]) for quantity in ("position", "height", "width")]
        print("  {}: {:.3f} {:.4f} {:.4f}, distance {:.3f}".format(label, *values, float(last.distance)))
    own = SolitaryWave(speed=1, center=10)
    final, exact = run(replace(chain, initial=[own])).R.values[-1], own.values(chain.equation, chain.grid, chain.t_end)[0]
    print(f"  the chain's exact wave: largest error {abs(final - exact).max():.1e} of {exact.max():.4f}")


def phases(chain: Simulation) -> None:
    """The wave that comes out, for centres at a site, between two, and half way there."""
    print(f"{chain.headline}: height and speed of the wave at t = {chain.t_end:g}, by rate and place of the centre")
    for rate in RATES:
        for center in (10.0, 10.25, 10.5):
            last = track(run(started(chain, rate, center)), newborn=False).isel(t=-1, wave=0)
            print(f"  {rate}, {center:g}: {float(last.height):.4f} {float(last.family_speed):.4f}")


if __name__ == "__main__":
    cubic = replace(simulation, title="The same with another exponent", equation=GranularChain(PowerContact(n=3), ends="held"))
    for one, name in ((simulation, "lattice_single"), (cubic, "lattice_single_n3")):
        study(one, name)
        phases(one)
