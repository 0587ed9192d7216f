"""The chain as a system of ordinary differential equations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mol_compactons.chain import kernels
from mol_compactons.chain.chain import ENDS, GranularChain
from mol_compactons.chain.law import Array
from mol_compactons.equations.base import Equation
from mol_compactons.errors import InputError
from mol_compactons.grid import Grid, Lattice
from mol_compactons.runtime.workspace import Workspace
from mol_compactons.schemes.base import Scheme
from mol_compactons.semidiscrete import SemiDiscretization


@dataclass(frozen=True)
class NearestNeighbours(Scheme):
    """The differences that belong to a chain: exact, not an approximation.

    Raises
    ------
    InputError
        For anything but a GranularChain on a Lattice.
    """

    def discretize(self, equation: Equation, grid: Grid | Lattice) -> SemiDiscretization:
        """The chain as a system of ordinary differential equations."""
        if not (isinstance(equation, GranularChain) and isinstance(grid, Lattice)):
            raise InputError(
                f"NearestNeighbours is for a GranularChain on a Lattice, not for {type(equation).__name__} on a "
                f"{type(grid).__name__}; choose a scheme for equations, such as CompactScheme."
            )
        kernel = _ChainKernel(equation, grid.size)
        return SemiDiscretization(
            size=grid.size,
            components=2,
            reach=1,
            rhs=kernel.rhs,
            jacobian=kernel.jacobian,
            invariants=kernel.invariants,
            magnitudes=kernel.magnitudes,
            diagnostics=kernel.diagnostics,
            split_steps=kernel.split_steps,
        )

    def suits(self, equation: Equation) -> float:
        """A chain, and nothing else."""
        return float(isinstance(equation, GranularChain))

    @property
    def refines(self) -> bool:
        """The sites of a chain are real."""
        return False


class _ChainKernel:
    """The right-hand side, the Jacobian, the invariants and the splitting of one chain."""

    def __init__(self, chain: GranularChain, size: int) -> None:
        self._in_stresses = chain.form == "stresses"
        self._ends, self._law = ENDS[chain.ends], chain.law
        self._strengths, self._static = chain.contact_strengths(size), chain.static_stress(size)
        self._inverse_masses, self._push = chain.inverse_masses(size), chain.compression
        self._size = size
        self._work = Workspace(size, size)

    @property
    def _surroundings(self) -> tuple[Array, Array, Array, float, kernels.Law, int]:
        """The arguments of the compiled stages, for a law that has coefficients."""
        assert self._law.coefficients is not None
        return self._strengths, self._static, self._inverse_masses, self._push, self._law.coefficients, self._ends

    def rhs(self, t: float, state: Array, out: Array) -> None:
        """Write the rates of both components."""
        if self._in_stresses:
            out[0] = state[1]
        else:
            np.multiply(state[1], self._inverse_masses, out=out[0])
        if self._law.coefficients is None:
            out[1] = self._pushes(state[0])
            return
        place, rate = self._work.arrays
        place[:], rate[:] = state[0], 0.0
        stage = kernels.stage_of_stresses if self._in_stresses else kernels.stage_of_displacements
        stage(place, rate, 0.0, 1.0, *self._surroundings)
        out[1] = rate

    def _pushes(self, place: Array) -> Array:
        """The rate of the second component from the first, for any law, shape (N,)."""
        if not self._in_stresses:
            force = self._law.force(self._contact_stresses(place) + self._static, self._strengths)
            if self._ends == kernels.FREE:
                force[0] = force[-1] = self._push
            return np.asarray(force[:-1] - force[1:])
        force = self._law.force(place + self._static, self._strengths)
        ends = (force[-1], force[0]) if self._ends == kernels.PERIODIC else (self._push, self._push)
        around = np.concatenate([ends[:1], force, ends[1:]])
        inverse = self._inverse_masses_between()
        push = inverse[:-1] * (around[:-2] - force) - inverse[1:] * (force - around[2:])
        if self._ends == kernels.HELD:
            push[0] = push[-1] = 0.0
        return np.asarray(push)

    def _inverse_masses_between(self) -> Array:
        """1 / m of the grains left and right of each contact, shape (N + 1,); zero for a wall."""
        inverse = np.broadcast_to(self._inverse_masses, self._size + 1).copy()
        if self._ends == kernels.FIXED:
            inverse[0] = inverse[-1] = 0.0
        return inverse

    def split_steps(self, state: Array, step: float, count: int, drifts: Array, kicks: Array) -> None:
        """Take steps of a splitting method that begins and ends with a kick, in place."""
        if self._law.coefficients is not None:
            kernels.split_steps(state, step, count, drifts, kicks, *self._surroundings, self._in_stresses)
            return
        speeds = 1.0 if self._in_stresses else self._inverse_masses
        for _ in range(count):
            for stage, kick in enumerate(kicks):
                if stage:
                    state[0] += step * drifts[stage - 1] * speeds * state[1]
                state[1] += step * kick * self._pushes(state[0])

    def _contact_stresses(self, displacement: Array) -> Array:
        """R from Q, with the contacts at the ends: N + 1 of them, zero where there is none."""
        left, right = -displacement[0], displacement[-1]
        if self._ends == kernels.PERIODIC:
            left = right = displacement[-1] - displacement[0]
        elif self._ends == kernels.FREE:
            left = right = 0.0
        return np.concatenate([[left], -np.diff(displacement), [right]])

    def jacobian(self, t: float, state: Array, out: Array) -> None:
        """Write the cyclic diagonals of the derivative of `rhs`."""
        out[:] = 0
        ring = self._ends == kernels.PERIODIC
        if self._in_stresses:
            slope = self._law.stiffness(state[0] + self._static, self._strengths)
            inverse = self._inverse_masses_between()
            out[0, 1, 1] = 1
            out[1, 0, 0] = inverse[:-1] * np.roll(slope, 1)
            out[1, 0, 1] = -(inverse[:-1] + inverse[1:]) * slope
            out[1, 0, 2] = inverse[1:] * np.roll(slope, -1)
            if self._ends == kernels.HELD:
                out[1, 0, :, [0, -1]] = 0
        else:
            stress = self._contact_stresses(state[0])
            slope = self._law.stiffness(stress + self._static, self._strengths)
            if self._ends == kernels.FREE:
                slope[0] = slope[-1] = 0
            out[0, 1, 1] = self._inverse_masses
            out[1, 0, 0], out[1, 0, 1], out[1, 0, 2] = slope[:-1], -(slope[:-1] + slope[1:]), slope[1:]
        if not ring:
            out[1, 0, 0, 0] = out[1, 0, 2, -1] = 0

    def densities(self, state: Array) -> dict[str, Array]:
        """What the conserved quantities of a state of shape (2, N) are sums of; nondimensional."""
        result = {}
        if self._in_stresses:
            stress, kinetic = state[0], self._kinetic_energies_of_rates(state[1])
            if self._ends in (kernels.PERIODIC, kernels.FIXED):
                result = {"mass": stress, "momentum": state[1]}
        else:
            stress = self._contact_stresses(state[0])
            kinetic = 0.5 * self._inverse_masses * state[1] ** 2
            if self._ends != kernels.FIXED:
                result = {"momentum": state[1]}
        # On a ring in displacements the contact between the last grain and the first stands at both ends.
        twice = not self._in_stresses and self._ends == kernels.PERIODIC
        return result | {"energy": np.concatenate([kinetic, self._stored_energies(stress)[int(twice) :]])}

    def invariants(self, state: Array) -> dict[str, float]:
        """The sums of the densities; none between held ends, which do work on the chain."""
        return {} if self._ends == kernels.HELD else self._sums(state)

    def diagnostics(self, state: Array) -> dict[str, float]:
        """The same where they are not conserved."""
        return self._sums(state) if self._ends == kernels.HELD else {}

    def magnitudes(self, state: Array) -> dict[str, float]:
        """The sums of their sizes."""
        conserved = {} if self._ends == kernels.HELD else self.densities(state)
        return {name: float(np.abs(density).sum()) for name, density in conserved.items()}

    def _sums(self, state: Array) -> dict[str, float]:
        return {name: float(density.sum()) for name, density in self.densities(state).items()}

    def _stored_energies(self, stress: Array) -> Array:
        """The energy of each contact above that of the static state, whose force is the push."""
        energy, factor = self._law.energy, self._strengths
        static = np.broadcast_to(self._static, factor.shape).copy()
        return np.asarray(energy(stress + self._static, factor) - energy(static, factor) - self._push * stress)

    def _kinetic_energies_of_rates(self, rate: Array) -> Array:
        """The kinetic energies of the grains: walls and held ends at rest, else in the frame of zero momentum."""
        velocity = -np.cumsum(rate)
        if self._ends in (kernels.FREE, kernels.HELD):
            velocity = np.append(0.0, velocity)
        elif self._ends == kernels.FIXED:
            velocity = velocity[:-1]
        inverse = self._inverse_masses
        if inverse.size > 1:
            inverse = inverse[1:] if self._ends == kernels.PERIODIC else inverse[inverse > 0]
        masses = np.broadcast_to(1 / inverse, velocity.shape)
        if self._ends in (kernels.PERIODIC, kernels.FREE):
            velocity = velocity - float(masses @ velocity) / float(masses.sum())
        return np.asarray(0.5 * masses * velocity**2)
