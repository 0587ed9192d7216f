"""Nesterenko's two-way equation for the continuum of a granular chain."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from mol_compactons.equations.base import Array, CosinePower, Equation, SecondDifference, check_exponent, compacton_height
from mol_compactons.equations.flux import Flux, PowerLaw, contact_flux
from mol_compactons.errors import require

REFERENCE = "Nesterenko, V. F. (1983): Propagation of nonlinear compression pulses in granular media, doi:10.1007/BF00905892"


@dataclass(frozen=True)
class Nesterenko(Equation):
    r"""Nesterenko's two-way equation for the stress S of a chain of grains, with or without pre-stress.

    .. math::
        S_{tt} = C \{ S^n + \beta S^{(n-1)/2} (S^{(n+1)/2})_{xx} \}_{xx} + c_0^2 S_{xx},

    solved as the system of conservation laws S_t = -v_x, v_t = -F_x with the velocity v of the grains. C = A a^(n+1),
    beta = n a^2 / (6 (n+1)) and c0^2 = gamma a^(n+3). The displacements u, with S = -u_x and v = u_t, solve
    u_tt = -F[-u_x]_x; see `displacements`.

    Conserved: mass = Int S, momentum = Int v and
    energy = Int [v^2 / 2 + C S^(n+1) / (n+1) + c0^2 S^2 / 2 - C beta ((S^((n+1)/2))_x)^2 / (n+1)].

    **The equation is ill-posed.** About a state S0 waves of wavenumber k have omega^2 = C S0^(n-1) n k^2 (1 - a^2 k^2 / 12) +
    c0^2 k^2, which without pre-stress is negative beyond k^2 = 12 / a^2, and the growth rate rises like k^2 without bound:
    the finer the grid, the faster any non-zero state breaks up. The chain itself has a sine in place of the polynomial,
    and is stable.

    Parameters
    ----------
    n : float
        The exponent of the force, larger than 1.
    strength : float
        The coefficient A > 0 of the force.
    grain_distance : float
        The distance a > 0 between the grains.
    prestress : float
        The coefficient gamma >= 0 of the linear part; 0 for sonic vacuum.

    Raises
    ------
    InputError
        If a parameter is out of range; for dark waves unless n is an odd whole number.

    Notes
    -----
    All quantities are nondimensional. The flux is continued to S < 0 as an odd function. Source: Nesterenko, J. Appl. Mech.
    Tech. Phys. 24 (1983) 733, doi:10.1007/BF00905892; Vladimirov and Skurativskyi (2015), equations (EqNest) and (EqNest2).

    Examples
    --------
    >>> Nesterenko(n=3).compacton(speed=1).amplitude
    1.4142135623730951
    """

    n: float
    strength: float = 1.0
    grain_distance: float = 1.0
    prestress: float = 0.0

    variables = ("S", "v")
    long_names: ClassVar[Mapping[str, str]] = {
        "S": "stress",
        "v": "velocity of the grains",
        "momentum": "momentum, the integral of the velocity",
        "energy": "energy, with the second difference of the scheme",
    }
    reference = REFERENCE
    two_way = True

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.n > 1, f"Nesterenko.n = {self.n:g} must be larger than 1; the Hertz contact has n = 1.5.")
        check_exponent("Nesterenko.n", self.n)
        require(self.strength > 0, f"Nesterenko.strength = {self.strength:g} must be positive; 1 is usual.")
        require(self.grain_distance > 0, f"Nesterenko.grain_distance = {self.grain_distance:g} must be positive; 1 is usual.")
        require(self.prestress >= 0, f"Nesterenko.prestress = {self.prestress:g} must not be negative; 0 is none.")

    @property
    def stiffness(self) -> float:
        """C = A a^(n+1)."""
        return float(self.strength * self.grain_distance ** (self.n + 1))

    @property
    def dispersion(self) -> float:
        """Beta = n a^2 / (6 (n+1))."""
        return self.n * self.grain_distance**2 / (6 * (self.n + 1))

    @property
    def sound_speed(self) -> float:
        """c0 = sqrt(gamma a^(n+3)), the speed of linear waves at zero stress."""
        return math.sqrt(self.prestress * self.grain_distance ** (self.n + 3))

    @cached_property
    def dispersive_flux(self) -> Flux:
        """The flux a = C S^n + c0^2 S, b = C beta S^((n-1)/2), g = S^((n+1)/2), odd in S."""
        contact = contact_flux(self.n, self.stiffness, self.dispersion)
        if not self.prestress:
            return contact
        return Flux((*contact.a, PowerLaw(self.sound_speed**2, 1, odd=True)), contact.b, contact.g)

    def compacton(self, speed: float, sign: int = 1) -> CosinePower:
        """The compacton of speed V, |V| > c0: V^2 = c0^2 + 2 C |M|^(n-1) / (n+1), K = (n-1) / ((n+1) sqrt(beta))."""
        n = self.n
        require(
            abs(speed) > self.sound_speed,
            f"Compacton.speed = {speed:g} is not faster than sound, {self.sound_speed:.4g}; compactons of Nesterenko's "
            "equation are supersonic, to either side.",
        )
        height = compacton_height(
            (abs(speed) - self.sound_speed) * (abs(speed) + self.sound_speed) * (n + 1) / (2 * self.stiffness), n
        )
        return CosinePower(sign * height, (n - 1) / (n + 1) / math.sqrt(self.dispersion), 2 / (n - 1))

    def compacton_speed(self, height: float) -> float:
        """V = sqrt(c0^2 + 2 C M^(n-1) / (n+1)), to either side."""
        return math.hypot(self.sound_speed, math.sqrt(2 * self.stiffness * height ** (self.n - 1) / (self.n + 1)))

    def travelling_state(self, shape: Any, z: Array, speed: float) -> Array:
        """S and v = V S of a wave, shape (2, N); a dark one only for an odd whole n, since grains in tension have no force."""
        state = super().travelling_state(shape, z, speed)
        lowest = float(state[0].min())
        require(
            lowest >= 0 or self.n % 2 == 1,
            f"The stress of the wave goes down to {lowest:.4g}, but Nesterenko's equation with n = {self.n:g} has waves with "
            "S >= 0; use bright waves, or an odd whole n.",
        )
        return state

    def frequency_squared(self, wavenumber: float, stress: float) -> float:
        """omega^2 of small waves about a uniform stress; negative where they grow, at the rate sqrt(-omega^2)."""
        stiffness = self.stiffness * abs(stress) ** (self.n - 1) * self.n
        dispersive = 1 - (self.grain_distance * wavenumber) ** 2 / 12
        return float(wavenumber**2 * (stiffness * dispersive + self.sound_speed**2))

    def fastest_growth(self, state: Array, spacing: float) -> float:
        """The growth rate sqrt(-omega^2) at the shortest wave number of the grid, pi / h, about the largest stress."""
        return math.sqrt(max(0.0, -self.frequency_squared(math.pi / spacing, float(np.abs(state[0]).max()))))

    def densities(self, state: Array, second_difference: SecondDifference) -> dict[str, Array]:
        """Those of mass, momentum and energy, of a state of shape (2, N)."""
        stress, velocity = state
        stored = self.dispersive_flux.energy_parts(stress, second_difference(self.dispersive_flux.g(stress)))
        return super().densities(state, second_difference) | {"energy": np.array([*stored, 0.5 * velocity**2])}
