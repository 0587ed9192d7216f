"""The equations: each is one flux in one of two roles, with its invariants and the shape of its compactons."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import check
from mol_compactons.errors import require
from mol_compactons.flux import Flux, PowerLaw, whole_power

SecondDifference = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Maps the values of a function on the grid to an approximation of its second derivative there."""


@dataclass(frozen=True)
class CosinePower:
    """The shape that the compactons of this family share: M cos^gamma(K z) for |K z| < pi / 2, and zero elsewhere.

    Parameters
    ----------
    amplitude, wavenumber, exponent : float
        M, K and gamma, nondimensional.
    """

    amplitude: float
    wavenumber: float
    exponent: float

    @property
    def width(self) -> float:
        """The length of the support, pi / K, nondimensional."""
        return math.pi / self.wavenumber

    def __call__(self, z: NDArray[np.float64]) -> NDArray[np.float64]:
        """The profile at the distances z from the centre, same shape."""
        phase = np.minimum(np.abs(self.wavenumber * np.asarray(z, dtype=float)), np.pi / 2)
        cosine = np.where(phase < np.pi / 2, np.cos(phase), 0.0)
        return np.asarray(self.amplitude * cosine**self.exponent)


@dataclass(frozen=True)
class GranularCompacton:
    r"""The granular compacton equation, for waves of compression (W > 0) and of rarefaction (W < 0) alike.

    .. math::  W_t + \{ |W|^{n-1} W + \psi (\psi W)_{xx} \}_x = 0,   \psi = |W|^{(n-1)/2}

    For odd n this is W_t + {W^n + W^((n-1)/2) (W^((n+1)/2))_xx}_x = 0. For even n it is that equation where W > 0, and
    where W < 0 the one with the opposite sign in front of the braces. Any real n > 1 will do; n = 3/2 is Hertz contact.
    For n = 3 the smooth polynomials W^3, W, W^2 take the place of the odd extension, of which they are the same flux.

    Conserved: mass = Int W, momentum Q = 1/2 Int W^2 and energy
    H = Int [(n+1)/4 |W|^(n-1) W_x^2 - |W|^(n+1) / (n+1)].

    Parameters
    ----------
    n : float
        The exponent of the force between grains, larger than 1.

    Raises
    ------
    InputError
        If n is 1 or less.

    Notes
    -----
    All quantities are nondimensional. Source: Vladimirov and Skurativskyi, "Solitary waves in one-dimensional
    pre-stressed lattice and its continual analog" (2015), equations (PDE3), (PDErar) and (PDEComprar).

    Examples
    --------
    >>> GranularCompacton(n=3).compacton(speed=1).width
    6.283185307179586
    """

    n: float

    variables = ("W",)
    two_way = False

    def __post_init__(self) -> None:
        check(self)
        require(self.n > 1, f"GranularCompacton.n = {self.n:g} must be larger than 1; the Hertz contact has n = 1.5.")

    @cached_property
    def flux(self) -> Flux:
        """The flux a = |W|^(n-1) W, b = psi, g = psi W."""
        if self.n == 3:
            return Flux((whole_power(1, 3),), whole_power(1, 1), whole_power(1, 2))
        a = PowerLaw(1, self.n, odd=True)
        return Flux((a,), PowerLaw(1, (self.n - 1) / 2), PowerLaw(1, (self.n + 1) / 2, odd=True))

    def compacton(self, speed: float) -> CosinePower:
        """The compacton of a given speed c > 0: M = (c (n+1) / 2)^(1/(n-1)), K = (n-1)/(n+1), gamma = 2/(n-1)."""
        n = self.n
        require(
            speed > 0,
            f"Compacton.speed = {speed:g} must be positive for the granular compacton equation, whose bright and dark "
            "waves both move to the right; sign=-1 gives a dark one.",
        )
        return CosinePower((speed * (n + 1) / 2) ** (1 / (n - 1)), (n - 1) / (n + 1), 2 / (n - 1))

    def invariants(self, state: NDArray[np.float64], spacing: float, second_difference: SecondDifference) -> dict[str, float]:
        """Mass, momentum Q and energy H of a state of shape (1, N), as sums over the grid; nondimensional."""
        (u,) = state
        kappa = 2 / (self.n + 1)
        energy = self.flux.energy_density(u, second_difference(self.flux.g(u)), kappa)
        return {
            "mass": spacing * float(u.sum()),
            "momentum": 0.5 * spacing * float(u @ u),
            "energy": -spacing * float(energy.sum()),
        }
