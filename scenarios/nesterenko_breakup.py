"""Nesterenko's equation destroys its own compacton, the faster the finer the grid; the chain behind it does not.

The paper says of the compactons of (EqNest2) that they "are destroyed in a very short time" and gives no parameters; these
are the Hertz contact, n = 3/2, a = A = 1 and speed 1. The equation is ill-posed: about a stress S0 waves shorter than 2 pi
a / sqrt(12) grow at a rate that rises like k^2, so that every non-zero state breaks up, compacton or not, and halving the
grid spacing makes it four times as fast. Run as a script it measures this at four resolutions, compares the growth with
linear theory, and lets the chain carry the same pulse for a hundred times as long. What fails is the continuum at
wavelengths below the grains, not the wave.
"""

from dataclasses import replace

import numpy as np

from mol_compactons import (
    IDA,
    Compacton,
    CompactScheme,
    GranularChain,
    Grid,
    IntegrationError,
    Lattice,
    NearestNeighbours,
    Nesterenko,
    PowerContact,
    Simulation,
    run,
)
from mol_compactons.stencils import COMPACT_FIRST, COMPACT_MASS, SECOND_FIVE_POINT

LENGTH = 20
equation = Nesterenko(n=3 / 2)
wave = Compacton(speed=1, center=6)

simulation = Simulation(
    title="A compacton of Nesterenko's equation breaks up",
    equation=equation,
    grid=Grid(length=LENGTH, size=8 * LENGTH),
    scheme=CompactScheme(second_difference="five_point", viscosity=0),
    initial=[wave],
    t_end=0.25,
    frames=251,
    integrator=IDA(rtol=1e-5, max_steps=2000),
)

chain = Simulation(
    title="The same pulse in the chain",
    equation=GranularChain(PowerContact(n=3 / 2)),
    grid=Lattice(size=60),
    scheme=NearestNeighbours(),
    initial=[Compacton(speed=1, center=10)],
    t_end=30,
    frames=301,
    integrator=IDA(rtol=1e-8, max_order=5),
)


def breakup(points_per_grain: int) -> tuple[float, float]:
    """When the compacton is 10 % off, and how fast the deviation grows on the way from 1 % to 10 %."""
    t_end = 24.0 / points_per_grain**2
    grid = Grid(length=LENGTH, size=points_per_grain * LENGTH)
    try:
        dataset = run(replace(simulation, grid=grid, t_end=t_end, frames=801))
    except IntegrationError as error:
        dataset = error.dataset
    exact = np.array([wave.values(equation, grid, t)[0] for t in dataset.t.values])
    deviation = np.linalg.norm(dataset.S.values - exact, axis=1) / np.linalg.norm(exact, axis=1)
    end = int(np.argmax(deviation > 0.1))
    start = end - int(np.argmax(deviation[end::-1] < 0.01))
    rate = np.log(deviation[end] / deviation[start]) / float(dataset.t[end] - dataset.t[start])
    return float(dataset.t[end]), float(rate)


def fastest_rate(points_per_grain: int) -> float:
    """The largest growth rate of linear theory at the crest of the compacton, with the derivatives of the scheme."""
    stress = equation.compacton(1.0).amplitude
    theta = np.linspace(0, np.pi, 1001)
    first = np.abs(COMPACT_FIRST.symbol(theta) / COMPACT_MASS.symbol(theta)) * points_per_grain
    second = -SECOND_FIVE_POINT.symbol(theta).real * points_per_grain**2
    squared = equation.n * stress ** (equation.n - 1) * first**2 * (second / 12 - 1)
    return float(np.sqrt(squared.max()))


if __name__ == "__main__":
    from mol_compactons.figures import overview

    print("points per grain   10 % off at t   growth rate   fastest of linear theory")
    for count in (2, 4, 8, 16):
        moment, rate = breakup(count)
        print(f"{count:16d} {moment:15.3g} {rate:13.3g} {fastest_rate(count):26.3g}")
    overview(run(simulation, "nesterenko_breakup.nc", overwrite=True)).savefig("nesterenko_breakup.png")
    pulse = run(chain, "nesterenko_chain.nc", overwrite=True)
    print(f"the chain at t = {chain.t_end:g}: height {float(pulse.R[-1].max()):.3f} of {float(pulse.R[0].max()):.3f}")
    overview(pulse).savefig("nesterenko_chain.png")
