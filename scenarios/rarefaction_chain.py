"""A dark pulse in a chain with the force -A z^2 + B z, the paper's (Forcerar): the mirror of compression, up to a point.

Where R < 0 this force resists the more the farther it is pulled, as A |z| z + B z does for compression: the exact wave of
rarefaction of either travels alike. Where R > 0 it gives way: beyond R = B / (2 A) the chain is unstable there.
"""

from dataclasses import replace

import numpy as np

from mol_compactons import GranularChain, Lattice, NearestNeighbours, PowerContact, Simulation, SolitaryWave, Symplectic, run

simulation = Simulation(
    title="A dark solitary wave in a chain",
    equation=GranularChain(PowerContact(n=2, linear=1, kind="rarefaction")),
    grid=Lattice(size=120),
    scheme=NearestNeighbours(),
    initial=[SolitaryWave(speed=1.4, center=30, sign=-1)],
    t_end=50,
    frames=201,
    integrator=Symplectic(step=0.02),
)

if __name__ == "__main__":
    from mol_compactons.figures import overview

    dataset = run(simulation, "rarefaction_chain.nc", overwrite=True)
    overview(dataset).savefig("rarefaction_chain.png")
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, simulation.t_end)[0]
    print(f"after t = 50: largest change {np.abs(dataset.R.values[-1] - exact).max():.1e} of {-exact.min():.4f}")
    odd = run(replace(simulation, equation=GranularChain(PowerContact(n=2, linear=1))))
    print(f"largest distance from the chain with F = |z| z + z: {float(np.abs(odd.R - dataset.R).max()):.1e}")
