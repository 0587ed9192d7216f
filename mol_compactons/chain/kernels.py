"""Contacts of two power laws between two grains, and one stage of a splitting method for a chain of them, compiled.

The law of a contact is (plus, minus, n, linear): F(z) = plus z^n + linear z for z > 0 and minus |z|^n + linear z for z < 0.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mol_compactons.runtime.compiled import compiled
from mol_compactons.runtime.powers import size_power

Array = NDArray[np.float64]
Law = tuple[float, float, float, float]

PERIODIC, FIXED, FREE, HELD = range(4)


@compiled
def power(size: float, exponent: float) -> float:
    """size^exponent for size >= 0."""
    if exponent == 1.5:
        return size * math.sqrt(size)
    if exponent == 2.0:
        return size * size
    if exponent == 3.0:
        return size * size * size
    return size_power(size, exponent)


@compiled
def force(z: float, strength: float, law: Law) -> float:
    """F(z), of which `strength` multiplies the nonlinear part."""
    side = law[0] if z > 0.0 else law[1]
    return strength * side * power(abs(z), law[2]) + law[3] * z


@compiled
def stiffness(z: float, strength: float, law: Law) -> float:
    """F'(z)."""
    side = law[0] if z > 0.0 else -law[1]
    return strength * side * law[2] * power(abs(z), law[2] - 1.0) + law[3]


@compiled
def energy(z: float, strength: float, law: Law) -> float:
    """The antiderivative of F that vanishes at z = 0."""
    side = law[0] if z > 0.0 else -law[1]
    return strength * side * power(abs(z), law[2] + 1.0) / (law[2] + 1.0) + 0.5 * law[3] * z * z


@compiled
def forces(z: Array, strengths: Array, law: Law) -> Array:
    """F of each contact; `strengths` has the length of z, or 1."""
    result = np.empty_like(z)
    for k in range(z.size):
        result[k] = force(z[k], strengths[k % strengths.size], law)
    return result


@compiled
def stiffnesses(z: Array, strengths: Array, law: Law) -> Array:
    """F' of each contact."""
    result = np.empty_like(z)
    for k in range(z.size):
        result[k] = stiffness(z[k], strengths[k % strengths.size], law)
    return result


@compiled
def energies(z: Array, strengths: Array, law: Law) -> Array:
    """The energy stored in each contact."""
    result = np.empty_like(z)
    for k in range(z.size):
        result[k] = energy(z[k], strengths[k % strengths.size], law)
    return result


@compiled
def _move_and_push(stress: Array, rate: Array, drift: float, strength: float, static: float, law: Law, forces: Array) -> None:
    """Add drift times the rate to the stresses of equal contacts and write their forces, from place 1 on.

    The usual exponents have loops of their own. The compiler vectorises all.
    """
    plus, minus, exponent, linear = law
    plus, minus = strength * plus, strength * minus
    if exponent == 1.5:
        for k in range(stress.size):
            stress[k] += drift * rate[k]
            z = stress[k] + static
            size = abs(z)
            forces[k + 1] = (plus if z > 0.0 else minus) * (size * math.sqrt(size)) + linear * z
    elif exponent == 2.0:
        for k in range(stress.size):
            stress[k] += drift * rate[k]
            z = stress[k] + static
            forces[k + 1] = (plus if z > 0.0 else minus) * (z * z) + linear * z
    elif exponent == 3.0:
        for k in range(stress.size):
            stress[k] += drift * rate[k]
            z = stress[k] + static
            size = abs(z)
            forces[k + 1] = (plus if z > 0.0 else minus) * (size * size * size) + linear * z
    else:
        for k in range(stress.size):
            stress[k] += drift * rate[k]
            z = stress[k] + static
            forces[k + 1] = (plus if z > 0.0 else minus) * size_power(abs(z), exponent) + linear * z


@compiled
def stage_of_equal_contacts(
    stress: Array,
    rate: Array,
    drift: float,
    kick: float,
    strength: float,
    static: float,
    inverse_mass: float,
    push: float,
    law: Law,
    ends: int,
    forces: Array,
) -> None:
    """The same as `stage_of_stresses` for equal grains and contacts; `forces` is scratch, shape (N + 2,)."""
    size = stress.size
    _move_and_push(stress, rate, drift, strength, static, law, forces)
    forces[0], forces[size + 1] = push, push
    if ends == PERIODIC:
        forces[0], forces[size + 1] = forces[size], forces[1]
    elif ends == FIXED:
        forces[0], forces[size + 1] = forces[1], forces[size]
    first, last = rate[0], rate[size - 1]
    factor = kick * inverse_mass
    for k in range(size):
        rate[k] += factor * (forces[k] - 2.0 * forces[k + 1] + forces[k + 2])
    if ends == HELD:
        rate[0], rate[size - 1] = first, last


