"""What initial data are to the rest of the program, and their superposition."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import Settings
from mol_compactons.equations.base import Equation
from mol_compactons.errors import InputError, require
from mol_compactons.grid import LARGEST_SIZE, Grid, Lattice, ring_distance

Array = NDArray[np.float64]

FARTHEST = 1e9
"""The largest distance of a centre from the origin; farther out numbers are too coarse for the points of a grid."""

FEWEST_POINTS = 2
"""Points in the support of a wave below which a grid shows no wave; `check_up` asks for more."""


class Wave(Settings):
    """Something that initial data can be made of. A subclass is a frozen dataclass; it has to give `values`."""

    @abstractmethod
    def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> Array:
        """The wave at time t, shape (components, size).

        Parameters
        ----------
        equation : Equation
            What is solved.
        grid : Grid or Lattice
            Where.
        t : float
            The time, for waves that are known at all times.

        Raises
        ------
        InputError
            If it is no wave of the equation, or does not fit in the grid.
        """

    def is_solution(self, equation: Equation) -> bool:
        """Whether this wave, alone in its box, solves the equation at all times, as `values` gives it."""
        return False


class LocalizedWave(Wave):
    """A wave with a place, a speed, a sign and a width; the fields of a subclass, which has to give `outline` too."""

    speed: float
    """Its speed."""

    center: float
    """Where its centre is at t = 0."""

    sign: int
    """1 for a bright one, -1 for a dark one."""

    @abstractmethod
    def outline(self, equation: Equation) -> tuple[float, float]:
        """Its signed height and its width."""


def superpose(waves: Sequence[Wave], equation: Equation, grid: Grid | Lattice) -> Array:
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
        check_center(wave, grid)
        equation.check_center(wave.center, grid)
        require(
            width < grid.length,
            f"The {type(wave).__name__} at center = {wave.center:g} is {width:.4g} wide and does not fit in the box of "
            f"length {grid.length:g}; choose one longer than {width:.4g}.",
        )
        _check_resolution(wave, width, grid)
    for index, (wave, width) in enumerate(zip(localized, widths, strict=True)):
        for other, other_width in zip(localized[:index], widths[:index], strict=True):
            distance = abs(float(ring_distance(np.array(wave.center), other.center, grid.length)))
            needed = (width + other_width) / 2
            if distance < needed * (1 - 1e-12):
                raise InputError(
                    f"The waves at center = {other.center:g} and {wave.center:g} overlap: their centres are "
                    f"{distance:.4g} apart; put them at least {needed:.4g} apart."
                )
    state = np.asarray(sum(_checked(wave, equation, grid) for wave in waves))
    equation.check_state(state)
    return state


def check_center(wave: Any, grid: Grid | Lattice) -> None:
    """Refuse a wave whose `center` is so far from the origin that its place on the ring is not known.

    Raises
    ------
    InputError
        If the centre is beyond `FARTHEST`.
    """
    require(
        abs(wave.center) <= FARTHEST,
        f"{type(wave).__name__}.center = {wave.center:g} must lie between -{FARTHEST:g} and {FARTHEST:g}; choose a place "
        f"in the box of length {grid.length:g}.",
    )


def _check_resolution(wave: Any, width: float, grid: Grid | Lattice) -> None:
    points = width / grid.spacing
    if not isinstance(grid, Grid) or points >= FEWEST_POINTS:
        return
    needed = FEWEST_POINTS * grid.length / width if width else math.inf
    advice = f"choose a grid.size of at least {math.ceil(needed)}" if needed <= LARGEST_SIZE else "choose a shorter box"
    raise InputError(
        f"The {type(wave).__name__} at center = {wave.center:g} is {width:.4g} wide and has {points:.2g} grid points in it, "
        f"but at least {FEWEST_POINTS} are needed; {advice}."
    )


def _checked(wave: Wave, equation: Equation, grid: Grid | Lattice) -> Array:
    """The values of a wave, of which a class of the user's own may make anything."""
    name, shape = type(wave).__name__, (len(equation.variables), grid.size)
    values = np.asarray(wave.values(equation, grid))
    require(
        values.shape == shape and values.dtype.kind in "fiu",
        f"{name}.values returned an array of shape {values.shape} and type {values.dtype}; return real numbers of shape "
        f"{shape}.",
    )
    require(bool(np.isfinite(values).all()), f"{name}.values returned NaN or infinity; return finite numbers.")
    return values.astype(np.float64, copy=False)
