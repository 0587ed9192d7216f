from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    GranularChain,
    GranularCompacton,
    Grid,
    Impact,
    InputError,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Samples,
    run,
)
from tests.chain.chains import ring

FREE = GranularChain(PowerContact(1.5, kind="one_sided"), form="displacements", ends="free")


@given(st.floats(-3, 3), st.integers(0, 8), st.integers(1, 4))
def test_exactly_the_grains_that_are_said_move(velocity: float, first: int, grains: int) -> None:
    masses = tuple(np.linspace(0.5, 2, 12))
    chain = GranularChain(PowerContact(2), form="displacements", ends="free", masses=masses)
    displacement, momentum = Impact(velocity, first, grains).values(chain, Lattice(12))
    assert not displacement.any()
    moving = np.zeros(12)
    moving[first : first + grains] = velocity
    assert momentum / masses == pytest.approx(moving, rel=1e-14)


def test_the_momentum_of_the_blow_stays_in_a_free_chain() -> None:
    dataset = run(ring(equation=FREE, grid=Lattice(20), initial=[Impact(velocity=1.5, grains=2)], t_end=10))
    assert dataset.p.values[0].tolist() == [1.5, 1.5] + [0.0] * 18
    assert np.abs(dataset.p.values[-1][:2]).max() < 0.5
    assert dataset.momentum.values == pytest.approx([3.0] * 3, rel=1e-12)
    assert float(dataset.energy[0]) == pytest.approx(2.25)


def test_a_blow_on_a_chain_of_parted_grains_carries_the_momentum_away() -> None:
    """Exactly elastic: of two equal grains the first stops and the second takes its velocity."""
    two = GranularChain(PowerContact(1.5, kind="one_sided"), form="displacements", ends="free", masses=(1, 1, 1))
    gap = Samples((0.0, 1.0, 50.0, 1.0, 0.0, 0.0))
    final = run(ring(equation=two, grid=Lattice(3), initial=[gap], t_end=20)).p.values[-1]
    assert final == pytest.approx([0, 1, 0], abs=1e-5)


@pytest.mark.parametrize(
    ("attempt", "words"),
    [
        (lambda: ring(initial=[Impact(1)]), "Impact moves the grains of a GranularChain in displacements"),
        (lambda: Impact(1).values(GranularCompacton(2), Grid(10, 20)), "Impact moves the grains of a GranularChain"),
        (lambda: ring(equation=FREE, initial=[Impact(1, 59, 2)]), "up to number 60, but the chain has 60"),
        (lambda: Impact(1, -1), "must not be negative"),
        (lambda: Impact(1, 0, 0), "must be at least 1"),
    ],
)
def test_bad_input_is_named(attempt: Callable[[], Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        attempt()


def test_by_default_the_first_grain_alone_is_struck() -> None:
    """With its own mass: m v and m v^2 / 2, the first of unequal ones."""
    masses = (3.0, 0.5, *(1.0,) * 8)
    chain = GranularChain(PowerContact(2), form="displacements", ends="free", masses=masses)
    state = Impact(-2.0).values(chain, Lattice(10))
    assert state.tolist() == [[0.0] * 10, [-6.0] + [0.0] * 9]
    found = NearestNeighbours().discretize(chain, Lattice(10)).invariants(state)
    assert found == pytest.approx({"momentum": -6.0, "energy": 6.0})
