"""Chains of every kind, and a short ring with a wave on it, for the tests of the chain and its integrators."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import strategies as st

from mol_compactons import GranularChain, Lattice, NearestNeighbours, PowerContact, Simulation, SolitaryWave, Symplectic
from mol_compactons.semidiscrete import SemiDiscretization
from tests.systems import Array, random_state

SIZE = 12


@st.composite
def chains(draw: st.DrawFn) -> GranularChain:
    """Chains of every law, end and form, equal or not, compressed or not."""
    law: Any = draw(st.sampled_from(["odd", "one_sided", "power", "rarefaction"]))
    form: Any = draw(st.sampled_from(["stresses", "displacements"]))
    ends: Any = draw(st.sampled_from(["periodic", "fixed", "free"] + (["held"] if form == "stresses" else [])))
    n = draw(st.sampled_from({"power": [2, 3], "rarefaction": [2, 4]}.get(law, [1.5, 2, 2.7, 3])))
    linear = draw(st.sampled_from([0.0, 0.4])) if law != "one_sided" else 0.0
    compression = draw(st.sampled_from([0.0, 0.7])) if law != "rarefaction" else 0.0
    chain = GranularChain(
        PowerContact(n, strength=1.3, linear=linear, kind=law), ends=ends, form=form, compression=compression
    )
    if draw(st.booleans()):
        seed = np.random.default_rng(draw(st.integers(0, 100)))
        masses = tuple(seed.uniform(0.5, 2, chain.grain_count(SIZE)))
        strengths = tuple(seed.uniform(0.5, 2, chain.contact_count(SIZE)))
        chain = replace(chain, masses=masses, strengths=strengths)
    return chain


def system_of(chain: GranularChain, size: int = SIZE) -> SemiDiscretization:
    return NearestNeighbours().discretize(chain, Lattice(size))


def a_state(chain: GranularChain, seed: int) -> Array:
    """A random state that fits the ends."""
    state = random_state(seed, 2, SIZE)
    if chain.form == "stresses" and chain.ends in ("periodic", "fixed"):
        state[1] -= state[1].mean()
        if chain.ends == "fixed":
            state[0] -= state[0].mean()
    return state


def ring(n: float = 3, **fields: Any) -> Simulation:
    defaults: dict[str, Any] = {
        "equation": GranularChain(PowerContact(n)),
        "grid": Lattice(size=60),
        "scheme": NearestNeighbours(),
        "initial": [SolitaryWave(speed=1, center=20)],
        "t_end": 10,
        "frames": 3,
        "integrator": Symplectic(step=0.05),
    }
    return Simulation(**defaults | fields)
