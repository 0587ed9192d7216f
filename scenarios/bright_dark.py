"""A bright compacton of speed 1 runs into a dark one of speed 1/4.

The paper's abstract announces bright-dark pairs but shows none and gives no parameters; these are those of its Fig. 1b
with the slow wave turned over. The solution loses smoothness where the sign changes, and what comes out of the
collision is decided by the viscosity: do not take the heights afterwards for the equation's.
"""

from mol_compactons import IDA, Compacton, CompactScheme, GranularCompacton, Grid, Simulation, run

simulation = Simulation(
    title="A bright and a dark compacton",
    equation=GranularCompacton(n=3),
    grid=Grid(length=60, size=1200),
    scheme=CompactScheme(second_difference="wide", viscosity=1e-3),
    initial=[Compacton(speed=1, center=5.5), Compacton(speed=1 / 4, center=15.5, sign=-1)],
    t_end=40,
    frames=401,
    integrator=IDA(rtol=1e-5),
)

if __name__ == "__main__":
    from mol_compactons.figures import overview

    dataset = run(simulation, "bright_dark.nc", overwrite=True)
    overview(dataset).savefig("bright_dark.png")
