"""The granular chain, in stresses or in displacements: discrete by nature, its own semi-discretisation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons import contacts
from mol_compactons.configuration import check
from mol_compactons.equations import CosinePower
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.nesterenko import Nesterenko
from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]
Profile = Callable[[Array], Array]

ENDS = {"periodic": contacts.PERIODIC, "fixed": contacts.FIXED, "free": contacts.FREE, "held": contacts.HELD}


@dataclass(frozen=True)
class GranularChain:
    r"""A chain of grains that push each other with the force F(R_k) of their contacts, R_k = Q_(k-1) - Q_k.

    .. math::
        m_k \ddot Q_k = F(R_k) - F(R_{k+1}), \qquad
        \ddot R_k = \frac{F(R_{k-1}) - F(R_k)}{m_{k-1}} - \frac{F(R_k) - F(R_{k+1})}{m_k}

    Conserved: the energy, sum of p^2 / (2 m) and of the contacts', except between held ends; in displacements the momentum
    Sum p too, except between fixed ends; in stresses, on a ring or between fixed ends, mass = Sum R and momentum = Sum R_t.

    Parameters
    ----------
    n : float
        The exponent of the force, larger than 1; 3/2 is Hertz contact.
    strength : float
        A > 0.
    linear : float
        B >= 0; 0 for sonic vacuum.
    law : {"odd", "one_sided", "power", "rarefaction"}
        F = A |z|^(n-1) z + B z; A [z]_+^n, grains that can part; A z^n + B z with a whole n; -A z^n + B z with an even n, the
        paper's (Forcerar), for waves of rarefaction.
    ends : {"periodic", "fixed", "free", "held"}
        A ring; walls at both ends; nothing there but the push of the static compression; or, in stresses, no acceleration
        of the first and the last stress, as in the paper.
    form : {"stresses", "displacements"}
        Whether the unknowns are R_k and its rate, one for each contact, or Q_k and the momentum p_k, one for each grain.
    compression : float
        The static force F0 >= 0 that squeezes all contacts; R and Q count from that state.
    masses : list of float
        The masses of the grains from left to right; empty for masses of 1.
    strengths : list of float
        Factors of A for the contacts from left to right; empty for 1.

    Raises
    ------
    InputError
        If a parameter is out of range, or they do not fit together.

    Notes
    -----
    All quantities are nondimensional. Contact k has the coordinate k, the grain between the contacts k and k + 1 the
    coordinate k + 1/2. Source: Nesterenko (1983), doi:10.1007/BF00905892; Vladimirov and Skurativskyi (2015), equations
    (DS_Nest), (Forceint) and (Forcerar).
    """

    n: float
    strength: float = 1.0
    linear: float = 0.0
    law: Literal["odd", "one_sided", "power", "rarefaction"] = "odd"
    ends: Literal["periodic", "fixed", "free", "held"] = "periodic"
    form: Literal["stresses", "displacements"] = "stresses"
    compression: float = 0.0
    masses: tuple[float, ...] = ()
    strengths: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        check(self)
        require(self.n > 1, f"GranularChain.n = {self.n:g} must be larger than 1; the Hertz contact has n = 1.5.")
        require(self.strength > 0, f"GranularChain.strength = {self.strength:g} must be positive.")
        for name in ("linear", "compression"):
            value = getattr(self, name)
            require(value >= 0, f"GranularChain.{name} = {value:g} must not be negative; 0 is none.")
        for name in ("masses", "strengths"):
            least = min(getattr(self, name), default=1.0)
            require(least > 0, f"GranularChain.{name} holds {least:g}; all must be positive.")
        whole = self.n == int(self.n)
        require(
            self.law != "power" or whole,
            f"GranularChain.law = 'power' needs a whole exponent, not n = {self.n:g}; choose 'odd' or 'one_sided'.",
        )
        require(
            self.law != "rarefaction" or (whole and self.n % 2 == 0),
            f"GranularChain.law = 'rarefaction' needs an even exponent, not n = {self.n:g}.",
        )
        require(
            self.law != "one_sided" or self.linear == 0,
            "GranularChain.law = 'one_sided' has no linear term, which would pull parted grains together; set linear=0.",
        )
        require(
            self.law != "rarefaction" or self.compression == 0,
            "GranularChain.compression is for laws that resist it; with law = 'rarefaction' set it to 0.",
        )
        require(
            self.ends != "held" or self.form == "stresses",
            "GranularChain.ends = 'held' holds stresses; choose form='stresses', or fixed or free ends.",
        )

    @property
    def variables(self) -> tuple[str, str]:
        """The names of the components."""
        return ("R", "R_t") if self.form == "stresses" else ("Q", "p")

    @property
    def coefficients(self) -> contacts.Law:
        """The law in the form of `mol_compactons.contacts`."""
        strength = self.strength
        even = 1.0 if self.n % 2 == 0 else -1.0
        sides = {
            "odd": (strength, -strength),
            "one_sided": (strength, 0.0),
            "power": (strength, even * strength),
            "rarefaction": (-strength, -strength),
        }
        return (*sides[self.law], self.n, self.linear)

    def force(self, stress: Array) -> Array:
        """F at each stress, shape (K,), of a contact of the factor 1."""
        return np.array([contacts.force(float(z), 1.0, self.coefficients) for z in stress])

    @cached_property
    def continuum(self) -> Nesterenko:
        """Nesterenko's equation for the long waves of an odd chain, with the distance a = 1 between the grains."""
        return Nesterenko(self.n, self.strength, 1.0, self.linear)

    def compacton(self, speed: float, sign: int = 1) -> CosinePower:
        """The compacton of Nesterenko's equation with a = 1: the data of the paper for the chain, not its exact wave."""
        self.check_sign(sign)
        return self.continuum.compacton(speed, sign)

    def check_sign(self, sign: int) -> None:
        """Refuse waves of a sign for which there is no restoring nonlinear force."""
        plus, minus, _, _ = self.coefficients
        require(
            (plus > 0) if sign > 0 else (minus < 0),
            f"A chain with law = {self.law!r} and n = {self.n:g} has no solitary wave of sign = {sign}: its contacts do not "
            f"resist {'compression' if sign > 0 else 'tension'}; choose sign={-sign}.",
        )

    def check_center(self, center: float, grid: Lattice) -> None:
        """Refuse a wave whose centre lies beyond the ends."""
        require(
            self.ends == "periodic" or 0 <= center <= grid.size - 1,
            f"A wave at center = {center:g} lies outside the chain, which reaches from 0 to {grid.size - 1}; move it inside.",
        )

    def travelling_state(self, shape: Profile, z: Array, speed: float, velocity: Profile | None = None) -> Array:
        """The state of a wave, shape (2, N), from its stress and the velocity of its grains as functions of the distance.

        Parameters
        ----------
        shape : callable
            The stress at a distance from the centre of the wave.
        z : array, shape (N,)
            The distances of the contacts.
        speed : float
            The speed V.
        velocity : callable, optional
            The velocity of a grain; by default V times the stress there, as of a long wave. Rates of the stress are
            differences of it, and add up to zero on a ring.
        """
        velocity = velocity or (lambda places: speed * shape(places))
        stress = shape(z)
        largest = float(np.abs(stress).max())
        require(
            self.ends == "periodic" or max(abs(stress[0]), abs(stress[-1])) <= 1e-6 * largest,
            f"The pulse does not fit in the chain: at its ends the stress is {stress[0]:.2g} and {stress[-1]:.2g}; move the "
            "pulse inside, or take a longer chain.",
        )
        if self.form == "stresses":
            return np.array([stress, velocity(z - 0.5) - velocity(z + 0.5)])
        require(
            self.ends != "periodic" or abs(float(stress.sum())) <= 1e-9 * float(np.abs(stress).sum()),
            "A pulse shortens the chain and does not fit on a ring in displacements; choose form='stresses', or free ends.",
        )
        shifted = np.append(stress[1:], 0.0)
        displacement = np.cumsum(shifted[::-1])[::-1]
        return np.array([displacement, velocity(z + 0.5) / self.inverse_masses(z.size)[: z.size]])

    def check_state(self, state: Array) -> None:
        """Refuse states that no grains can be in."""
        if self.form == "displacements":
            pulled = self.ends == "fixed" and self.law != "one_sided" and self.compression == 0 and abs(state[0][0]) > 0
            require(
                not pulled,
                f"The first grain stands at Q = {state[0][0]:.4g}, where the left wall would pull it; choose free ends, "
                "law='one_sided', or data with the ends at rest.",
            )
        elif self.ends in ("periodic", "fixed"):
            total, size = float(state[1].sum()), float(np.abs(state[1]).sum())
            require(
                abs(total) <= 1e-9 * size,
                f"The rates R_t add up to {total:.4g}, but on a ring or between walls they must add up to 0; subtract their "
                "mean.",
            )
            length, size = float(state[0].sum()), float(np.abs(state[0]).sum())
            require(
                self.ends == "periodic" or abs(length) <= 1e-9 * size,
                f"The stresses add up to {length:.4g}, but between walls, which do not move, they must add up to 0; choose "
                "other ends.",
            )

    def contact_count(self, size: int) -> int:
        """How many contacts a chain of `size` unknowns has."""
        if self.form == "stresses":
            return size
        return {"periodic": size, "fixed": size + 1, "free": size - 1}[self.ends]

    def grain_count(self, size: int) -> int:
        """How many grains it has."""
        if self.form == "displacements":
            return size
        return {"periodic": size, "fixed": size - 1, "free": size + 1, "held": size + 1}[self.ends]

    def inverse_masses(self, size: int) -> Array:
        """1 / m as the stages of `mol_compactons.contacts` index it: of length 1 where all masses are equal."""
        if not self.masses:
            return np.ones(1) if self.form == "stresses" else np.ones(size)
        count = self.grain_count(size)
        require(
            len(self.masses) == count,
            f"GranularChain.masses holds {len(self.masses)} numbers, but the chain has {count} grains; give {count}.",
        )
        inverse = 1 / np.array(self.masses)
        if self.form == "displacements" or self.ends in ("free", "held"):
            return inverse
        return np.append(inverse[-1], inverse) if self.ends == "periodic" else np.concatenate([[0.0], inverse, [0.0]])

    def contact_strengths(self, size: int) -> Array:
        """The factors of A, padded for the ends without a contact; of length 1 where all are equal."""
        if not self.strengths:
            return np.ones(1)
        count = self.contact_count(size)
        require(
            len(self.strengths) == count,
            f"GranularChain.strengths holds {len(self.strengths)} numbers, but the chain has {count} contacts; give {count}.",
        )
        factors = np.array(self.strengths)
        if self.form == "stresses" or self.ends == "fixed":
            return factors
        return np.append(factors, factors[0]) if self.ends == "periodic" else np.concatenate([[1.0], factors, [1.0]])

    def static_stress(self, size: int) -> Array:
        """The stress of each contact under the static compression, F(delta) = F0."""
        factors = self.contact_strengths(size)
        if self.compression == 0:
            return np.zeros(1)
        delta = (self.compression / (self.strength * factors)) ** (1 / self.n)
        for _ in range(60):
            value = self.strength * factors * delta**self.n + self.linear * delta - self.compression
            delta -= value / (self.n * self.strength * factors * delta ** (self.n - 1) + self.linear)
        return np.asarray(delta)

    def frequency_squared(self, wavenumber: float, stress: float) -> float:
        """omega^2 = F'(R0) 4 sin^2(k / 2) of small waves about a uniform stress R0 of a chain of equal grains."""
        return float(contacts.stiffness(stress, 1.0, self.coefficients) * 4 * np.sin(wavenumber / 2) ** 2)


