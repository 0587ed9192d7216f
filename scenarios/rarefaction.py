"""A wave of rarefaction for n = 2: a dark compacton of (PDErar).

For an even n waves of rarefaction need a force of the other sign, (Forcerar) in the paper, and so an equation of their own,
which shows no run. In the odd extension both are one equation, and the dark wave is the bright one turned over.
"""

from mol_compactons import IDA, Compacton, CompactScheme, GranularCompacton, Grid, Simulation, run

simulation = Simulation(
    title="A wave of rarefaction",
    equation=GranularCompacton(n=2),
    grid=Grid(length=30, size=600),
    scheme=CompactScheme(second_difference="wide", viscosity=1e-4),
    initial=[Compacton(speed=1, center=8, sign=-1)],
    t_end=14,
    frames=141,
    integrator=IDA(rtol=1e-5),
)

if __name__ == "__main__":
    from mol_compactons.figures import overview

    dataset = run(simulation, "rarefaction.nc", overwrite=True)
    overview(dataset).savefig("rarefaction.png")
