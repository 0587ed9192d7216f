"""Tadmor's entropy-conservative two-point flux of the power |w|^(n-1) w."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mol_compactons.runtime.compiled import compiled

Array = NDArray[np.float64]

NEAR = 5e-3
"""Where two neighbours differ by less than this, relative to the larger one, their flux comes from its Taylor series."""

VACUUM = 1e-150
"""Where neighbours are smaller than this their flux counts as zero for all n but 1, 2 and 3, so that nothing is divided by an
underflow."""


@compiled
def needs_powers(n: float) -> bool:
    """Whether the fluxes of an exponent are made from powers of the values."""
    return n not in (1.0, 1.5, 2.0, 3.0)


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
def _general_fluxes(u: Array, v: Array, of_u: Array, of_v: Array, n: float, out: Array) -> None:
    """The fluxes for any n, by one division each; of neighbours w and w (1 + e) with a small e by a series.

    f* = |w|^(n-1) w (1 + n/2 e + n (n-1) / 6 e^2 + ...)
    """
    c1, c2, c3, c4, c5 = n / 2, (n - 1) / 3, (n - 2) / 4, (n - 3) / 5, (n - 4) / 6
    for k in range(out.size):
        a, b = abs(u[k]), abs(v[k])
        first = a > b
        w, power, size = (u[k], of_u[k], a) if first else (v[k], of_v[k], b)
        apart = (v[k] if first else u[k]) - w
        near = abs(apart) < NEAR * size
        above, below = (apart, w) if near else (of_v[k] * b - of_u[k] * a, (n + 1) * (v[k] - u[k]))
        e = above / below
        series = 1 + c1 * e * (1 + c2 * e * (1 + c3 * e * (1 + c4 * e * (1 + c5 * e))))
        value = (power if w > 0.0 else -power) * series if near else e
        out[k] = value if size >= VACUUM else 0.0


@compiled
def _general_slopes(u: Array, v: Array, of_u: Array, of_v: Array, n: float, by_u: Array, by_v: Array) -> None:
    """The derivatives of these fluxes; of nearly equal neighbours those of the series."""
    c1, c2, c3, c4, c5 = n / 2, (n - 1) / 3, (n - 2) / 4, (n - 3) / 5, (n - 4) / 6
    d2, d3, d4, d5 = c1 * c2, c1 * c2 * c3, c1 * c2 * c3 * c4, c1 * c2 * c3 * c4 * c5
    for k in range(by_u.size):
        a, b = abs(u[k]), abs(v[k])
        first = a > b
        w, power, size = (u[k], of_u[k], a) if first else (v[k], of_v[k], b)
        apart, across = (v[k] if first else u[k]) - w, v[k] - u[k]
        near = abs(apart) < NEAR * size
        e = apart / w
        series = 1 + e * (c1 + e * (d2 + e * (d3 + e * (d4 + e * d5))))
        slope = c1 + e * (2 * d2 + e * (3 * d3 + e * (4 * d4 + e * 5 * d5)))
        of_smaller = power / size * slope
        of_larger = power / size * (n * series - (1 + e) * slope)
        left, right = (of_u[k] if u[k] > 0.0 else -of_u[k]), (of_v[k] if v[k] > 0.0 else -of_v[k])
        flux = (of_v[k] * b - of_u[k] * a) / ((n + 1) * across)
        left, right = (flux - left) / across, (right - flux) / across
        near_u, near_v = (of_larger, of_smaller) if first else (of_smaller, of_larger)
        by_u[k] = (near_u if near else left) if size >= VACUUM else 0.0
        by_v[k] = (near_v if near else right) if size >= VACUUM else 0.0


@compiled
def two_point_fluxes(u: Array, v: Array, of_u: Array, of_v: Array, n: float, out: Array) -> None:
    """Tadmor's flux (|v|^(n+1) - |u|^(n+1)) / ((n+1) (v - u)) of each pair, free of cancellation.

    The usual exponents have loops of their own; the others take |u|^n and |v|^n from `of_u` and `of_v`, see `needs_powers`.
    The compiler vectorises all.
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
        _general_fluxes(u, v, of_u, of_v, n, out)


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
def two_point_slopes(u: Array, v: Array, of_u: Array, of_v: Array, n: float, by_u: Array, by_v: Array) -> None:
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
        _general_slopes(u, v, of_u, of_v, n, by_u, by_v)


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
