"""The peaks of a profile, between the points of the grid."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from mol_compactons.grid import Grid, Lattice

Array = NDArray[np.float64]

QUARTIC = np.array([[0, 0, 24, 0, 0], [2, -16, 0, 16, -2], [-1, 16, -30, 16, -1], [-2, 4, 0, -4, 2], [1, -4, 6, -4, 1]]) / 24.0
"""The coefficients of the quartic through five values at -2, -1, 0, 1, 2."""


def peaks(values: Array, grid: Grid | Lattice, sign: int, least: float) -> tuple[Array, Array, Array]:
    """The peaks of one sign, with the position of each between the points, from a quartic through five of them.

    Parameters
    ----------
    values : array, shape (N,)
        A field on a periodic grid.
    grid : Grid or Lattice
        The grid.
    sign : {1, -1}
        Crests or troughs.
    least : float
        The least height and prominence of a peak.

    Returns
    -------
    positions, heights, widths : arrays, one entry for each peak
        Heights count from zero and are positive for either sign; widths are those at half the height.
    """
    from scipy.signal import find_peaks, peak_widths

    turned = sign * np.asarray(values, dtype=float)
    if not turned.max() >= least:
        return (np.empty(0),) * 3
    start = int(np.argmin(turned))
    rolled = np.append(np.roll(turned, -start), turned[start])
    places, _ = find_peaks(rolled, height=least, prominence=least)
    if not places.size:
        return (np.empty(0),) * 3
    width = peak_widths(
        rolled,
        places,
        rel_height=0.5,
        prominence_data=(rolled[places], np.zeros_like(places), np.full_like(places, grid.size)),
    )[0]
    around = turned[(places[:, None] + start + np.arange(-2, 3)) % grid.size]
    offsets, heights = _summits(around)
    positions = grid.coordinates[0] + grid.spacing * (((places + start) % grid.size) + offsets)
    return positions, heights, grid.spacing * width


def _summits(around: Array) -> tuple[Array, Array]:
    """Place and height of the top of the quartics through five points each, shape (peaks, 5), in units of the spacing."""
    quartics = QUARTIC @ around.T
    slope = np.arange(1.0, 5.0)[:, None] * quartics[1:]
    curvature = np.arange(1.0, 4.0)[:, None] * slope[1:]
    offsets = np.zeros(around.shape[0])
    for _ in range(6):
        bend = np.minimum(polynomial.polyval(offsets, curvature, tensor=False), -1e-300)
        offsets = np.clip(offsets - polynomial.polyval(offsets, slope, tensor=False) / bend, -1.0, 1.0)
    return offsets, np.asarray(polynomial.polyval(offsets, quartics, tensor=False))
