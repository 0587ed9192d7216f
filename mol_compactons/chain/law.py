"""The force of a contact between two grains."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons.chain import kernels
from mol_compactons.configuration import Settings
from mol_compactons.equations.base import check_exponent
from mol_compactons.equations.nesterenko import Nesterenko
from mol_compactons.errors import InputError, require

Array = NDArray[np.float64]

LARGEST_COMPRESSION = 2.0**200
"""Where the search for a static compression ends."""


class ContactLaw(Settings):
    """The force F(z) of a contact whose grains have come nearer by z; z < 0 where they have moved apart.

    A subclass is a frozen dataclass; it has to give the force, its derivative and its energy. All take arrays.
    """

    @abstractmethod
    def force(self, z: Array, factor: Array) -> Array:
        """F at the compressions z, shape (K,).

        Parameters
        ----------
        z : array, shape (K,)
            The compressions.
        factor : array, shape (K,) or (1,)
            How much stronger each contact is than one of the factor 1.
        """

    @abstractmethod
    def stiffness(self, z: Array, factor: Array) -> Array:
        """dF/dz, shape (K,)."""

    @abstractmethod
    def energy(self, z: Array, factor: Array) -> Array:
        """The energy stored in each contact, the integral of F from 0 to z, shape (K,)."""

    @property
    def coefficients(self) -> kernels.Law | None:
        """The law as two power laws, for compiled kernels of the whole chain; None where it is none."""
        return None

    @cached_property
    def continuum(self) -> Nesterenko:
        """Nesterenko's equation for the long waves of the chain, with the distance a = 1 between the grains.

        Raises
        ------
        InputError
            If the force is no power law.
        """
        raise InputError(
            f"The continuum of a chain of {type(self).__name__} contacts is not known to this program; give the initial data "
            "as a Formula or as Samples, or choose PowerContact."
        )

    def resists(self, sign: int) -> bool:
        """Whether a contact resists compression (1) or tension (-1) with a force that grows faster than z."""
        return True

    def static_compression(self, push: float, factor: Array) -> Array:
        """The compressions at which the contacts hold a static force, F(z) = push >= 0; shape of `factor`."""
        from scipy.optimize import brentq

        if push == 0:
            return np.zeros_like(factor)
        kinds, which = np.unique(factor, return_inverse=True)
        found = []
        for kind in kinds:
            strength = np.array([kind])

            def excess(z: float, strength: Array = strength) -> float:
                return float(self.force(np.array([z]), strength)[0]) - push

            upper = 1.0
            while excess(upper) < 0:
                upper *= 2
                require(
                    upper < LARGEST_COMPRESSION,
                    f"GranularChain.compression = {push:g} is more than its contacts can hold; choose a lower one.",
                )
            found.append(brentq(excess, 0.0, upper, xtol=1e-300, rtol=1e-15))
        return np.array(found)[which.reshape(factor.shape)]


@dataclass(frozen=True)
class PowerContact(ContactLaw):
    """A power law with a linear spring beside it; 3/2 is Hertz contact.

    Parameters
    ----------
    n : float
        The exponent, larger than 1.
    strength : float
        A > 0.
    linear : float
        B >= 0; 0 for sonic vacuum.
    kind : {"odd", "one_sided", "power", "rarefaction"}
        F = A |z|^(n-1) z + B z; A [z]_+^n, grains that can part; A z^n + B z with a whole n; -A z^n + B z with an even n, the
        paper's (Forcerar), for waves of rarefaction.

    Raises
    ------
    InputError
        If a parameter is out of range, or they do not fit together.

    Notes
    -----
    All quantities are nondimensional. Source: Nesterenko (1983), doi:10.1007/BF00905892; Vladimirov and Skurativskyi (2015),
    equations (Forceint) and (Forcerar).

    Examples
    --------
    >>> PowerContact(n=3, linear=1).force(np.array([2.0, -1.0]), np.ones(1))
    array([10., -2.])
    """

    n: float
    strength: float = 1.0
    linear: float = 0.0
    kind: Literal["odd", "one_sided", "power", "rarefaction"] = "odd"

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.n > 1, f"PowerContact.n = {self.n:g} must be larger than 1; the Hertz contact has n = 1.5.")
        check_exponent("PowerContact.n", self.n)
        require(self.strength > 0, f"PowerContact.strength = {self.strength:g} must be positive.")
        require(self.linear >= 0, f"PowerContact.linear = {self.linear:g} must not be negative; 0 is none.")
        whole = self.n == int(self.n)
        require(
            self.kind != "power" or whole,
            f"PowerContact.kind = 'power' needs a whole exponent, not n = {self.n:g}; choose 'odd' or 'one_sided'.",
        )
        require(
            self.kind != "rarefaction" or (whole and self.n % 2 == 0),
            f"PowerContact.kind = 'rarefaction' needs an even exponent, not n = {self.n:g}.",
        )
        require(
            self.kind != "one_sided" or self.linear == 0,
            "PowerContact.kind = 'one_sided' has no linear term, which would pull parted grains together; set linear=0.",
        )

    @property
    def coefficients(self) -> kernels.Law:
        """The law in the form of `mol_compactons.chain.kernels`."""
        strength = self.strength
        even = 1.0 if self.n % 2 == 0 else -1.0
        sides = {
            "odd": (strength, -strength),
            "one_sided": (strength, 0.0),
            "power": (strength, even * strength),
            "rarefaction": (-strength, -strength),
        }
        return (*sides[self.kind], self.n, self.linear)

    def force(self, z: Array, factor: Array) -> Array:
        """F; the factor multiplies the nonlinear part."""
        return np.asarray(kernels.forces(z, factor, self.coefficients))

    def stiffness(self, z: Array, factor: Array) -> Array:
        """F'."""
        return np.asarray(kernels.stiffnesses(z, factor, self.coefficients))

    def energy(self, z: Array, factor: Array) -> Array:
        """The integral of F."""
        return np.asarray(kernels.energies(z, factor, self.coefficients))

    @cached_property
    def continuum(self) -> Nesterenko:
        """Nesterenko's equation for the long waves of an odd chain."""
        return Nesterenko(self.n, self.strength, 1.0, self.linear)

    def resists(self, sign: int) -> bool:
        """Whether the nonlinear part pushes back."""
        plus, minus, _, _ = self.coefficients
        return plus > 0 if sign > 0 else minus < 0

    def static_compression(self, push: float, factor: Array) -> Array:
        """In closed form where there is no linear spring."""
        require(
            self.kind != "rarefaction" or push == 0,
            "GranularChain.compression is for laws that resist it; with kind = 'rarefaction' set it to 0.",
        )
        if self.linear:
            return super().static_compression(push, factor)
        return np.asarray((push / (self.strength * factor)) ** (1 / self.n))
