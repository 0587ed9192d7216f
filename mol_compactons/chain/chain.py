"""The granular chain, in stresses or in displacements: discrete by nature, its own semi-discretisation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from mol_compactons.chain import kernels
from mol_compactons.chain.family import ChainShape, chain_shape, chain_speed
from mol_compactons.chain.law import Array, ContactLaw
from mol_compactons.equations.base import CosinePower, Equation
from mol_compactons.equations.nesterenko import REFERENCE
from mol_compactons.errors import require
from mol_compactons.grid import Lattice

Profile = Callable[[Array], Array]

ENDS = {"periodic": kernels.PERIODIC, "fixed": kernels.FIXED, "free": kernels.FREE, "held": kernels.HELD}

LARGEST_EXCESS = 1e-3
"""How far the rates of the stress may be from adding up to zero, relative to their sizes: more than a run at any tolerance
adds, so that its last frame can be initial data."""


@dataclass(frozen=True)
class GranularChain(Equation):
    r"""A chain of grains that push each other with the force F(R_k) of their contacts, R_k = Q_(k-1) - Q_k.

    .. math::
        m_k \ddot Q_k = F(R_k) - F(R_{k+1}), \qquad
        \ddot R_k = \frac{F(R_{k-1}) - F(R_k)}{m_{k-1}} - \frac{F(R_k) - F(R_{k+1})}{m_k}

    Conserved: the energy, sum of p^2 / (2 m) and of the contacts', except between held ends; in displacements the momentum
    Sum p too, except between fixed ends; in stresses, on a ring or between fixed ends, mass = Sum R and momentum = Sum R_t.

    Parameters
    ----------
    law : ContactLaw
        The force F of a contact, such as ``PowerContact(n=1.5)``, Hertz contact.
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
        Factors of the force for the contacts from left to right; empty for 1.

    Raises
    ------
    InputError
        If a parameter is out of range, or the parts do not fit together.

    Notes
    -----
    All quantities are nondimensional. Contact k has the coordinate k, the grain between the contacts k and k + 1 the
    coordinate k + 1/2. Source: Nesterenko (1983), doi:10.1007/BF00905892; Vladimirov and Skurativskyi (2015), equations
    (DS_Nest), (Forceint) and (Forcerar).
    """

    law: ContactLaw
    ends: Literal["periodic", "fixed", "free", "held"] = "periodic"
    form: Literal["stresses", "displacements"] = "stresses"
    compression: float = 0.0
    masses: tuple[float, ...] = ()
    strengths: tuple[float, ...] = ()

    long_names: ClassVar[Mapping[str, str]] = {
        "R": "stress between neighbouring grains, the difference of their displacements",
        "R_t": "rate of the stress",
        "Q": "displacement of a grain",
        "p": "momentum of a grain",
        "mass": "mass, the sum of the stresses",
        "momentum": "momentum, the sum of the momenta or of the rates of the stress",
        "energy": "energy of the grains and their contacts",
    }
    reference = REFERENCE

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.compression >= 0, f"GranularChain.compression = {self.compression:g} must not be negative; 0 is none.")
        for name in ("masses", "strengths"):
            least = min(getattr(self, name), default=1.0)
            require(least > 0, f"GranularChain.{name} holds {least:g}; all must be positive.")
        self.law.static_compression(self.compression, np.ones(1))
        require(
            self.ends != "held" or self.form == "stresses",
            "GranularChain.ends = 'held' holds stresses; choose form='stresses', or fixed or free ends.",
        )

    @classmethod
    def from_earlier(cls, fields: dict[str, Any]) -> dict[str, Any]:
        """Up to format 1 the power law was spelt in fields of the chain."""
        if "n" not in fields:
            return fields
        law = {"type": "PowerContact", "kind": fields.get("law", "odd")}
        law |= {name: fields[name] for name in ("n", "strength", "linear") if name in fields}
        return {name: value for name, value in fields.items() if name not in law} | {"law": law}

    @property
    def variables(self) -> tuple[str, str]:
        """The names of the components."""
        return ("R", "R_t") if self.form == "stresses" else ("Q", "p")

    def compacton(self, speed: float, sign: int = 1) -> CosinePower:
        """The compacton of Nesterenko's equation with a = 1: the data of the paper for the chain, not its exact wave."""
        self.check_sign(sign)
        return self.law.continuum.compacton(speed, sign)

    def solitary_shape(self, height: float, sign: int = 1) -> ChainShape | None:
        """The shape of the exact solitary wave of a height; None where `solitary_profile` has none for this chain."""
        law = self._law_on_the_side(sign)
        return None if law is None else chain_shape(*law, self.checked_height(height), sign)

    def solitary_speed(self, height: float, sign: int = 1) -> float | None:
        """Its speed V > 0, to either side."""
        law = self._law_on_the_side(sign)
        return None if law is None else chain_speed(*law, self.checked_height(height))

    def _law_on_the_side(self, sign: int) -> tuple[float, float, float, float] | None:
        """n, A, B and the static stress of equal contacts under compression or tension; None where there is no wave."""
        coefficients = self.law.coefficients
        if coefficients is None or self.masses or self.strengths or not self.law.resists(sign):
            return None
        if sign < 0 and self.compression:
            return None
        plus, minus, n, linear = coefficients
        return n, (plus if sign > 0 else -minus), linear, float(self.static_stress(1)[0])

    def check_sign(self, sign: int) -> None:
        """Refuse waves of a sign for which there is no restoring nonlinear force."""
        require(
            self.law.resists(sign),
            f"A chain with law = {self.law!r} has no solitary wave of sign = {sign}: its contacts do not resist "
            f"{'compression' if sign > 0 else 'tension'}; choose sign={-sign}.",
        )

    def check_center(self, center: float, grid: Lattice) -> None:
        """Refuse a wave whose centre lies beyond the ends."""
        require(
            self.ends == "periodic" or 0 <= center <= grid.size - 1,
            f"A wave at center = {center:g} lies outside the chain, which reaches from 0 to {grid.size - 1}; move it inside.",
        )

    def travelling_state(
        self, shape: Profile, z: Array, speed: float, velocity: Profile | None = None, rate: Profile | None = None
    ) -> Array:
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
        rate : callable, optional
            The rate of the stress, in place of a velocity of the grains. The last grain is at rest then, and the others have
            the velocities that make these rates.
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
            return np.array([stress, rate(z) if rate else velocity(z - 0.5) - velocity(z + 0.5)])
        require(
            self.ends != "periodic" or abs(float(stress.sum())) <= 1e-9 * float(np.abs(stress).sum()),
            "A pulse shortens the chain and does not fit on a ring in displacements; choose form='stresses', or free ends.",
        )
        velocities = _sums_to_the_right(rate(z)) if rate else velocity(z + 0.5)
        return np.array([_sums_to_the_right(stress), velocities / self.inverse_masses(z.size)])

    def check_state(self, state: Array) -> None:
        """Refuse states that no grains can be in."""
        if self.form == "displacements" or self.ends not in ("periodic", "fixed"):
            return
        total, size = float(state[1].sum()), float(np.abs(state[1]).sum())
        require(
            abs(total) <= LARGEST_EXCESS * size,
            f"The rates R_t add up to {total:.4g}, but on a ring or between walls they must add up to 0; subtract their mean.",
        )
        length, size = float(state[0].sum()), float(np.abs(state[0]).sum())
        require(
            self.ends == "periodic" or abs(length) <= LARGEST_EXCESS * size,
            f"The stresses add up to {length:.4g}, but between walls, which do not move, they must add up to 0; choose other "
            "ends.",
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
        """1 / m as the stages of `mol_compactons.chain.kernels` index it: of length 1 where all masses are equal."""
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
        """The stress of each contact under the static compression, F(z) = F0."""
        factors = self.contact_strengths(size)
        return self.law.static_compression(self.compression, factors if self.compression else np.ones(1))

    def frequency_squared(self, wavenumber: float, stress: float) -> float:
        """omega^2 = F'(R0) 4 sin^2(k / 2) of small waves about a uniform stress R0 of a chain of equal grains."""
        return float(self.law.stiffness(np.array([stress]), np.ones(1))[0] * 4 * np.sin(wavenumber / 2) ** 2)


def _sums_to_the_right(values: Array) -> Array:
    """For each grain the sum over the contacts right of it, zero at the last: that of which these are the differences."""
    return np.asarray(np.cumsum(np.append(values[1:], 0.0)[::-1])[::-1])