@dataclass(frozen=True)
class NearestNeighbours:
    """The differences that belong to a chain: exact, not an approximation.

    Raises
    ------
    InputError
        For anything but a GranularChain on a Lattice.
    """

    def discretize(self, equation: Any, grid: Grid | Lattice) -> SemiDiscretization:
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
            split_steps=kernel.split_steps,
        )


class _ChainKernel:
    """The right-hand side, the Jacobian, the invariants and the splitting of one chain."""

    def __init__(self, chain: GranularChain, size: int) -> None:
        self._in_stresses = chain.form == "stresses"
        self._ends, self._law = ENDS[chain.ends], chain.coefficients
        self._strengths, self._static = chain.contact_strengths(size), chain.static_stress(size)
        self._inverse_masses, self._push = chain.inverse_masses(size), chain.compression
        self._scratch = np.empty((2, size))

    @property
    def _surroundings(self) -> tuple[Array, Array, Array, float, contacts.Law, int]:
        return self._strengths, self._static, self._inverse_masses, self._push, self._law, self._ends

    def rhs(self, t: float, state: Array, out: Array) -> None:
        """Write the rates of both components."""
        self._scratch[0], self._scratch[1] = state[0], 0.0
        if self._in_stresses:
            out[0] = state[1]
            contacts.stage_of_stresses(self._scratch[0], self._scratch[1], 0.0, 1.0, *self._surroundings)
        else:
            np.multiply(state[1], self._inverse_masses, out=out[0])
            contacts.stage_of_displacements(self._scratch[0], self._scratch[1], 0.0, 1.0, *self._surroundings)
        out[1] = self._scratch[1]

    def split_steps(self, state: Array, step: float, count: int, drifts: Array, kicks: Array) -> None:
        """Take steps of a splitting method, in place."""
        contacts.split_steps(state, step, count, drifts, kicks, *self._surroundings, self._in_stresses)

    def _contact_stresses(self, displacement: Array) -> Array:
        """R from Q, with the contacts at the ends: N + 1 of them, zero where there is none."""
        left, right = -displacement[0], displacement[-1]
        if self._ends == contacts.PERIODIC:
            left = right = displacement[-1] - displacement[0]
        elif self._ends == contacts.FREE:
            left = right = 0.0
        return np.concatenate([[left], -np.diff(displacement), [right]])

    def jacobian(self, t: float, state: Array, out: Array) -> None:
        """Write the cyclic diagonals of the derivative of `rhs`."""
        out[:] = 0
        ring = self._ends == contacts.PERIODIC
        if self._in_stresses:
            slope = contacts.stiffnesses(state[0], self._strengths, self._static, self._law)
            inverse = np.broadcast_to(self._inverse_masses, state.shape[1] + 1).copy()
            if self._ends == contacts.FIXED:
                inverse[0] = inverse[-1] = 0
            out[0, 1, 1] = 1
            out[1, 0, 0] = inverse[:-1] * np.roll(slope, 1)
            out[1, 0, 1] = -(inverse[:-1] + inverse[1:]) * slope
            out[1, 0, 2] = inverse[1:] * np.roll(slope, -1)
            if self._ends == contacts.HELD:
                out[1, 0, :, [0, -1]] = 0
        else:
            stress = self._contact_stresses(state[0])
            slope = contacts.stiffnesses(stress, self._strengths, self._static, self._law)
            if self._ends == contacts.FREE:
                slope[0] = slope[-1] = 0
            out[0, 1, 1] = self._inverse_masses
            out[1, 0, 0], out[1, 0, 1], out[1, 0, 2] = slope[:-1], -(slope[:-1] + slope[1:]), slope[1:]
        if not ring:
            out[1, 0, 0, 0] = out[1, 0, 2, -1] = 0

    def invariants(self, state: Array) -> dict[str, float]:
        """What the chain conserves, of a state of shape (2, N); nondimensional."""
        result = {}
        if self._in_stresses:
            stress, kinetic = state[0], self._kinetic_energy_of_rates(state[1])
            if self._ends in (contacts.PERIODIC, contacts.FIXED):
                result = {"mass": float(stress.sum()), "momentum": float(state[1].sum())}
        else:
            stress = self._contact_stresses(state[0])
            kinetic = 0.5 * float((state[1] * self._inverse_masses) @ state[1])
            if self._ends != contacts.FIXED:
                result = {"momentum": float(state[1].sum())}
        stored = contacts.potential(stress, self._strengths, self._static, self._push, self._law)
        if not self._in_stresses and self._ends == contacts.PERIODIC:
            stored -= contacts.potential(stress[:1], self._strengths[:1], self._static[:1], self._push, self._law)
        return result | {"energy": kinetic + stored}

    def _kinetic_energy_of_rates(self, rate: Array) -> float:
        """The kinetic energy of the grains: walls and held ends at rest, else in the frame of zero momentum."""
        velocity = -np.cumsum(rate)
        if self._ends in (contacts.FREE, contacts.HELD):
            velocity = np.append(0.0, velocity)
        elif self._ends == contacts.FIXED:
            velocity = velocity[:-1]
        inverse = self._inverse_masses
        if inverse.size > 1:
            inverse = inverse[1:] if self._ends == contacts.PERIODIC else inverse[inverse > 0]
        masses = np.broadcast_to(1 / inverse, velocity.shape)
        if self._ends in (contacts.PERIODIC, contacts.FREE):
            velocity = velocity - float(masses @ velocity) / float(masses.sum())
        return 0.5 * float(masses @ velocity**2)
