"""The scaling map between the pre-stressed physical chain, in (t, x, S), and the dimensionless equation, in (T, X, W)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import Settings
from mol_compactons.errors import require

Field = TypeVar("Field", float, NDArray[np.float64])


@dataclass(frozen=True)
class ScalingMap(Settings):
    r"""(t, x, S) <-> (T, X, W) for the pre-stressed Nesterenko equation and the granular compacton equation.

    .. math::
        \tau = \sqrt{\gamma a^{n+3}} t, \quad \bar T = a \tau / 2, \quad \xi = (x - \tau) / a, \quad S = a^{4/(n-1)} W,
        \quad T = (A / \gamma) L \bar T, \quad X = L \xi, \quad L = \sqrt{6 (n+1) / n}

    The exponent 4/(n-1) of a stands in place of the paper's 5, which balances the equation for n = 9/5 only. A compacton of
    speed c becomes one of the chain of the same shape, width pi a sqrt(n (n+1) / (6 (n-1)^2)).

    What the map neglects, and how much that is:

    - the term (a^2 / 4) S_{T T}, of the order a^2. A compacton of speed c maps to the speed c0 (1 + A a^2 c / (2 gamma)),
      where the pre-stressed equation itself has c0 sqrt(1 + A a^2 c / gamma): a relative error of (A a^2 c / gamma)^2 / 8,
      small where c << gamma / (A a^2);
    - the linear dispersion of the chain, (a^2 / 12) c0^2 S_xxxx, which the paper drops before it scales. In the scaled
      variables it would add W_xi_xi_xi / (12 a^2) to terms of the order A / gamma: for small a it is the LARGEST. The chain
      with its linear term therefore does not follow the granular compacton equation; the chain without one follows
      Nesterenko's equation, whose waves move at sqrt(c A), not at c.

    Parameters
    ----------
    n : float
        The exponent of the force, larger than 1.
    strength : float
        The coefficient A > 0 of the force.
    grain_distance : float
        The distance a > 0 between the grains.
    prestress : float
        The coefficient gamma > 0 of the linear part.

    Raises
    ------
    InputError
        If a parameter is out of range.

    Notes
    -----
    Source: Vladimirov and Skurativskyi (2015), section 2, with its exponent r corrected.

    Examples
    --------
    >>> round(ScalingMap(n=1.5).width(), 3)
    4.967
    """

    n: float
    strength: float = 1.0
    grain_distance: float = 1.0
    prestress: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.n > 1, f"ScalingMap.n = {self.n:g} must be larger than 1; the Hertz contact has n = 1.5.")
        for name in ("strength", "grain_distance", "prestress"):
            require(getattr(self, name) > 0, f"ScalingMap.{name} = {getattr(self, name):g} must be positive; 1 is usual.")

    @property
    def sound_speed(self) -> float:
        """c0 = sqrt(gamma a^(n+3))."""
        return math.sqrt(self.prestress * self.grain_distance ** (self.n + 3))

    @property
    def length_factor(self) -> float:
        """L = sqrt(6 (n+1) / n)."""
        return math.sqrt(6 * (self.n + 1) / self.n)

    @property
    def stress_factor(self) -> float:
        """S / W = a^(4/(n-1))."""
        return float(self.grain_distance ** (4 / (self.n - 1)))

    @property
    def time_factor(self) -> float:
        """T / tau = (A / gamma) L a / 2."""
        return self.strength / self.prestress * self.length_factor * self.grain_distance / 2

    def to_dimensionless(self, t: Field, x: Field, stress: Field) -> tuple[Field, Field, Field]:
        """(T, X, W) of (t, x, S); numbers or arrays of one shape."""
        tau = self.sound_speed * t
        return (
            self.time_factor * tau,
            self.length_factor / self.grain_distance * (x - tau),
            stress / self.stress_factor,
        )

    def to_physical(self, time: Field, place: Field, amplitude: Field) -> tuple[Field, Field, Field]:
        """(t, x, S) of (T, X, W); the inverse of `to_dimensionless`."""
        tau = time / self.time_factor
        return (
            tau / self.sound_speed,
            self.grain_distance / self.length_factor * place + tau,
            self.stress_factor * amplitude,
        )

    def physical_speed(self, speed: float) -> float:
        """dx/dt of what moves at dX/dT = speed: c0 (1 + A a^2 c / (2 gamma))."""
        return self.sound_speed * (1 + self.strength * self.grain_distance**2 * speed / (2 * self.prestress))

    def width(self) -> float:
        """The width of every compacton in x, pi a sqrt(n (n+1) / (6 (n-1)^2)); 4.967 a for the Hertz contact."""
        return math.pi * self.grain_distance * math.sqrt(self.n * (self.n + 1) / 6) / (self.n - 1)
