from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import GranularChain, Symplectic
from mol_compactons.chain import kernels
from tests.chain.chains import SIZE, a_state, chains, system_of
from tests.systems import Array, random_state

LAWS = st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.sampled_from([1.5, 2.0, 2.7, 3.0]), st.floats(0, 1))
ENDS = st.sampled_from([kernels.PERIODIC, kernels.FIXED, kernels.FREE, kernels.HELD])


@given(st.floats(0, 50), st.sampled_from([0.5, 1.0, 1.5, 2.0, 2.7, 3.0, 4.0]))
def test_a_power_is_that_power(size: float, exponent: float) -> None:
    assert kernels.power(size, exponent) == pytest.approx(size**exponent, rel=1e-14)


def pull(z: Array, strengths: Array, law: Any) -> Array:
    """The law in numpy."""
    plus, minus, n, linear = law
    return np.asarray(strengths * np.where(z > 0, plus, minus) * np.abs(z) ** n + linear * z)


@given(LAWS, st.integers(0, 1000))
def test_forces_of_many_contacts_are_those_of_each(law: Any, seed: int) -> None:
    z, strengths = random_state(seed, 2, SIZE)
    assert kernels.forces(z, strengths, law) == pytest.approx(pull(z, strengths, law), rel=1e-12, abs=1e-14)
    assert kernels.forces(z, np.array([0.7]), law) == pytest.approx(pull(z, np.full(SIZE, 0.7), law), rel=1e-12, abs=1e-14)
    for many, one in ((kernels.stiffnesses, kernels.stiffness), (kernels.energies, kernels.energy)):
        assert many(z, strengths, law).tolist() == [one(z[k], strengths[k], law) for k in range(SIZE)]


def accelerations(stress: Array, strengths: Array, static: Array, inverse: Array, push: float, law: Any, ends: int) -> Array:
    """The rates of the rates of stresses, contact by contact, as the equation of motion says."""
    force = pull(stress + static, strengths, law)
    around = np.concatenate([[push], force, [push]])
    if ends == kernels.PERIODIC:
        around[0], around[-1] = force[-1], force[0]
    inverse = inverse.copy()
    if ends == kernels.FIXED:
        inverse[0] = inverse[-1] = 0.0
    result = inverse[:-1] * (around[:-2] - force) - inverse[1:] * (force - around[2:])
    if ends == kernels.HELD:
        result[[0, -1]] = 0.0
    return np.asarray(result)


@given(LAWS, ENDS, st.integers(0, 1000), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_a_stage_of_stresses_drifts_and_then_kicks(law: Any, ends: int, seed: int, drift: float, kick: float) -> None:
    random = np.random.default_rng(seed)
    stress, rate = random.normal(size=(2, SIZE))
    strengths, static = random.uniform(0.5, 2, size=(2, SIZE))
    inverse, push = random.uniform(0.5, 2, SIZE + 1), 0.3
    moved = stress + drift * rate
    pushed = rate + kick * accelerations(moved, strengths, static, inverse, push, law, ends)
    kernels.stage_of_stresses(stress, rate, drift, kick, strengths, static, inverse, push, law, ends)
    assert np.allclose(stress, moved, atol=1e-14)
    assert np.allclose(rate, pushed, rtol=1e-11, atol=1e-11)


@given(LAWS, ENDS, st.integers(0, 1000), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_the_stage_of_equal_contacts_is_the_same(law: Any, ends: int, seed: int, drift: float, kick: float) -> None:
    stress, rate = random_state(seed, 2, SIZE)
    moved = stress + drift * rate
    ones = np.ones(SIZE)
    expected = accelerations(moved, 0.7 * ones, 0.2 * ones, 1.3 * np.ones(SIZE + 1), 0.3, law, ends)
    pushed = rate + kick * expected
    kernels.stage_of_equal_contacts(stress, rate, drift, kick, 0.7, 0.2, 1.3, 0.3, law, ends, np.empty(SIZE + 2))
    assert np.allclose(stress, moved, atol=1e-14)
    assert np.allclose(rate, pushed, rtol=1e-11, atol=1e-11)


@given(LAWS, st.sampled_from([kernels.PERIODIC, kernels.FIXED, kernels.FREE]), st.integers(0, 1000))
def test_a_stage_of_displacements_drifts_and_then_kicks(law: Any, ends: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    place, momentum = random.normal(size=(2, SIZE))
    strengths, static = random.uniform(0.5, 2, size=(2, SIZE + 1))
    if ends == kernels.PERIODIC:
        strengths[-1], static[-1] = strengths[0], static[0]
    inverse, push, drift, kick = random.uniform(0.5, 2, SIZE), 0.3, 0.2, -0.4
    moved = place + drift * momentum * inverse
    nearer = np.concatenate([[-moved[0]], -np.diff(moved), [moved[-1]]])
    if ends == kernels.PERIODIC:
        nearer[0] = nearer[-1] = moved[-1] - moved[0]
    force = pull(nearer + static, strengths, law)
    if ends == kernels.FREE:
        force[0] = force[-1] = push
    pushed = momentum + kick * (force[:-1] - force[1:])
    kernels.stage_of_displacements(place, momentum, drift, kick, strengths, static, inverse, push, law, ends)
    assert np.allclose(place, moved, atol=1e-14)
    assert np.allclose(momentum, pushed, rtol=1e-11, atol=1e-11)


@given(chains(), st.integers(0, 1000))
def test_equal_and_varying_chains_are_stepped_alike(chain: GranularChain, seed: int) -> None:
    """The loops for equal grains against those for any, to which the same masses and strengths are given one by one."""
    chain = replace(chain, masses=(), strengths=())
    varying = replace(chain, masses=(1.0,) * chain.grain_count(SIZE), strengths=(1.0,) * chain.contact_count(SIZE))
    state = a_state(chain, seed)
    one, other = (Symplectic(0.05).start(system_of(each), 0.1 * state, 0.5).advance(0.5) for each in (chain, varying))
    assert np.allclose(one, other, rtol=1e-11, atol=1e-12)


@given(chains(), st.integers(0, 1000), st.integers(1, 6))
def test_kicks_between_two_steps_are_joined_without_a_trace(chain: GranularChain, seed: int, count: int) -> None:
    system, kicks, drifts = system_of(chain), np.array([0.2, 0.6, 0.2]), np.array([0.5, 0.5])
    together, apart = (0.1 * a_state(chain, seed) for _ in range(2))
    assert system.split_steps is not None
    system.split_steps(together, 0.05, count, drifts, kicks)
    for _ in range(count):
        system.split_steps(apart, 0.05, 1, drifts, kicks)
    assert np.allclose(together, apart, rtol=1e-11, atol=1e-13)


@given(LAWS, st.floats(-3, 3), st.floats(0.3, 2))
def test_stiffness_and_energy_of_a_contact_are_those_of_its_force(law: Any, z: float, strength: float) -> None:
    """The slope of F, and the integral of F from 0 to z, both in closed form."""
    plus, minus, n, linear = law
    side, size = strength * (plus if z > 0 else minus), abs(z)
    assert kernels.force(z, strength, law) == pytest.approx(side * size**n + linear * z, rel=1e-12, abs=1e-14)
    slope = (side if z > 0 else -side) * n * size ** (n - 1) + linear
    assert kernels.stiffness(z, strength, law) == pytest.approx(slope, rel=1e-12, abs=1e-14)
    stored = (side if z > 0 else -side) * size ** (n + 1) / (n + 1) + linear * z * z / 2
    assert kernels.energy(z, strength, law) == pytest.approx(stored, rel=1e-12, abs=1e-14)
