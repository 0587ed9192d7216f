"""Two dark compactons of speeds 1 and 1/4: Fig. 2 of the paper.

The equation with n = 3 is unchanged under W -> -W, so that this is `two_bright` with the sign changed, to round-off:
the analytic Jacobian of linear_solver="sparse" keeps the symmetry exactly, difference quotients do not. The paper gives
the speeds only; everything else is taken from its Fig. 1b.
"""

from mol_compactons import IDA, Compacton, CompactScheme, GranularCompacton, Grid, Simulation, run

simulation = Simulation(
    title="Two dark compactons (Fig. 2)",
    equation=GranularCompacton(n=3),
    grid=Grid(length=60, size=1200),
    scheme=CompactScheme(second_difference="wide", viscosity=1e-3),
    initial=[Compacton(speed=1, center=5.5, sign=-1), Compacton(speed=1 / 4, center=15.5, sign=-1)],
    t_end=40,
    frames=401,
    integrator=IDA(rtol=1e-5, linear_solver="sparse"),
)

if __name__ == "__main__":
    from mol_compactons.figures import overview

    dataset = run(simulation, "two_dark.nc", overwrite=True)
    overview(dataset).savefig("two_dark.png")
