"""A bright and a dark compacton together for n = 2, in the paper's universal equation (PDEComprar).

The paper writes this equation down but shows no run of it. The slow dark wave is overtaken by the bright one, and the
solution loses smoothness where its sign changes: what comes out is decided by the viscosity, as in `bright_dark`.
"""

from mol_compactons import IDA, Compacton, CompactScheme, GranularCompacton, Grid, Simulation, run

simulation = Simulation(
    title="A bright and a dark compacton",
    equation=GranularCompacton(n=2),
    grid=Grid(length=60, size=1200),
    scheme=CompactScheme(second_difference="wide", viscosity=1e-3),
    initial=[Compacton(speed=1, center=8), Compacton(speed=1 / 4, center=20, sign=-1)],
    t_end=40,
    frames=401,
    integrator=IDA(rtol=5e-5),
)

if __name__ == "__main__":
    from mol_compactons.figures import overview

    dataset = run(simulation, "universal_pair.nc", overwrite=True)
    overview(dataset).savefig("universal_pair.png")
