"""The exact compactons, bright and dark."""

from __future__ import annotations

from dataclasses import dataclass

from mol_compactons.equations.base import Equation
from mol_compactons.errors import require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.waves.base import Array, LocalizedWave


@dataclass(frozen=True)
class Compacton(LocalizedWave):
    """The exact compacton of the equation, sign M cos^gamma(K (x - center - speed t)) on its support.

    Parameters
    ----------
    speed : float
        The speed c, nondimensional.
    center : float
        Where its centre is at t = 0, nondimensional.
    sign : {1, -1}
        1 for a bright one (compression), -1 for a dark one (rarefaction).

    Raises
    ------
    InputError
        If the sign is neither 1 nor -1, or the equation has no compacton of this speed.
    """

    speed: float
    center: float
    sign: int = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.sign in (1, -1), f"Compacton.sign = {self.sign} must be 1 for a bright wave or -1 for a dark one.")

    def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> Array:
        """The wave at time t, shape (components, size)."""
        shape, center = equation.compacton(self.speed, self.sign), self.center + self.speed * t
        return equation.travelling_state(shape, grid.offset(center), self.speed)

    def outline(self, equation: Equation) -> tuple[float, float]:
        """Its signed height and its width."""
        shape = equation.compacton(self.speed, self.sign)
        return shape.amplitude, shape.width

    def is_solution(self, equation: Equation) -> bool:
        """So it is where the equation is one of a line: a chain has other exact waves."""
        return equation.has_local_flux
