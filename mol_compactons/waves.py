"""Exact waves, bright and dark, as functions of (x, t) on a grid, and their superposition."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import check
from mol_compactons.equations import CosinePower
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid, Lattice, ring_distance


class CompactonEquation(Protocol):
    """An equation that has compactons."""

    @property
    def variables(self) -> tuple[str, ...]:
        """The names of the components."""

    def compacton(self, speed: float, sign: int = 1) -> CosinePower:
        """The shape of the compacton of a given speed and sign."""

    def travelling_state(self, shape: CosinePower, z: NDArray[np.float64], speed: float) -> NDArray[np.float64]:
        """The state of a wave of a given shape and speed at the distances z from its centre."""

    def check_center(self, center: float, grid: Any) -> None:
        """Refuse a wave beyond the ends, where there are any."""

    def check_state(self, state: NDArray[np.float64]) -> None:
        """Refuse a state that the equation has no meaning for."""


class Wave(Protocol):
    """Something that initial data can be made of."""

    def values(self, equation: Any, grid: Grid | Lattice, t: float = 0.0) -> NDArray[np.float64]:
        """The wave at time t, shape (components, size)."""


@runtime_checkable
class LocalizedWave(Wave, Protocol):
    """A wave with a place, a speed, a sign and a width."""

    @property
    def speed(self) -> float:
        """Its speed."""

    @property
    def center(self) -> float:
        """Where its centre is at t = 0."""

    @property
    def sign(self) -> int:
        """1 for a bright one, -1 for a dark one."""

    def outline(self, equation: Any) -> tuple[float, float]:
        """Its signed height and its width."""


@dataclass(frozen=True)
class Impact:
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
        check(self)
        require(
            self.first >= 0 and self.grains >= 1,
            f"Impact.first = {self.first} must not be negative, and Impact.grains = {self.grains} must be at least 1.",
        )

    def values(self, equation: Any, grid: Grid | Lattice, t: float = 0.0) -> NDArray[np.float64]:
        """The momenta, shape (2, size)."""
        require(
            equation.variables == ("Q", "p"),
            "Impact moves the grains of a GranularChain in displacements; set form='displacements'.",
        )
        last = self.first + self.grains
        require(last <= grid.size, f"Impact moves the grains up to number {last - 1}, but the chain has {grid.size}.")
        state = np.zeros((2, grid.size))
        state[1, self.first : last] = self.velocity / equation.inverse_masses(grid.size)[self.first : last]
        return state


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
        shape, center = equation.compacton(self.speed, self.sign), self.center + self.speed * t
        return equation.travelling_state(shape, grid.offset(center), self.speed)

    def outline(self, equation: CompactonEquation) -> tuple[float, float]:
        """Its signed height and its width."""
        shape = equation.compacton(self.speed, self.sign)
        return shape.amplitude, shape.width


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
    localized = [wave for wave in waves if isinstance(wave, LocalizedWave)]
    widths = [wave.outline(equation)[1] for wave in localized]
    for wave, width in zip(localized, widths, strict=True):
        equation.check_center(wave.center, grid)
        require(
            width < grid.length,
            f"The {type(wave).__name__} at center = {wave.center:g} is {width:.4g} wide and does not fit in the box of "
            f"length {grid.length:g}; choose one longer than {width:.4g}.",
        )
    for index, (wave, width) in enumerate(zip(localized, widths, strict=True)):
        for other, other_width in zip(localized[:index], widths[:index], strict=True):
            distance = abs(float(ring_distance(np.array(wave.center), other.center, grid.length)))
            needed = (width + other_width) / 2
            if distance < needed * (1 - 1e-12):
                raise InputError(
                    f"The waves at center = {other.center:g} and {wave.center:g} overlap: their centres are "
                    f"{distance:.4g} apart; put them at least {needed:.4g} apart."
                )
    state = np.asarray(sum(wave.values(equation, grid) for wave in waves))
    equation.check_state(state)
    return state
