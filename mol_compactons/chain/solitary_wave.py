"""The exact solitary wave of the granular chain as initial data, for any exponent; see `mol_compactons.chain.profile`."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mol_compactons.chain.chain import GranularChain
from mol_compactons.chain.law import PowerContact
from mol_compactons.chain.profile import FASTEST, SLOWEST, SolitaryProfile, profile_of_speed
from mol_compactons.equations.base import Equation
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.waves.base import LocalizedWave

Array = NDArray[np.float64]


def solitary_profile(chain: GranularChain, speed: float, sign: int = 1) -> SolitaryProfile:
    """The solitary wave of a chain of equal grains at a given speed.

    Parameters
    ----------
    chain : GranularChain
        Equal masses and contacts.
    speed : float
        |V|, above the speed of sound of the chain.
    sign : {1, -1}
        Compression or rarefaction; the profile itself is that of |R|.

    Raises
    ------
    InputError
        If the chain has no such wave.

    Examples
    --------
    >>> profile = solitary_profile(GranularChain(PowerContact(n=3)), speed=1)
    >>> round(profile.kinetic_energy / (profile.kinetic_energy + profile.potential_energy), 9)  # (n+1) / (n+3)
    0.666666667
    """
    require(
        SLOWEST <= abs(speed) <= FASTEST,
        f"SolitaryWave.speed = {speed:g} must lie between {SLOWEST:g} and {FASTEST:g} to either side.",
    )
    law = chain.law
    if not isinstance(law, PowerContact):
        raise InputError(
            f"The exact solitary wave is known to this program for PowerContact, not for {type(law).__name__}; give the "
            "initial data as a Formula or as Samples."
        )
    require(not chain.masses and not chain.strengths, "The exact solitary wave is that of a chain of equal grains.")
    chain.check_sign(sign)
    require(
        sign > 0 or chain.compression == 0,
        "A compressed chain has no exact solitary wave of rarefaction known to this program; set compression=0.",
    )
    static = float(chain.static_stress(1)[0]) if chain.compression else 0.0
    return profile_of_speed(law.n, law.strength, law.linear, static, abs(speed))


@dataclass(frozen=True)
class SolitaryWave(LocalizedWave):
    """The exact solitary wave of a chain of equal grains, as initial data.

    Parameters
    ----------
    speed : float
        V, positive to the right and negative to the left, faster than sound. Without a linear term V^2 = A r^(n-1) for waves
        r times as high as that of V^2 = A.
    center : float
        Where its centre is at t = 0, a coordinate on the lattice.
    sign : {1, -1}
        Compression or rarefaction.

    Raises
    ------
    InputError
        If the equation is no chain, or has no such wave.
    """

    speed: float
    center: float
    sign: int = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.sign in (1, -1), f"SolitaryWave.sign = {self.sign} must be 1 for compression or -1 for rarefaction.")

    def profile(self, equation: Equation) -> SolitaryProfile:
        """Its profile."""
        if not isinstance(equation, GranularChain):
            raise InputError(f"SolitaryWave is a wave of GranularChain, not of {type(equation).__name__}; choose Compacton.")
        return solitary_profile(equation, self.speed, self.sign)

    def outline(self, equation: Equation) -> tuple[float, float]:
        """Its signed height and its width."""
        profile = self.profile(equation)
        return self.sign * profile.amplitude, profile.width

    def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> Array:
        """The wave at time t, shape (2, size)."""
        profile = self.profile(equation)
        center = self.center + self.speed * t
        toward = self.sign * math.copysign(1.0, self.speed)
        assert isinstance(equation, GranularChain)
        return np.asarray(
            equation.travelling_state(
                lambda z: self.sign * profile(z), grid.offset(center), self.speed, lambda z: toward * profile.velocity(z)
            )
        )

    def is_solution(self, equation: Equation) -> bool:
        """So it is on a ring; elsewhere it comes to an end."""
        return isinstance(equation, GranularChain) and equation.ends == "periodic"
