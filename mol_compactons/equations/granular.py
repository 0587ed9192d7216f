"""The granular compacton equation, the continuum of a chain of grains that moves one way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from mol_compactons.equations.base import Array, CosinePower, Equation, SecondDifference, check_exponent, compacton_height
from mol_compactons.equations.flux import Flux, contact_flux
from mol_compactons.errors import require


@dataclass(frozen=True)
class GranularCompacton(Equation):
    r"""The granular compacton equation, for waves of compression (W > 0) and of rarefaction (W < 0) alike.

    .. math::  W_t + \{ |W|^{n-1} W + \psi (\psi W)_{xx} \}_x = 0,   \psi = |W|^{(n-1)/2}

    For odd n this is W_t + {W^n + W^((n-1)/2) (W^((n+1)/2))_xx}_x = 0. For even n it is that equation where W > 0, and
    where W < 0 the one with the opposite sign in front of the braces. Any real n > 1 will do; n = 3/2 is Hertz contact.

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
    long_names: ClassVar[Mapping[str, str]] = {
        "W": "amplitude, positive for compression",
        "momentum": "momentum Q, half the integral of the squared amplitude",
        "energy": "energy H, the Hamiltonian with the second difference of the scheme",
    }

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.n > 1, f"GranularCompacton.n = {self.n:g} must be larger than 1; the Hertz contact has n = 1.5.")
        check_exponent("GranularCompacton.n", self.n)

    @cached_property
    def dispersive_flux(self) -> Flux:
        """The flux a = |W|^(n-1) W, b = psi, g = psi W."""
        return contact_flux(self.n, 1.0, 1.0)

    def compacton(self, speed: float, sign: int = 1) -> CosinePower:
        """The compacton of speed c > 0: M = +-(c (n+1) / 2)^(1/(n-1)), K = (n-1)/(n+1), gamma = 2/(n-1)."""
        n = self.n
        require(
            speed > 0,
            f"Compacton.speed = {speed:g} must be positive for the granular compacton equation, whose bright and dark "
            "waves both move to the right; sign=-1 gives a dark one.",
        )
        return CosinePower(sign * compacton_height(speed * (n + 1) / 2, n), (n - 1) / (n + 1), 2 / (n - 1))

    def compacton_speed(self, height: float) -> float:
        """C = 2 M^(n-1) / (n+1)."""
        return float(2 * height ** (self.n - 1) / (self.n + 1))

    def densities(self, state: Array, second_difference: SecondDifference) -> dict[str, Array]:
        """Those of mass, momentum Q and energy H, of a state of shape (1, N)."""
        (u,) = state
        flux = self.dispersive_flux
        return {"mass": u, "momentum": 0.5 * u * u, "energy": -flux.energy_parts(u, second_difference(flux.g(u)))}
