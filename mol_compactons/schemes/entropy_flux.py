"""Tadmor's entropy-conservative two-point flux of the power |w|^(n-1) w."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mol_compactons.equations.flux import DERIVATIVE_FLOOR
from mol_compactons.runtime.compiled import compiled

Array = NDArray[np.float64]

SERIES_BELOW = 1e-3
"""Where two neighbours differ by less than this, relative to the larger one, their flux comes from its Taylor series."""

VACUUM = 1e-150
"""Where neighbours are smaller than this their flux counts as zero for all n but 1, 2 and 3, so that nothing is divided by an
underflow."""


@compiled
def _odd_power(w: float, exponent: float) -> float:
    """sgn(w) |w|^exponent."""
    return float(np.sign(w) * abs(w) ** exponent)


@compiled
def _cubic_flux(u: float, v: float) -> float:
    """The flux for n = 3."""
    return (u + v) * (u * u + v * v) / 4


@compiled
def _quadratic_flux(u: float, v: float) -> float:
    """The flux for n = 2: as a polynomial, but for opposite signs, where the denominator is |u| + |v|."""
    a, b = abs(u), abs(v)
    total = a * a + a * b + b * b
    if u * v >= 0.0:
        return total / 3 if u + v >= 0.0 else -total / 3
    return (b - a) * total / (3 * (v - u))


@compiled
def _hertz_flux(u: float, v: float) -> float:
    """The flux for n = 3/2, in the roots s of |u| and t of |v|: with equal signs t^5 - s^5 has the factor t - s of v - u."""
    a, b = abs(u), abs(v)
    s, t = math.sqrt(a), math.sqrt(b)
    if a + b < VACUUM:
        return 0.0
    if u * v >= 0.0:
        mean = (a * a + a * b + b * b + s * t * (a + b)) / (2.5 * (s + t))
        return mean if u + v >= 0.0 else -mean
    return (b * b * t - a * a * s) / (2.5 * (v - u))


@compiled
def _general_flux(u: float, v: float, n: float) -> float:
    """The flux for any n; its Taylor series where u and v are nearly equal."""
    larger = max(abs(u), abs(v))
    if larger < VACUUM:
        return 0.0
    difference = v - u
    if abs(difference) < SERIES_BELOW * larger:
        middle = 0.5 * (u + v)
        curvature = n * (n - 1) * _odd_power(middle, n - 2)
        return _odd_power(middle, n) + curvature * difference * difference / 24
    return float((abs(v) ** (n + 1) - abs(u) ** (n + 1)) / ((n + 1) * difference))


@compiled
def two_point_fluxes(u: Array, v: Array, n: float, out: Array) -> None:
    """Tadmor's flux (|v|^(n+1) - |u|^(n+1)) / ((n+1) (v - u)) of each pair, free of cancellation.

    The usual exponents have loops of their own, which the compiler vectorises.
    """
    if n == 3.0:
        for k in range(out.size):
            out[k] = _cubic_flux(u[k], v[k])
    elif n == 2.0:
        for k in range(out.size):
            out[k] = _quadratic_flux(u[k], v[k])
    elif n == 1.5:
        for k in range(out.size):
            out[k] = _hertz_flux(u[k], v[k])
    elif n == 1.0:
        for k in range(out.size):
            out[k] = 0.5 * (u[k] + v[k])
    else:
        for k in range(out.size):
            out[k] = _general_flux(u[k], v[k], n)


@compiled
def _cubic_slope(u: float, v: float) -> float:
    """The derivative of the flux by u for n = 3."""
    return (3 * u * u + 2 * u * v + v * v) / 4


@compiled
def _quadratic_slope(u: float, v: float) -> float:
    """The derivative of the flux by u for n = 2."""
    if u * v >= 0.0:
        return (2 * abs(u) + abs(v)) / 3
    return (_quadratic_flux(u, v) - u * abs(u)) / (v - u)


@compiled
def _hertz_slope(u: float, v: float) -> float:
    """The derivative of the flux by u for n = 3/2."""
    a, b = abs(u), abs(v)
    s, t = math.sqrt(a), math.sqrt(b)
    if a + b < VACUUM:
        return 0.0
    if u * v >= 0.0:
        return (3 * a * s + 6 * a * t + 4 * s * b + 2 * b * t) / (5 * (s + t) * (s + t))
    return (_hertz_flux(u, v) - u * s) / (v - u)


@compiled
def _slope(u: float, v: float, n: float) -> float:
    """The derivative of the flux by u for any n; that of the mean where u and v are nearly equal."""
    difference = v - u
    if abs(difference) < DERIVATIVE_FLOOR * max(abs(u), abs(v)) or difference == 0.0:
        middle = abs(0.5 * (u + v))
        return float(0.5 * n * middle ** (n - 1)) if middle > 0.0 or n >= 1.0 else 0.0
    return (_general_flux(u, v, n) - _odd_power(u, n)) / difference


@compiled
def two_point_slopes(u: Array, v: Array, n: float, by_u: Array, by_v: Array) -> None:
    """The derivatives of the flux by either argument; f* is symmetric."""
    if n == 3.0:
        for k in range(by_u.size):
            by_u[k], by_v[k] = _cubic_slope(u[k], v[k]), _cubic_slope(v[k], u[k])
    elif n == 2.0:
        for k in range(by_u.size):
            by_u[k], by_v[k] = _quadratic_slope(u[k], v[k]), _quadratic_slope(v[k], u[k])
    elif n == 1.5:
        for k in range(by_u.size):
            by_u[k], by_v[k] = _hertz_slope(u[k], v[k]), _hertz_slope(v[k], u[k])
    elif n == 1.0:
        by_u[:] = by_v[:] = 0.5
    else:
        for k in range(by_u.size):
            by_u[k], by_v[k] = _slope(u[k], v[k], n), _slope(v[k], u[k], n)


@compiled
def neighbours(values: Array, first: int, stride: int) -> tuple[Array, Array, Array, Array]:
    """The values a stride before a flux's left cell, there, in its right cell and a stride after it, from a place on."""
    return values[first:], values[first + stride :], values[first + 2 * stride :], values[first + 3 * stride :]


@compiled
def subtract_difference(flux: Array, stride: int, scale: float, out: Array) -> None:
    """Subtract scale times what leaves each cell on the right, in flux[k + stride], less what enters it, in flux[k]."""
    leaving = flux[stride:]
    for k in range(out.size):
        out[k] -= scale * (leaving[k] - flux[k])


@compiled
def subtract_difference_jacobian(derivatives: Array, stride: int, scale: float, out: Array) -> None:
    """The same for the cyclic diagonals, shape (2 R + 1, N).

    derivatives[i, k] is that of flux[k] by the cell i - 1 strides right of the one which the flux leaves.
    """
    reach, size = (out.shape[0] - 1) // 2, out.shape[1]
    for place in range(4):
        middle = reach + (place - 1) * stride
        left, entered = out[middle], out[middle - stride]
        leaving, entering = derivatives[place, stride:], derivatives[place]
        for k in range(size):
            left[k] -= scale * leaving[k]
            entered[k] += scale * entering[k]
