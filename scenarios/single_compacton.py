"""One compacton of speed 1 moves to the right: Fig. 1a of the paper.

The paper gives N = 600, h = 30/N, tau = 0.01, the viscosity 1e-3, speed 1 and centre 5.5, for n = 3. It does not give
the end of the run; t = 14 is where its lattice figure ends. The exact compacton then has its peak at x = 19.5. The
viscosity, a hundred times what the grid needs, is nearly all of the error that is left.
"""

from mol_compactons import IDA, Compacton, CompactScheme, GranularCompacton, Grid, Simulation, run

simulation = Simulation(
    title="One compacton (Fig. 1a)",
    equation=GranularCompacton(n=3),
    grid=Grid(length=30, size=600),
    scheme=CompactScheme(second_difference="wide", viscosity=1e-3),
    initial=[Compacton(speed=1, center=5.5)],
    t_end=14,
    frames=141,
    integrator=IDA(rtol=1e-5),
)

if __name__ == "__main__":
    from mol_compactons.figures import overview

    dataset = run(simulation, "single_compacton.nc", overwrite=True)
    overview(dataset).savefig("single_compacton.png")
