"""A blow on a chain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mol_compactons.chain.chain import GranularChain
from mol_compactons.equations.base import Equation
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.waves.base import Array, Wave


@dataclass(frozen=True)
class Impact(Wave):
    """A velocity of some grains of a chain in displacements, at rest otherwise: a hammer's blow.

    Parameters
    ----------
    velocity : float
        The velocity, nondimensional.
    first : int
        The number of the first grain that moves, from 0.
    grains : int
        How many move.

    Raises
    ------
    InputError
        If the equation is no chain in displacements, or has not so many grains.
    """

    velocity: float
    first: int = 0
    grains: int = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        require(
            self.first >= 0 and self.grains >= 1,
            f"Impact.first = {self.first} must not be negative, and Impact.grains = {self.grains} must be at least 1.",
        )

    def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> Array:
        """The momenta, shape (2, size)."""
        if not (isinstance(equation, GranularChain) and equation.form == "displacements"):
            raise InputError("Impact moves the grains of a GranularChain in displacements; set form='displacements'.")
        last = self.first + self.grains
        require(last <= grid.size, f"Impact moves the grains up to number {last - 1}, but the chain has {grid.size}.")
        state = np.zeros((2, grid.size))
        state[1, self.first : last] = self.velocity / equation.inverse_masses(grid.size)[self.first : last]
        return state
