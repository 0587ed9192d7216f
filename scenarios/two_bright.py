"""A compacton of speed 1 overtakes one of speed 1/4: Fig. 1b of the paper.

The paper gives the speeds 1 and 1/4, the centres 5.5 and 15.5, h = 0.05 and the viscosity 1e-3, for n = 3. It gives
neither the end of the run nor the length of the box; at t = 40 in a box of 60 the faster one is well ahead. The
compactons take their shapes up again, not completely: a small ripple stays behind, and the viscosity lowers both of
them.
"""

from mol_compactons import IDA, Compacton, CompactScheme, GranularCompacton, Grid, Simulation, run

simulation = Simulation(
    title="Two bright compactons (Fig. 1b)",
    equation=GranularCompacton(n=3),
    grid=Grid(length=60, size=1200),
    scheme=CompactScheme(second_difference="wide", viscosity=1e-3),
    initial=[Compacton(speed=1, center=5.5), Compacton(speed=1 / 4, center=15.5)],
    t_end=40,
    frames=401,
    integrator=IDA(rtol=1e-5, linear_solver="sparse"),
)

if __name__ == "__main__":
    from mol_compactons.figures import overview

    dataset = run(simulation, "two_bright.nc", overwrite=True)
    overview(dataset).savefig("two_bright.png")
