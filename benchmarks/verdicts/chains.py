"""Exact solitary waves of chains, where sites cannot be refined and the ladder is that of the steps or tolerances."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from benchmarks.verdicts.known import Known, free_waves
from mol_compactons import (
    CVODE,
    Family,
    GranularChain,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Simulation,
    SolitaryWave,
    Symplectic,
)


def chain_hertz() -> Known:
    """The wave of the Hertz chain, five grains wide, that passes sites at a whole and at a broken distance."""
    return _chain(PowerContact(1.5), t_end=10.37)


def chain_cubic() -> Known:
    """The wave of n = 3, hardly wider than a grain."""
    return _chain(PowerContact(3), t_end=10.37)


def chain_prestressed() -> Known:
    """The wave of a chain with a linear term, 5 % faster than sound, wide and low."""
    return _chain(PowerContact(3, linear=1), speed=1.05, size=120)


def chain_left() -> Known:
    """A wave of n = 2 that moves to the left and comes round the ring twice."""
    return _chain(PowerContact(2), speed=-1.0, t_end=60.2)


def chain_tolerances() -> Known:
    """The Hertz wave by CVODE at the loose tolerances 1e-3 and 1e-4."""
    return _chain(PowerContact(1.5), Family(tolerances=(1e-3, 1e-4)), integrator=CVODE(rtol=1e-4))


def chain_large_steps() -> Known:
    """The Hertz wave by two steps that are hardly stable, of which the shorter is two thirds of the longer."""
    return _chain(PowerContact(1.5), Family(tolerances=(1 / 2, 1 / 3)), frames=11, integrator=Symplectic(step=0.5, order=2))


def _chain(
    law: PowerContact, family: Family | None = None, *, speed: float = 1.0, size: int = 30, t_end: float = 10, **settings: Any
) -> Known:
    """Mass and momentum left are not compared: tails that reach beyond what counts as the wave are no error."""
    family = family or Family()
    chosen: dict[str, Any] = {"frames": 61, "integrator": Symplectic(step=0.1)} | settings
    simulation = Simulation(
        GranularChain(law),
        Lattice(size),
        [SolitaryWave(speed, center=size / 3 + 0.3)],
        t_end,
        scheme=NearestNeighbours(),
        **chosen,
    )
    truths = {quantity: truth for quantity, truth in free_waves(simulation, family).items() if not quantity.endswith("left")}
    return Known(simulation, family, truths)


FAMILIES: tuple[Callable[[], Known], ...] = (
    chain_hertz, chain_cubic, chain_prestressed, chain_left, chain_tolerances, chain_large_steps,
)  # fmt: skip
