"""Exact waves, bright and dark, as functions of (x, t) on a grid, and their superposition."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import check
from mol_compactons.equations import CosinePower
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid, Lattice


class CompactonEquation(Protocol):
    """An equation that has compactons."""

    @property
    def variables(self) -> tuple[str, ...]:
        """The names of the components."""

    def compacton(self, speed: float, sign: int = 1) -> CosinePower:
        """The shape of the compacton of a given speed and sign."""

    def travelling_state(self, shape: CosinePower, z: NDArray[np.float64], speed: float) -> NDArray[np.float64]:
        """The state of a wave of a given shape and speed at the distances z from its centre."""

    def check_state(self, state: NDArray[np.float64]) -> None:
        """Refuse a state that the equation has no meaning for."""


class Wave(Protocol):
    """Something that initial data can be made of."""

    def values(self, equation: Any, grid: Grid | Lattice, t: float = 0.0) -> NDArray[np.float64]:
        """The wave at time t, shape (components, size)."""


@dataclass(frozen=True)
class Compacton:
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
        check(self)
        require(self.sign in (1, -1), f"Compacton.sign = {self.sign} must be 1 for a bright wave or -1 for a dark one.")

    def values(self, equation: CompactonEquation, grid: Grid | Lattice, t: float = 0.0) -> NDArray[np.float64]:
        """The wave at time t, shape (components, size)."""
        shape = equation.compacton(self.speed, self.sign)
        return equation.travelling_state(shape, grid.offset(self.center + self.speed * t), self.speed)


@dataclass(frozen=True)
class Samples:
    """Any data on the grid, as numbers.

    Parameters
    ----------
    values_at_points : tuple of float
        One number for each grid point; for an equation with two components those of the first and then those of the
        second.

    Raises
    ------
    InputError
        If a number is NaN or infinite, or their count does not fit the grid.
    """

    values_at_points: tuple[float, ...]

    def __post_init__(self) -> None:
        check(self)

    def values(self, equation: CompactonEquation, grid: Grid | Lattice, t: float = 0.0) -> NDArray[np.float64]:
        """The data, shape (components, size)."""
        shape = (len(equation.variables), grid.size)
        count = len(self.values_at_points)
        require(
            count == shape[0] * shape[1],
            f"Samples holds {count} numbers, but the grid has {grid.size} points and the equation {shape[0]} "
            f"component(s); give {shape[0] * shape[1]} numbers.",
        )
        return np.reshape(self.values_at_points, shape)


@dataclass(frozen=True)
class Uniform:
    """A uniform background; the second component of a two-way equation is zero.

    Parameters
    ----------
    value : float
        The value of the first component, nondimensional.
    """

    value: float

    def __post_init__(self) -> None:
        check(self)

    def values(self, equation: CompactonEquation, grid: Grid | Lattice, t: float = 0.0) -> NDArray[np.float64]:
        """The background, shape (components, size)."""
        state = np.zeros((len(equation.variables), grid.size))
        state[0] = self.value
        return state


@dataclass(frozen=True)
class Ripple:
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
        check(self)
        require(self.periods >= 1, f"Ripple.periods = {self.periods} must be at least 1.")

    def values(self, equation: CompactonEquation, grid: Grid | Lattice, t: float = 0.0) -> NDArray[np.float64]:
        """The cosine, shape (components, size)."""
        require(
            2 * self.periods <= grid.size,
            f"Ripple.periods = {self.periods} needs at least {2 * self.periods} grid points; grid.size = {grid.size}.",
        )
        state = np.zeros((len(equation.variables), grid.size))
        state[0] = self.amplitude * np.cos(2 * np.pi * self.periods * np.arange(grid.size) / grid.size)
        return state


def superpose(waves: Sequence[Wave], equation: CompactonEquation, grid: Grid | Lattice) -> NDArray[np.float64]:
    """The sum of waves at t = 0, shape (components, size).

    Raises
    ------
    InputError
        If there is no wave, a support is longer than the box, or two supports overlap.
    """
    require(len(waves) > 0, "initial = [] holds no wave; give at least one.")
    compactons = [wave for wave in waves if isinstance(wave, Compacton)]
    widths = [equation.compacton(wave.speed, wave.sign).width for wave in compactons]
    for wave, width in zip(compactons, widths, strict=True):
        require(
            width < grid.length,
            f"The compacton at center = {wave.center:g} is {width:.4g} wide and does not fit in the box of "
            f"length {grid.length:g}; choose grid.length larger than {width:.4g}.",
        )
    for index, (wave, width) in enumerate(zip(compactons, widths, strict=True)):
        for other, other_width in zip(compactons[:index], widths[:index], strict=True):
            half = grid.length / 2
            distance = abs((wave.center - other.center + half) % grid.length - half)
            needed = (width + other_width) / 2
            if distance < needed * (1 - 1e-12):
                raise InputError(
                    f"The compactons at center = {other.center:g} and {wave.center:g} overlap: their centres are "
                    f"{distance:.4g} apart on the periodic line; put them at least {needed:.4g} apart."
                )
    state = np.asarray(sum(wave.values(equation, grid) for wave in waves))
    equation.check_state(state)
    return state
