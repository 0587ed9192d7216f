"""The place and the height of a wave by a fit of the exact profile, and how far it is from that profile."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mol_compactons.equations.base import Equation, SolitaryShape
from mol_compactons.grid import Grid, Lattice, ring_distance

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

FEWEST_POINTS = 4
"""Points without which a misfit says nothing about two parameters; a wave of a chain with n = 3 has as many."""

LEAST_SHARE = 0.5
"""The part of the points of a wave that must be clear of other waves."""

ROUNDS, STEPS, HALVINGS = 8, 40, 4
"""How often the points are chosen anew, how many steps are made with the same, and how often one is halved."""

RESOLUTION = 1e-7
"""A step below this, relative to the width and the height, is the last: on an exact wave the error after it is the square."""

FOREIGN, COARSE_RESOLUTION = 0.1, 1e-2
"""What is farther than this from every wave, relative to its own norm, is none; its search ends at a larger step."""

DIFFERENCE = 1e-6
"""The relative change of the height by which the derivative is taken."""

SINGULAR = 1e-12
"""Below this part of its largest possible value the determinant of the normal equations is round-off."""

LONGEST_STEP = 0.25
"""The most that a step may move a wave, in widths, and change the logarithm of its height."""


@dataclass(frozen=True)
class Fit:
    """The exact wave nearest to a profile.

    Parameters
    ----------
    position : float
        Its centre.
    height : float
        Its height, positive.
    residual : float
        The L2 norm of what is left, relative to that of the exact wave, both on the points of the fit.
    shape : SolitaryShape
        The exact wave.
    """

    position: float
    height: float
    residual: float
    shape: SolitaryShape


def fit(
    values: Array,
    grid: Grid | Lattice,
    equation: Equation,
    sign: int,
    position: float,
    height: float,
    excluded: Mask | None = None,
) -> Fit | None:
    """Fit the solitary wave of an equation to a profile, by least squares over its core.

    The least sum of (u_j - S(x_j - X; M))^2 over the centre X and the height M by Gauss and Newton, with halved steps where a
    whole one does not help. The points are those in the core of the shape, chosen again for the wave that was found. Of the
    exact samples of a wave, wherever it stands between the points, place and height come out to round-off for compactons
    of any exponent, since the core leaves out the edge with its kink or cusp, and to 1e-9 of the height for chains.

    Parameters
    ----------
    values : array, shape (N,)
        A field on a periodic grid.
    grid : Grid or Lattice
        The grid.
    equation : Equation
        Whose waves.
    sign : {1, -1}
        Bright or dark.
    position, height : float
        Where to begin; the height is positive.
    excluded : array of bool, shape (N,), optional
        Points that belong to other waves.

    Returns
    -------
    Fit or None
        None where no such wave is known, where too few points are clear, or where the search leaves the peak.
    """
    coordinates, length = grid.coordinates, grid.length
    allowed = np.ones(grid.size, dtype=bool) if excluded is None else ~excluded
    place, logarithm, chosen = position, math.log(height), None
    for _ in range(ROUNDS):
        shape = equation.solitary_shape(math.exp(logarithm), sign)
        if shape is None:
            return None
        core = np.abs(ring_distance(coordinates, place, length)) <= shape.core / 2
        before, chosen = chosen, np.flatnonzero(core & allowed)
        if chosen.size < max(FEWEST_POINTS, LEAST_SHARE * np.count_nonzero(core)):
            return None
        if before is not None and np.array_equal(before, chosen):
            break
        points = _Points(values[chosen], coordinates[chosen], length, equation, sign)
        place, logarithm = points.descend(place, logarithm)
        if abs(place - position) > shape.width / 2 or abs(logarithm - math.log(height)) > 1:
            return None
    shape = equation.solitary_shape(math.exp(logarithm), sign)
    return None if shape is None else Fit(place, math.exp(logarithm), points.misfit(shape, place), shape)


@dataclass(frozen=True, eq=False)
class _Points:
    """The points of a fit: values and coordinates, on a ring of a length, and the wave that is fitted to them."""

    values: Array
    coordinates: Array
    length: float
    equation: Equation
    sign: int

    def misfit(self, shape: SolitaryShape, place: float) -> float:
        """What a wave leaves, relative to it."""
        exact = shape(ring_distance(self.coordinates, place, self.length))
        return float(np.linalg.norm(self.values - exact) / np.linalg.norm(exact))

    def descend(self, place: float, logarithm: float) -> tuple[float, float]:
        """Centre and logarithm of the height with the least sum of squares."""
        left, jacobian, width = self._linearized(place, logarithm)
        for _ in range(STEPS):
            normal = jacobian @ jacobian.T
            determinant = normal[0, 0] * normal[1, 1] - normal[0, 1] ** 2
            if not determinant > SINGULAR * normal[0, 0] * normal[1, 1]:
                break
            step = np.array([[normal[1, 1], -normal[0, 1]], [-normal[0, 1], normal[0, 0]]]) @ (jacobian @ left) / determinant
            step *= min(1.0, LONGEST_STEP / max(float(np.abs(step).max()), 1e-300))
            for _ in range(HALVINGS):
                tried = place + float(step[0]) * width, logarithm + float(step[1])
                found = self._linearized(*tried)
                if found[0] @ found[0] < left @ left:
                    break
                step /= 2
            else:
                break
            (place, logarithm), (left, jacobian, width) = tried, found
            foreign = left @ left > FOREIGN**2 * (self.values @ self.values)
            if float(np.abs(step).max()) < (COARSE_RESOLUTION if foreign else RESOLUTION):
                break
        return place, logarithm

    def _linearized(self, place: float, logarithm: float) -> tuple[Array, Array, float]:
        """What a wave leaves, the derivatives of the wave by the centre in widths and by the logarithm, and its width."""
        z = ring_distance(self.coordinates, place, self.length)
        shape, upper = (self.equation.solitary_shape(math.exp(one), self.sign) for one in (logarithm, logarithm + DIFFERENCE))
        if shape is None or upper is None:
            return np.full(z.size, np.inf), np.zeros((2, z.size)), 1.0
        profile = shape(z)
        by_height = (upper(z) - profile) / DIFFERENCE
        return self.values - profile, np.stack([-shape.width * shape.slope(z), by_height]), shape.width
