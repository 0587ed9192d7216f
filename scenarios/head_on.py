"""Two equal exact solitary waves of the Hertz chain meet head on: a phase shift, and secondary waves are born.

They are no solitons. By symmetry both fare alike: each comes out about 0.36 sites ahead of its free flight. The secondary
waves depend on whether they meet at a contact or at a grain; the energy of a wave of the height r goes as r^(n+1).
"""

from dataclasses import replace

import numpy as np

from mol_compactons import GranularChain, Lattice, NearestNeighbours, PowerContact, Simulation, SolitaryWave, Symplectic, run

simulation = Simulation(
    title="Two solitary waves of a chain meet head on",
    equation=GranularChain(PowerContact(n=3 / 2, kind="one_sided")),
    grid=Lattice(size=240),
    scheme=NearestNeighbours(),
    initial=[SolitaryWave(speed=1, center=60), SolitaryWave(speed=-1, center=180)],
    t_end=150,
    frames=601,
    integrator=Symplectic(step=0.02),
)

if __name__ == "__main__":
    from mol_compactons.analysis.collisions import first_collision
    from mol_compactons.analysis.peaks import peaks
    from mol_compactons.analysis.tracking import track
    from mol_compactons.figures import overview

    for center, place in ((60.5, "a grain"), (60, "a contact")):
        waves = [SolitaryWave(speed=1, center=center), SolitaryWave(speed=-1, center=center + 120)]
        dataset = run(replace(simulation, initial=waves), "head_on.nc", overwrite=True)
        collision = first_collision(track(dataset))
        print(f"they meet at {place}: phase shifts {collision.phase_shift.values.round(3)}")
        heights = np.sort(peaks(dataset.R.values[-1], simulation.grid, 1, 0.01)[1])[::-1]
        share = (heights[2] / heights[0]) ** (5 / 2)
        print(f"  largest secondary wave: {heights[2]:.3f} high, against {heights[0]:.3f}; {share:.1e} of the energy")
    overview(dataset).savefig("head_on.png")
