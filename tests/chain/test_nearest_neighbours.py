from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mol_compactons import (
    ChainCompacton,
    ContactLaw,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Simulation,
    Symplectic,
    drift,
    run,
)
from mol_compactons.semidiscrete import SemiDiscretization
from tests.chain.chains import SIZE, a_state, chains, system_of
from tests.systems import Array, analytic_jacobian, difference_jacobian, random_state, right_hand_side


@given(chains(), st.integers(0, 1000))
def test_what_is_conserved_does_not_change(chain: GranularChain, seed: int) -> None:
    system, state = system_of(chain), a_state(chain, seed)
    rate, step = right_hand_side(system, state), 1e-6
    ahead, behind = system.invariants(state + step * rate), system.invariants(state - step * rate)
    for name in ahead:
        assert abs(ahead[name] - behind[name]) / (2 * step) < 1e-5 * (1 + abs(ahead["energy"])), name


@given(chains(), st.integers(0, 1000))
def test_jacobian_is_the_derivative(chain: GranularChain, seed: int) -> None:
    system, state = system_of(chain), a_state(chain, seed)
    static = chain.static_stress(SIZE)
    stress = state[0] if chain.form == "stresses" else np.diff(state[0])
    assume(np.abs(np.abs(stress) - static.min()).min() > 1e-3)
    assume(np.abs(stress).min() > 1e-3)
    assert np.allclose(analytic_jacobian(system, state), difference_jacobian(system, state, 1e-7), atol=1e-4)


@given(chains(), st.integers(0, 1000))
def test_stresses_and_displacements_are_the_same_chain(chain: GranularChain, seed: int) -> None:
    """R_k = Q_(k-1) - Q_k holds for the accelerations too; free ends, which have a grain more than contacts."""
    in_stresses = replace(chain, form="stresses", ends="free", masses=(), strengths=())
    if chain.masses:
        in_stresses = replace(in_stresses, masses=(*chain.masses, 1.5, 2.5)[: SIZE + 1])
    assume(len(in_stresses.masses) in (0, SIZE + 1))
    in_displacements = replace(in_stresses, form="displacements")
    grains = random_state(seed, 2, SIZE + 1)
    inverse = 1 / np.array(in_stresses.masses) if in_stresses.masses else np.ones(SIZE + 1)
    stresses = np.array([-np.diff(grains[0]), -np.diff(grains[1] * inverse)])
    by_stress = right_hand_side(system_of(in_stresses), stresses)[1]
    by_grain = right_hand_side(system_of(in_displacements, SIZE + 1), grains)[1]
    assert np.allclose(by_stress, -np.diff(by_grain * inverse), atol=1e-12)


@given(st.sampled_from(["periodic", "free", "held"]), st.sampled_from([1.5, 3]), st.integers(0, 100))
def test_mirror_and_scaling(ends: Any, n: float, seed: int) -> None:
    """R_k -> R_(-k) and R -> r R, t -> r^((1-n)/2) t."""
    chain = GranularChain(PowerContact(n), ends=ends)
    system, state = system_of(chain), a_state(chain, seed)
    rate = right_hand_side(system, state)
    assert np.allclose(right_hand_side(system, state[:, ::-1]), rate[:, ::-1], atol=1e-13)
    slow = 4.0 ** ((n - 1) / 2)
    scaled = right_hand_side(system, np.array([4 * state[0], 4 * slow * state[1]]))
    assert np.allclose(scaled, [4 * slow * rate[0], 4 * slow**2 * rate[1]], rtol=1e-12, atol=1e-12)


def energy_of(system: SemiDiscretization, state: Array) -> float:
    """The energy, which between held ends is no conserved quantity."""
    return (system.invariants(state) | system.diagnostics(state))["energy"]


@dataclass(frozen=True)
class Uncompiled(ContactLaw):
    """A power law that hides its coefficients, so that the loops for any law are taken."""

    own: PowerContact

    def force(self, z: Array, factor: Array) -> Array:
        return self.own.force(z, factor)

    def stiffness(self, z: Array, factor: Array) -> Array:
        return self.own.stiffness(z, factor)

    def energy(self, z: Array, factor: Array) -> Array:
        return self.own.energy(z, factor)

    def static_compression(self, push: float, factor: Array) -> Array:
        return self.own.static_compression(push, factor)


@given(chains(), st.integers(0, 1000))
def test_any_law_moves_the_chain_as_the_compiled_one_does(chain: GranularChain, seed: int) -> None:
    law = chain.law
    assert isinstance(law, PowerContact)
    other, state = replace(chain, law=Uncompiled(law)), a_state(chain, seed)
    compiled, general = system_of(chain), system_of(other)
    rate = right_hand_side(compiled, state)
    assert np.allclose(right_hand_side(general, state), rate, rtol=1e-12, atol=1e-12 * np.abs(rate).max())
    assert np.allclose(analytic_jacobian(general, state), analytic_jacobian(compiled, state), rtol=1e-12, atol=1e-12)
    assert general.invariants(state) == pytest.approx(compiled.invariants(state), rel=1e-12)


@given(chains(), st.integers(0, 1000))
def test_any_law_is_split_as_the_compiled_one_is(chain: GranularChain, seed: int) -> None:
    law = chain.law
    assert isinstance(law, PowerContact)
    states = [0.1 * a_state(chain, seed) for _ in range(2)]
    before = states[0].copy()
    kicks, drifts = np.array([0.2, 0.6, 0.2]), np.array([0.5, 0.5])
    for system, state in zip((system_of(chain), system_of(replace(chain, law=Uncompiled(law)))), states, strict=True):
        assert system.split_steps is not None
        system.split_steps(state, 0.05, 7, drifts, kicks)
    assert np.abs(states[0] - before).max() > 1e-4
    assert np.allclose(states[0], states[1], rtol=1e-11, atol=1e-12)


