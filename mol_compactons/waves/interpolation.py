"""Periodic data on the points of another grid."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import require
from mol_compactons.grid import Grid

Array = NDArray[np.float64]

FEWEST = 5
"""The fewest points that are interpolated between."""

SMOOTH_BELOW = 1e-6
"""Data are smooth where the last third of their spectrum is below this, relative to its largest entry."""

EVEN_TO = 1e-9
"""Places are even where no distance between neighbours is off by more than this, relative to the period."""

LARGEST_COMMON = 2**22
"""The longest series on which the points of both grids are found."""


def periodic(places: Array, rows: Array, grid: Grid) -> Array:
    """Data at places on the periodic line of a grid, at its points.

    Parameters
    ----------
    places : array, shape (K,)
        Ascending, within one period.
    rows : array, shape (components, K)
        The data.
    grid : Grid
        Where they are wanted.

    Returns
    -------
    array, shape (components, size)
        By Fourier series where the places are even over the whole period and the data smooth, else by a monotone spline.

    Raises
    ------
    InputError
        If the places reach over more than a period.
    """
    reach = float(places[-1] - places[0])
    require(
        reach < grid.length,
        f"The places of the samples reach over {reach:g}, from {places[0]:g} to {places[-1]:g}, but the period of the grid is "
        f"{grid.length:g}; choose a longer grid, or leave out what comes round again.",
    )
    wanted = places[0] + grid.length / places.size * np.arange(places.size)
    even = float(np.abs(places - wanted).max()) <= EVEN_TO * grid.length
    shift = (grid.left - places[0]) / grid.length * places.size
    if even and places.size == grid.size and abs(shift - round(shift)) < EVEN_TO * places.size:
        return np.roll(rows, -round(shift), axis=1)
    if even and all(_is_smooth(row) for row in rows) and math.lcm(places.size, grid.size) <= LARGEST_COMMON:
        return np.array([_by_series(row, shift, grid.size) for row in rows])
    return np.array([_by_spline(places, row, grid) for row in rows])


def _is_smooth(row: Array) -> bool:
    sizes = np.abs(np.fft.rfft(row))
    return bool(sizes[-(sizes.size // 3) :].max() <= SMOOTH_BELOW * sizes.max())


def _by_series(row: Array, shift: float, size: int) -> Array:
    """The Fourier series of a row at `size` points, of which the first lies `shift` of its own distances to the right."""
    common = math.lcm(row.size, size)
    spectrum = np.fft.rfft(row)
    if row.size % 2 == 0:
        # The shortest wave stands half for each direction; without this its phase would depend on the grid.
        spectrum[-1] = spectrum[-1] / 2 if common > row.size else spectrum[-1].real
    turned = spectrum * np.exp(2j * np.pi * np.arange(spectrum.size) * shift / row.size)
    return np.asarray(np.fft.irfft(turned, n=common)[:: common // size] * (common / row.size))


def _by_spline(places: Array, row: Array, grid: Grid) -> Array:
    """The monotone cubic spline of Fritsch and Carlson through three periods, at the points of the middle one."""
    from scipy.interpolate import PchipInterpolator

    around = np.concatenate([places - grid.length, places, places + grid.length])
    wrapped = places[0] + (grid.coordinates - places[0]) % grid.length
    return np.asarray(PchipInterpolator(around, np.tile(row, 3))(wrapped))
