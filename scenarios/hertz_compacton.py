"""One compacton for the Hertz contact of spheres, n = 3/2.

The paper names n = 3/2 as the case of spherical grains but shows no run. The compacton is 5 pi wide here (4.967 grains
in the chain), and so smooth at its edges (three continuous derivatives) that the viscosity does it little harm.
"""

from mol_compactons import IDA, Compacton, CompactScheme, GranularCompacton, Grid, Simulation, run

simulation = Simulation(
    title="One compacton",
    equation=GranularCompacton(n=3 / 2),
    grid=Grid(length=40, size=600),
    scheme=CompactScheme(second_difference="wide", viscosity=1e-3),
    initial=[Compacton(speed=1, center=10)],
    t_end=14,
    frames=141,
    integrator=IDA(rtol=1e-5),
)

if __name__ == "__main__":
    from mol_compactons.figures import overview

    dataset = run(simulation, "hertz_compacton.nc", overwrite=True)
    overview(dataset).savefig("hertz_compacton.png")
