"""Simple shapes: a background, and a ripple on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mol_compactons.equations.base import Equation
from mol_compactons.errors import require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.waves.base import Array, Wave


@dataclass(frozen=True)
class Uniform(Wave):
    """A uniform background; the second component of a two-way equation is zero.

    Parameters
    ----------
    value : float
        The value of the first component, nondimensional.
    """

    value: float

    def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> Array:
        """The background, shape (components, size)."""
        state = np.zeros((len(equation.variables), grid.size))
        state[0] = self.value
        return state


@dataclass(frozen=True)
class Ripple(Wave):
    """A cosine in the first component, amplitude cos(2 pi periods (x - left) / length), to be put on a background.

    Parameters
    ----------
    amplitude : float
        Nondimensional.
    periods : int
        The number of periods on the grid, at least 1.

    Raises
    ------
    InputError
        If the number of periods is less than 1, or more than the grid can hold.
    """

    amplitude: float
    periods: int

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.periods >= 1, f"Ripple.periods = {self.periods} must be at least 1.")

    def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> Array:
        """The cosine, shape (components, size)."""
        require(
            2 * self.periods <= grid.size,
            f"Ripple.periods = {self.periods} needs at least {2 * self.periods} grid points; grid.size = {grid.size}.",
        )
        state = np.zeros((len(equation.variables), grid.size))
        state[0] = self.amplitude * np.cos(2 * np.pi * self.periods * np.arange(grid.size) / grid.size)
        return state
