"""The Rosenau-Hyman equations K(m, n), the first that compactons were found in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from mol_compactons.equations.base import Array, CosinePower, Equation, SecondDifference, check_exponent, compacton_height
from mol_compactons.equations.flux import Flux, PowerLaw, whole_power
from mol_compactons.errors import require


@dataclass(frozen=True)
class RosenauHyman(Equation):
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
    long_names: ClassVar[Mapping[str, str]] = {
        "u": "amplitude",
        "energy": "energy, the integral of the antiderivative of u^n",
    }
    reference = (
        "Rosenau, P., and Hyman, J. M. (1993): Compactons: solitons with finite wavelength, doi:10.1103/PhysRevLett.70.564"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, exponent in (("m", self.m), ("n", self.n)):
            require(exponent >= 1, f"RosenauHyman.{name} = {exponent:g} must be at least 1; K(2, 2) is the classic.")
            check_exponent(f"RosenauHyman.{name}", exponent)
            require(
                self.absolute or exponent == int(exponent),
                f"RosenauHyman.{name} = {exponent:g} must be a whole number in the classical form; set absolute=True for "
                "powers of |u|.",
            )

    def _power(self, exponent: float) -> PowerLaw:
        return PowerLaw(1, exponent, odd=True) if self.absolute else whole_power(1, exponent)

    @cached_property
    def dispersive_flux(self) -> Flux:
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

    @property
    def is_odd(self) -> bool:
        """Whether the mirror image -u of a solution is one, so that waves of both signs move the same way."""
        return self.absolute or (self.m % 2 == 1 and self.n % 2 == 1)

    def compacton_speed(self, height: float) -> float | None:
        """C = (m+1) M^(m-1) / (2m), for m = n."""
        m = self.m
        return float((m + 1) * height ** (m - 1) / (2 * m)) if m == self.n and m > 1 else None

    def densities(self, state: Array, second_difference: SecondDifference) -> dict[str, Array]:
        """Those of mass and energy, of a state of shape (1, N)."""
        (u,) = state
        return {"mass": u, "energy": self.dispersive_flux.g.antiderivative()(u)}
