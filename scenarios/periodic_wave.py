"""A smooth periodic wave for the Hertz contact, n = 3/2, travels twice round its box.

The paper looks at compactons only; below them, for each speed, lies a family of smooth periodic waves that have no edge.
They are exact solutions, and the right test of a scheme's formal order. No viscosity is needed.
"""

from mol_compactons import IDA, CompactScheme, GranularCompacton, Grid, PeriodicWave, Simulation, run

equation = GranularCompacton(n=3 / 2)
wave = PeriodicWave(speed=1, crest=1.2)
period = wave.period(equation)

simulation = Simulation(
    title="A smooth periodic wave",
    equation=equation,
    grid=Grid(length=2 * period, size=64),
    scheme=CompactScheme(second_difference="five_point", viscosity=0),
    initial=[wave],
    t_end=4 * period,
    frames=201,
    integrator=IDA(rtol=1e-6),
)

if __name__ == "__main__":
    from mol_compactons.figures import overview

    dataset = run(simulation, "periodic_wave.nc", overwrite=True)
    overview(dataset).savefig("periodic_wave.png")