@given(chains(), st.integers(0, 1000))
def test_the_energy_is_that_of_the_grains_and_the_contacts(chain: GranularChain, seed: int) -> None:
    """At rest without compression it is the sum of the energies of the contacts; in displacements the rest is p^2 / 2m."""
    assume(chain.compression == 0)
    state = a_state(chain, seed)
    state[1] = 0
    factors = np.array(chain.strengths) if chain.strengths else np.ones(chain.contact_count(SIZE))
    stress = state[0] if chain.form == "stresses" else -np.diff(state[0])
    if chain.form == "displacements" and chain.ends == "periodic":
        stress = np.append(state[0][-1] - state[0][0], stress)
    elif chain.form == "displacements" and chain.ends == "fixed":
        stress = np.concatenate([[-state[0][0]], stress, [state[0][-1]]])
    stored = float(chain.law.energy(stress, factors).sum())
    assert energy_of(system_of(chain), state) == pytest.approx(stored, rel=1e-12, abs=1e-12)
    if chain.form == "displacements":
        masses = np.array(chain.masses) if chain.masses else np.ones(SIZE)
        state[1] = random_state(seed + 1, 1, SIZE)[0]
        moving = stored + float((state[1] ** 2 / (2 * masses)).sum())
        assert energy_of(system_of(chain), state) == pytest.approx(moving, rel=1e-12)


def test_only_chains_are_taken() -> None:
    with pytest.raises(InputError, match="is for a GranularChain on a Lattice, not for GranularCompacton"):
        NearestNeighbours().discretize(GranularCompacton(2), Grid(10, 20))
    with pytest.raises(InputError, match="is for a GranularChain on a Lattice, not for GranularChain on a Grid"):
        NearestNeighbours().discretize(GranularChain(PowerContact(2)), Grid(10, 20))
    assert NearestNeighbours().suits(GranularChain(PowerContact(2))) == 1
    assert NearestNeighbours().suits(GranularCompacton(2)) == 0


@given(chains(), st.integers(0, 1000))
def test_kinetic_energies_of_rates_are_those_of_the_grains(chain: GranularChain, seed: int) -> None:
    """Of the velocities that make the rates: with walls and held ends at rest, on a ring and between free ends with the
    momentum 0. The rest of the energy does not depend on the rates."""
    chain = replace(chain, form="stresses")
    if chain.masses:
        random = np.random.default_rng(seed)
        masses = tuple(random.uniform(0.5, 2, chain.grain_count(SIZE)))
        chain = replace(chain, masses=masses, strengths=tuple(random.uniform(0.5, 2, SIZE)))
    state, count = a_state(chain, seed), chain.grain_count(SIZE)
    own = np.array(chain.masses) if chain.masses else np.ones(count)
    velocities = -np.cumsum(state[1])
    if chain.ends in ("free", "held"):
        velocities = np.append(0.0, velocities)
    elif chain.ends == "fixed":
        velocities = velocities[:-1]
    if chain.ends in ("periodic", "free"):
        velocities = velocities - own @ velocities / own.sum()
        assert abs(own @ velocities) < 1e-10
    differences = -np.diff(velocities)
    first = 0 if chain.ends in ("free", "held") else 1
    assert differences == pytest.approx(state[1][first:][: differences.size], abs=1e-10)
    rest = np.array([state[0], 0 * state[1]])
    system = system_of(chain)
    moving = energy_of(system, state) - energy_of(system, rest)
    assert moving == pytest.approx(float(own @ velocities**2) / 2, rel=1e-9)


@given(chains(), st.integers(0, 1000))
def test_the_energy_counts_from_the_static_state(chain: GranularChain, seed: int) -> None:
    """There it is zero and stationary: of states that are smaller by a factor it is smaller by its square."""
    assume(chain.compression > 0)
    system, state = system_of(chain), a_state(chain, seed)
    state[1] = 0
    assert energy_of(system, 0 * state) == 0
    small, smaller = (energy_of(system, size * state) for size in (2e-4, 1e-4))
    assert small == pytest.approx(4 * smaller, rel=1e-2)
    assert small > 0


@given(chains(), st.integers(0, 1000))
def test_sums_of_sizes_are_of_the_size_of_what_they_are_the_sizes_of(chain: GranularChain, seed: int) -> None:
    system, state = system_of(chain), a_state(chain, seed)
    assert system.magnitudes is not None
    sums, sizes = system.invariants(state), system.magnitudes(state)
    assert set(sums) == set(sizes)
    for name, value in sums.items():
        assert sizes[name] >= abs(value) * (1 - 1e-12)
    if "momentum" in sums:
        assert sizes["momentum"] == pytest.approx(np.abs(state[1]).sum())
    if "mass" in sums:
        assert [sums["mass"], sizes["mass"]] == pytest.approx([state[0].sum(), np.abs(state[0]).sum()])


def test_held_ends_do_work_so_that_the_energy_is_not_called_conserved() -> None:
    """A wave that is shed reaches the held end and takes energy out or in; between other ends it is kept."""
    waves = [ChainCompacton(speed=1, center=10), ChainCompacton(speed=1 / 2, center=16)]
    chain = GranularChain(PowerContact(n=1.5), ends="held")
    simulation = Simulation(chain, Lattice(80), waves, t_end=24, frames=25, integrator=Symplectic(step=0.05))
    held, free = (run(replace(simulation, equation=replace(chain, ends=ends))) for ends in ("held", "free"))
    assert "energy" not in drift(held)
    assert float(abs(held.energy / held.energy[0] - 1).max()) > 1e-2
    assert float(abs(drift(free).energy).max()) < 1e-7
