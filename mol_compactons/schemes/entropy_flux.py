"""Tadmor's entropy-conservative two-point flux of the power |w|^(n-1) w."""

from __future__ import annotations

import numpy as np

from mol_compactons.compiled import compiled

SERIES_BELOW = 1e-3
"""Where two neighbours differ by less than this, relative to the larger one, their flux comes from its Taylor series."""

VACUUM = 1e-150
"""Where both neighbours are smaller than this their flux counts as zero, so that nothing underflows."""


@compiled
def odd_power(w: float, exponent: float) -> float:
    """sgn(w) |w|^exponent."""
    if exponent == 3.0:
        return w * w * w
    if exponent == 2.0:
        return w * abs(w)
    return float(np.sign(w) * abs(w) ** exponent)


@compiled
def two_point_flux(u: float, v: float, n: float) -> float:
    """Tadmor's flux (|v|^(n+1) - |u|^(n+1)) / ((n+1) (v - u)), free of cancellation."""
    if n == 1.0:
        return 0.5 * (u + v)
    if n == 3.0:
        return float((u + v) * (u * u + v * v) / 4)
    larger = max(abs(u), abs(v))
    if larger < VACUUM:
        return 0.0
    if n == 2.0 and u * v >= 0:
        return float(np.sign(u + v) * (u * u + u * v + v * v) / 3)
    difference = v - u
    if abs(difference) < SERIES_BELOW * larger:
        middle = 0.5 * (u + v)
        curvature = n * (n - 1) * odd_power(middle, n - 2)
        return odd_power(middle, n) + curvature * difference * difference / 24
    return float((abs(v) ** (n + 1) - abs(u) ** (n + 1)) / ((n + 1) * difference))
