"""A blow on a Hertz chain breaks up into solitary waves, ever slower and lower: the classic experiment.

Five grains at the left end of a chain of 200 are struck with a velocity of 1; grains can part. The train that comes out is
compared with the exact solitary wave of the chain: from the height of each wave follows its speed, V^2 = A r^(n-1).
"""

import numpy as np

from mol_compactons import GranularChain, Impact, Lattice, NearestNeighbours, PowerContact, Simulation, Symplectic, run
from mol_compactons.chain.solitary_wave import solitary_profile

contact = PowerContact(n=3 / 2, kind="one_sided")
equation = GranularChain(contact, form="displacements", ends="free")

simulation = Simulation(
    title="A blow on a chain",
    equation=equation,
    grid=Lattice(size=200),
    scheme=NearestNeighbours(),
    initial=[Impact(velocity=1, grains=5)],
    t_end=180,
    frames=721,
    integrator=Symplectic(step=0.02),
)


def passing(stress: np.ndarray, times: np.ndarray, site: int, count: int) -> list[tuple[float, float]]:
    """When the first waves pass a contact, and how high: the maxima of its stress along t, by a parabola through three."""
    from scipy.signal import find_peaks

    series = stress[:, site]
    waves = []
    for index in find_peaks(series, height=0.02)[0][:count]:
        before, top, after = series[index - 1 : index + 2]
        offset = 0.5 * (before - after) / (before - 2 * top + after)
        waves.append((times[index] + offset * (times[1] - times[0]), top - 0.25 * (before - after) * offset))
    return waves


if __name__ == "__main__":
    from mol_compactons.figures import overview

    dataset = run(simulation, "hertz_chain.nc", overwrite=True)
    overview(dataset).savefig("hertz_chain.png")
    stress = -np.diff(dataset.Q.values, axis=1)
    unit = solitary_profile(equation, speed=1).amplitude
    near, far = 80, 120
    print("height   speed measured   speed of the exact wave of this height")
    trains = [passing(stress, dataset.t.values, site, 4) for site in (near, far)]
    for (first, _), (second, height) in zip(*trains, strict=True):
        print(f"{height:6.4f} {(far - near) / (second - first):16.4f} {(height / unit) ** ((contact.n - 1) / 2):28.4f}")
