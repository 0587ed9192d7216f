"""The place and the height of a wave by a fit of the exact profile, and how far it is from that profile."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.equations.base import Equation, SolitaryShape
from mol_compactons.grid import Grid, Lattice
from mol_compactons.results.reading import grid_of
from mol_compactons.results.schema import describe
from mol_compactons.simulation import Simulation

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

FEWEST_POINTS = 4
"""Points without which a misfit says nothing about two parameters; a wave of a chain with n = 3 has as many."""

LEAST_SHARE = 0.5
"""The part of the points of a wave that must be clear of other waves."""

ROUNDS, STEPS, HALVINGS = 8, 40, 4
"""How often the points are chosen anew, how many steps are made with the same, and how often one is halved."""

RESOLUTION = 1e-11
"""A step below this, relative to the width and the height, is the last."""

DIFFERENCE = 1e-4
"""The relative change of the height by which the derivative is taken; exact where the shape does not depend on the height."""

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
    allowed = np.ones(grid.size, dtype=bool) if excluded is None else ~excluded
    place, logarithm, points = position, math.log(height), None
    for _ in range(ROUNDS):
        shape = equation.solitary_shape(math.exp(logarithm), sign)
        if shape is None:
            return None
        core = np.abs(grid.offset(place)) <= shape.core / 2
        chosen = core & allowed
        if np.count_nonzero(chosen) < max(FEWEST_POINTS, LEAST_SHARE * np.count_nonzero(core)):
            return None
        if points is not None and np.array_equal(points, chosen):
            break
        points = chosen
        place, logarithm = _descend(values, grid, equation, sign, points, (place, logarithm))
        if abs(place - position) > shape.width / 2 or abs(logarithm - math.log(height)) > 1:
            return None
    shape = equation.solitary_shape(math.exp(logarithm), sign)
    if shape is None or points is None:
        return None
    exact = shape(grid.offset(place)[points])
    return Fit(place, math.exp(logarithm), float(np.linalg.norm(values[points] - exact) / np.linalg.norm(exact)), shape)


def fitted(dataset: xr.Dataset, tracks: xr.Dataset) -> xr.Dataset:
    """The tracks of a result with the places and heights of the exact waves that fit.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    tracks : xarray.Dataset
        What `track` returned of it, or a part of that along t.

    Returns
    -------
    xarray.Dataset
        The tracks with other ``position`` and ``height`` where a wave is isolated, and with ``residual`` (t, wave), that of
        `fit`; where nothing fits all three are NaN, and all stays as it is where a wave is not isolated.

    Raises
    ------
    InputError
        If a class of the simulation is not loaded.
    """
    equation = Simulation.from_json(str(dataset.attrs["simulation"])).equation
    grid = grid_of(dataset)
    frames = dataset[tracks.attrs["field"]].sel(t=tracks["t"]).transpose("t", grid.dimension).values
    position, height = tracks["position"].values.copy(), tracks["height"].values.copy()
    residual = np.full(position.shape, np.nan)
    for index in zip(*np.nonzero(tracks["isolated"].values), strict=True):
        sign, size = int(np.sign(height[index])), abs(float(height[index]))
        found = fit(frames[index[0]], grid, equation, sign, float(position[index]), size)
        position[index], height[index], residual[index] = (
            (found.position, sign * found.height, found.residual) if found else (np.nan,) * 3
        )
    along = tracks["position"].dims
    return tracks.assign(
        position=(along, position, tracks["position"].attrs),
        height=(along, height, tracks["height"].attrs),
        residual=(along, residual, describe("residual")),
    )


def _descend(
    values: Array, grid: Grid | Lattice, equation: Equation, sign: int, points: Mask, start: tuple[float, float]
) -> tuple[float, float]:
    """Centre and logarithm of the height with the least sum of squares on some points."""
    place, logarithm = start
    left, jacobian, width = _linearized(values, grid, equation, sign, points, place, logarithm)
    for _ in range(STEPS):
        scale = np.array([width, 1.0])
        step = np.linalg.lstsq(jacobian * scale, left, rcond=None)[0]
        step *= min(1.0, LONGEST_STEP / max(float(np.abs(step).max()), 1e-300))
        for _ in range(HALVINGS):
            tried = place + float(step[0]) * width, logarithm + float(step[1])
            found = _linearized(values, grid, equation, sign, points, *tried)
            if float(found[0] @ found[0]) < float(left @ left):
                break
            step /= 2
        else:
            break
        (place, logarithm), (left, jacobian, width) = tried, found
        if float(np.abs(step).max()) < RESOLUTION:
            break
    return place, logarithm


def _linearized(
    values: Array, grid: Grid | Lattice, equation: Equation, sign: int, points: Mask, place: float, logarithm: float
) -> tuple[Array, Array, float]:
    """What a wave leaves on the points, the derivatives of the wave by centre and logarithm of the height, and its width."""
    z = grid.offset(place)[points]
    shapes = [equation.solitary_shape(math.exp(logarithm + change * DIFFERENCE), sign) for change in (-1, 0, 1)]
    lower, shape, upper = shapes
    if lower is None or shape is None or upper is None:
        return np.full(z.size, np.inf), np.zeros((z.size, 2)), 1.0
    by_height = (upper(z) - lower(z)) / (2 * DIFFERENCE)
    return values[points] - shape(z), np.stack([-shape.slope(z), by_height], axis=1), shape.width
