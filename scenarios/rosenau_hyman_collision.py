"""Three compactons of K(2,2) with the speeds 2, 3/2 and 1 pass through each other: the classic of Rosenau and Hyman.

Their paper (Phys. Rev. Lett. 70, 564, 1993) shows such a collision; the places, the box and the viscosity here are our own.
The waves come out with their shapes, and leave a small ripple of both signs behind.
"""

from mol_compactons import IDA, Compacton, CompactScheme, Grid, RosenauHyman, Simulation, run

simulation = Simulation(
    title="Three compactons",
    equation=RosenauHyman(m=2, n=2),
    grid=Grid(length=150, size=1500),
    scheme=CompactScheme(second_difference="wide", viscosity=1e-3),
    initial=[Compacton(speed=2, center=10), Compacton(speed=3 / 2, center=25), Compacton(speed=1, center=40)],
    t_end=80,
    frames=401,
    integrator=IDA(rtol=5e-5),
)

if __name__ == "__main__":
    from mol_compactons.figures import overview

    dataset = run(simulation, "rosenau_hyman_collision.nc", overwrite=True)
    overview(dataset).savefig("rosenau_hyman_collision.png")
