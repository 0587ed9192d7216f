"""Small simulations to make families of."""

from __future__ import annotations

from mol_compactons import (
    CVODE,
    Compacton,
    ConservativeScheme,
    GranularChain,
    GranularCompacton,
    Grid,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Simulation,
)


def single(n: float = 2, size: int = 240) -> Simulation:
    return Simulation(
        equation=GranularCompacton(n),
        grid=Grid(length=30, size=size),
        scheme=ConservativeScheme(order=4),
        initial=[Compacton(speed=1, center=10)],
        t_end=3,
        frames=31,
        integrator=CVODE(rtol=1e-5),
    )


def chain() -> Simulation:
    return Simulation(
        equation=GranularChain(PowerContact(n=2)),
        grid=Lattice(20),
        scheme=NearestNeighbours(),
        initial=[Compacton(1, 8)],
        t_end=1,
        frames=3,
    )