@compiled
def stage_of_stresses(
    stress: Array,
    rate: Array,
    drift: float,
    kick: float,
    strengths: Array,
    static: Array,
    inverse_masses: Array,
    push: float,
    law: Law,
    ends: int,
) -> None:
    """Add drift times the rate to the stresses, and then kick times their acceleration to the rates, in one pass.

    Contact k lies between the grains of the inverse masses k and k + 1. Arrays of length 1 stand for equal values.
    """
    size = stress.size
    varied, moved, uneven = min(strengths.size - 1, 1), min(static.size - 1, 1), min(inverse_masses.size - 1, 1)
    stress[0] += drift * rate[0]
    last = size - 1
    stress[last] += drift * rate[last]
    first_force = force(stress[0] + static[0], strengths[0], law)
    last_force = force(stress[last] + static[last * moved], strengths[last * varied], law)
    before = last_force if ends == PERIODIC else push
    here = first_force
    for k in range(size):
        if k + 1 < last:
            j = k + 1
            stress[j] += drift * rate[j]
            after = force(stress[j] + static[j * moved], strengths[j * varied], law)
        elif k + 1 == last:
            after = last_force
        else:
            after = first_force if ends == PERIODIC else push
        left, right = inverse_masses[k * uneven], inverse_masses[(k + 1) * uneven]
        if ends == FIXED:
            left = 0.0 if k == 0 else left
            right = 0.0 if k == last else right
        if ends != HELD or 0 < k < last:
            rate[k] += kick * (left * (before - here) - right * (here - after))
        before, here = here, after


@compiled
def stage_of_displacements(
    displacement: Array,
    momentum: Array,
    drift: float,
    kick: float,
    strengths: Array,
    static: Array,
    inverse_masses: Array,
    push: float,
    law: Law,
    ends: int,
) -> None:
    """Add drift times the velocity to the displacements, and then kick times the force to the momenta, in one pass.

    Contact k lies left of grain k; contact N is contact 0 on a ring and the right wall between fixed ends.
    """
    size = displacement.size
    varied, moved, uneven = min(strengths.size - 1, 1), min(static.size - 1, 1), min(inverse_masses.size - 1, 1)
    last = size - 1
    displacement[0] += drift * momentum[0] * inverse_masses[0]
    displacement[last] += drift * momentum[last] * inverse_masses[last * uneven]
    left = right_end = push
    if ends == PERIODIC:
        left = force(displacement[last] - displacement[0] + static[0], strengths[0], law)
        right_end = left
    elif ends == FIXED:
        left = force(-displacement[0] + static[0], strengths[0], law)
        right_end = force(displacement[last] + static[size * moved], strengths[size * varied], law)
    for k in range(size):
        j = k + 1
        if j < last:
            displacement[j] += drift * momentum[j] * inverse_masses[j * uneven]
        if j < size:
            right = force(displacement[k] - displacement[j] + static[j * moved], strengths[j * varied], law)
        else:
            right = right_end
        momentum[k] += kick * (left - right)
        left = right


@compiled
def split_steps(
    state: Array,
    step: float,
    count: int,
    drifts: Array,
    kicks: Array,
    strengths: Array,
    static: Array,
    inverse_masses: Array,
    push: float,
    law: Law,
    ends: int,
    in_stresses: bool,
) -> None:
    """`count` steps of a splitting method that begins and ends with a kick; kicks between two steps are done at once."""
    equal = in_stresses and strengths.size == static.size == inverse_masses.size == 1
    forces = np.empty(state.shape[1] + 2 if equal else 0)
    for index in range(count):
        for stage in range(kicks.size):
            if stage == 0 and index > 0:
                continue
            drift = step * drifts[stage - 1] if stage else 0.0
            kick = step * kicks[stage]
            if stage == kicks.size - 1 and index + 1 < count:
                kick += step * kicks[0]
            if equal:
                stage_of_equal_contacts(
                    state[0], state[1], drift, kick, strengths[0], static[0], inverse_masses[0], push, law, ends, forces
                )
            elif in_stresses:
                stage_of_stresses(state[0], state[1], drift, kick, strengths, static, inverse_masses, push, law, ends)
            else:
                stage_of_displacements(state[0], state[1], drift, kick, strengths, static, inverse_masses, push, law, ends)
