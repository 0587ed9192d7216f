"""The impulse of the paper's Fig. 3: compacton data in the chain, beside the continuum, at t = 0, 4, 9 and 14.

The paper names neither the exponent nor the boundary conditions nor the length; these are the Hertz contact, n = 3/2, held
ends and 40 sites, and n = 3 beside it, whose waves are little wider than a grain. The speed is c = 1, the only one at which
chain and continuum agree (the chain has V = sqrt(c A)). The chain's own exact wave runs beside: it keeps its shape, where
the compacton's data shed a little. docs/lattice.md discusses the numbers.
"""

from dataclasses import replace

from mol_compactons import (
    Compacton,
    GranularChain,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Simulation,
    SolitaryWave,
    Symplectic,
    run,
)
from mol_compactons.analysis.chain_and_continuum import compare, continuum_of, two_way_continuum_of

simulation = Simulation(
    title="A compacton in a chain (Fig. 3)",
    equation=GranularChain(PowerContact(n=3 / 2), ends="held"),
    grid=Lattice(size=40),
    scheme=NearestNeighbours(),
    initial=[Compacton(speed=1, center=10)],
    t_end=14,
    frames=141,
    integrator=Symplectic(step=0.02),
)


def study(chain: Simulation, name: str) -> None:
    """Chain, both continua and the exact wave of the chain: stored, drawn, and compared at the end."""
    from mol_compactons.figures import side_by_side

    discrete = run(chain, f"{name}.nc", overwrite=True)
    smooth = run(continuum_of(chain), f"{name}_continuum.nc", overwrite=True)
    comparison = compare(discrete, smooth)
    side_by_side(comparison, smooth, (0, 4, 9, 14)).savefig(f"{name}.png")
    two_way = compare(discrete, run(two_way_continuum_of(chain)))
    print(f"{chain.headline}, t = {chain.t_end:g}")
    for label, result in (("granular compacton equation", comparison), ("Nesterenko's equation", two_way)):
        last = result.isel(t=-1, wave=0)
        print(f"  {label}: relative L2 distance {float(last.distance):.3f}")
        for quantity in ("position", "height", "width"):
            print(f"    {quantity}: chain {float(last[quantity]):.3f}, continuum {float(last[f'continuum_{quantity}']):.3f}")
    own = SolitaryWave(speed=1, center=10)
    final, exact = run(replace(chain, initial=[own])).R.values[-1], own.values(chain.equation, chain.grid, chain.t_end)[0]
    print(f"  the chain's exact wave: largest error {abs(final - exact).max():.1e} of {exact.max():.4f}")


if __name__ == "__main__":
    study(simulation, "lattice_single")
    cubic = replace(simulation, title="The same with another exponent", equation=GranularChain(PowerContact(n=3), ends="held"))
    study(cubic, "lattice_single_n3")
