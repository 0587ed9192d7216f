"""The collision of the paper's Fig. 4: two compactons in the chain, beside the continuum, at t = 0, 3, 21.5 and 31.

The paper names no parameters; these are the Hertz contact, n = 3/2, 80 sites, and the speeds c = 1 and 1/4 of its Fig. 1. The
ends and the rates of the stress are the paper's.

The slow wave shows where the comparison ends: in the chain it moves at V = sqrt(c) = 1/2, in the continuum at c = 1/4, so
that the fast one, the same in both, catches it up later in the chain. docs/lattice.md discusses the numbers.
"""

from mol_compactons import ChainCompacton, GranularChain, Lattice, NearestNeighbours, PowerContact, Simulation, Symplectic, run

simulation = Simulation(
    title="Two compactons in a chain (Fig. 4)",
    equation=GranularChain(PowerContact(n=3 / 2), ends="held"),
    grid=Lattice(size=80),
    scheme=NearestNeighbours(),
    initial=[ChainCompacton(speed=1, center=10), ChainCompacton(speed=1 / 2, center=16)],  # V = sqrt(c)
    t_end=31,
    frames=311,
    integrator=Symplectic(step=0.02),
)

if __name__ == "__main__":
    from mol_compactons.analysis.chain_and_continuum import compare, continuum_of
    from mol_compactons.analysis.collisions import first_collision
    from mol_compactons.analysis.tracking import track
    from mol_compactons.figures import side_by_side

    discrete = run(simulation, "lattice_collision.nc", overwrite=True)
    smooth = run(continuum_of(simulation), "lattice_collision_continuum.nc", overwrite=True)
    comparison = compare(discrete, smooth)
    side_by_side(comparison, smooth, (0, 3, 21.5, 31)).savefig("lattice_collision.png")
    for t in (0, 3, 21.5, 31):
        now = comparison.sel(t=t, method="nearest")
        print(f"t = {t:g}: relative L2 distance {float(now.distance):.3f}")
        print(f"  positions: chain {now.position.values.round(2)}, continuum {now.continuum_position.values.round(2)}")
    for label, dataset in (("chain", discrete), ("continuum, in its own units", smooth)):
        collision = first_collision(track(dataset, newborn=False))
        shift, moment = collision.phase_shift.values.round(2), float(collision.moment[0])
        print(f"{label}: the waves meet at {moment:.2f}, phase shifts {shift}")
