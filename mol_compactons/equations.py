"""The equations: each is one flux in one of two roles, with its invariants and the shape of its compactons."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import check
from mol_compactons.errors import InputError, require
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

    def slope(self, z: NDArray[np.float64]) -> NDArray[np.float64]:
        """The derivative of the profile at the distances z from the centre, same shape; zero at the edges and outside."""
        phase = self.wavenumber * np.asarray(z, dtype=float)
        inside = np.abs(phase) < np.pi / 2
        cosine, sine = np.cos(phase[inside]), np.sin(phase[inside])
        slope = np.zeros_like(phase)
        slope[inside] = -self.amplitude * self.exponent * self.wavenumber * cosine ** (self.exponent - 1) * sine
        return slope


def compacton_height(power: float, n: float) -> float:
    """The height M of a compacton with M^(n-1) = power."""
    exponent = math.log(power) / (n - 1)
    require(
        abs(exponent) < 200,
        f"The compacton of this speed has the height exp({exponent:.4g}) for an exponent {n:g}, out of the range of numbers; "
        "choose a speed nearer to 1, or a larger exponent.",
    )
    return float(power ** (1 / (n - 1)))


def contact_flux(n: float, strength: float, dispersion: float) -> Flux:
    """The flux of a contact of exponent n: a = C |u|^(n-1) u, b = C beta |u|^((n-1)/2), g = |u|^((n-1)/2) u.

    For n = 3 the smooth polynomials u^3, u, u^2 take their place, of which they are the same flux.
    """
    if n == 3:
        return Flux((whole_power(strength, 3),), whole_power(strength * dispersion, 1), whole_power(1, 2))
    a = PowerLaw(strength, n, odd=True)
    return Flux((a,), PowerLaw(strength * dispersion, (n - 1) / 2), PowerLaw(1, (n + 1) / 2, odd=True))


@dataclass(frozen=True)
class GranularCompacton:
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
    two_way = False

    def __post_init__(self) -> None:
        check(self)
        require(self.n > 1, f"GranularCompacton.n = {self.n:g} must be larger than 1; the Hertz contact has n = 1.5.")

    @cached_property
    def flux(self) -> Flux:
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

    def travelling_state(self, shape: CosinePower, z: NDArray[np.float64], speed: float) -> NDArray[np.float64]:
        """The state of a wave of this shape at the distances z from its centre, shape (1, N)."""
        return shape(z)[None]

    def check_center(self, center: float, grid: Any) -> None:
        """Any place on the periodic line will do."""

    def check_state(self, state: NDArray[np.float64]) -> None:
        """Any real state will do."""

    def invariants(self, state: NDArray[np.float64], spacing: float, second_difference: SecondDifference) -> dict[str, float]:
        """Mass, momentum Q and energy H of a state of shape (1, N), as sums over the grid; nondimensional."""
        (u,) = state
        energy = self.flux.energy_density(u, second_difference(self.flux.g(u)))
        return {
            "mass": spacing * float(u.sum()),
            "momentum": 0.5 * spacing * float(u @ u),
            "energy": -spacing * float(energy.sum()),
        }


@dataclass(frozen=True)
class RosenauHyman:
    r"""The Rosenau-Hyman equation K(m, n).

    .. math::  u_t + (u^m)_x + (u^n)_{xxx} = 0

    In the classical form u^m is the plain power of a whole exponent; in the absolute form it is |u|^(m-1) u, odd in u for any
    real exponent, so that every wave has a mirror image that moves the same way.

    Conserved: mass = Int u and energy = Int of the antiderivative of u^n; with m = n the equation is u_t = -(d + d^3)
    of the variational derivative of that energy. (With m = n also Int u cos x and Int u sin x.) The momentum Int u^2 / 2
    is conserved for n = 1 only, where it is that energy.

    Parameters
    ----------
    m, n : float
        The exponents, at least 1.
    absolute : bool
        Whether powers are |u|^(m-1) u and |u|^(n-1) u.

    Raises
    ------
    InputError
        If an exponent is less than 1, or no whole number in the classical form.

    Notes
    -----
    All quantities are nondimensional. Source: Rosenau and Hyman, Phys. Rev. Lett. 70 (1993) 564,
    doi:10.1103/PhysRevLett.70.564.

    Examples
    --------
    >>> round(RosenauHyman(m=2, n=2).compacton(speed=1).amplitude, 4)
    1.3333
    """

    m: float
    n: float
    absolute: bool = False

    variables = ("u",)
    two_way = False

    def __post_init__(self) -> None:
        check(self)
        for name, exponent in (("m", self.m), ("n", self.n)):
            require(exponent >= 1, f"RosenauHyman.{name} = {exponent:g} must be at least 1; K(2, 2) is the classic.")
            require(
                self.absolute or exponent == int(exponent),
                f"RosenauHyman.{name} = {exponent:g} must be a whole number in the classical form; set absolute=True for "
                "powers of |u|.",
            )

    def _power(self, exponent: float) -> PowerLaw:
        return PowerLaw(1, exponent, odd=True) if self.absolute else whole_power(1, exponent)

    @cached_property
    def flux(self) -> Flux:
        """The flux a = u^m, b = 1, g = u^n."""
        return Flux((self._power(self.m),), PowerLaw(1, 0), self._power(self.n))

    def compacton(self, speed: float, sign: int = 1) -> CosinePower:
        """The compacton of K(m, m): M = (2 c m / (m+1))^(1/(m-1)), K = (m-1)/(2m), gamma = 2/(m-1).

        Dark waves move to the left in the classical form with an even m, to the right otherwise.
        """
        m = self.m
        require(
            m == self.n and m > 1,
            f"Compactons of RosenauHyman are known to this program for m = n larger than 1 only, not for "
            f"m = {m:g}, n = {self.n:g}; "
            "choose m = n, or give the initial data as Samples.",
        )
        one_sided = not self.absolute and m % 2 == 0
        direction = sign if one_sided else 1
        require(
            speed * direction > 0,
            f"Compacton.speed = {speed:g} has the wrong sign for a {'bright' if sign > 0 else 'dark'} wave of "
            f"K({m:g}, {m:g}); it must be {'positive' if direction > 0 else 'negative'}.",
        )
        return CosinePower(sign * compacton_height(2 * abs(speed) * m / (m + 1), m), (m - 1) / (2 * m), 2 / (m - 1))

    def travelling_state(self, shape: CosinePower, z: NDArray[np.float64], speed: float) -> NDArray[np.float64]:
        """The state of a wave of this shape at the distances z from its centre, shape (1, N)."""
        return shape(z)[None]

    def check_center(self, center: float, grid: Any) -> None:
        """Any place on the periodic line will do."""

    def check_state(self, state: NDArray[np.float64]) -> None:
        """Any real state will do."""

    def invariants(self, state: NDArray[np.float64], spacing: float, second_difference: SecondDifference) -> dict[str, float]:
        """Mass and energy of a state of shape (1, N), as sums over the grid; nondimensional."""
        (u,) = state
        return {
            "mass": spacing * float(u.sum()),
            "energy": spacing * float(self.flux.g.antiderivative()(u).sum()),
        }


@dataclass(frozen=True)
class PowerLawEquation:
    r"""An equation of one's own with the flux F = a(u) + b(u) g(u)_xx of three power laws.

    .. math::  u_t + F_x = 0,   or in two-way form   u_t + v_x = 0,  v_t + F_x = 0

    Conserved: mass = Int u; where b = kappa g', also energy: for the one-way form H = -E, for the two-way form
    Int v^2 / 2 + E, with E = Int [A(u) - (kappa / 2) g_x^2] and A' = a. A two-way equation also
    conserves momentum = Int v.

    Parameters
    ----------
    a, b, g : PowerLaw
        The three laws.
    two_way : bool
        Which form.

    Examples
    --------
    >>> PowerLawEquation(a=PowerLaw(1, 2), b=PowerLaw(1, 0), g=PowerLaw(1, 1, odd=True)).variables  # Korteweg-de Vries
    ('u',)
    """

    a: PowerLaw
    b: PowerLaw
    g: PowerLaw
    two_way: bool = False

    def __post_init__(self) -> None:
        check(self)
        for name in ("a", "b", "g"):
            exponent = getattr(self, name).exponent
            require(exponent >= 0, f"PowerLawEquation.{name} has the exponent {exponent:g}; it must not be negative.")

    @property
    def variables(self) -> tuple[str, ...]:
        """The names of the components."""
        return ("u", "v") if self.two_way else ("u",)

    @cached_property
    def flux(self) -> Flux:
        """The flux."""
        return Flux((self.a,), self.b, self.g)

    def compacton(self, speed: float, sign: int = 1) -> CosinePower:
        """Refused: there is no closed form for an arbitrary flux."""
        raise InputError("A PowerLawEquation has no compacton of closed form; give the initial data as Samples.")

    def travelling_state(self, shape: CosinePower, z: NDArray[np.float64], speed: float) -> NDArray[np.float64]:
        """The state of a wave of this shape and speed, shape (components, N)."""
        profile = shape(z)
        return np.array([profile, speed * profile]) if self.two_way else profile[None]

    def check_center(self, center: float, grid: Any) -> None:
        """Any place on the periodic line will do."""

    def check_state(self, state: NDArray[np.float64]) -> None:
        """Any real state will do."""

    def invariants(self, state: NDArray[np.float64], spacing: float, second_difference: SecondDifference) -> dict[str, float]:
        """Mass, and momentum and energy where they are conserved, as sums over the grid; nondimensional."""
        u = state[0]
        result = {"mass": spacing * float(u.sum())}
        if self.two_way:
            result["momentum"] = spacing * float(state[1].sum())
        if self.flux.variational_constant is not None:
            energy = float(self.flux.energy_density(u, second_difference(self.flux.g(u))).sum())
            result["energy"] = spacing * (energy + 0.5 * float(state[1] @ state[1]) if self.two_way else -energy)
        return result
