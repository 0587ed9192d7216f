"""|x|^p for any p, without a branch, so that the compiler takes several numbers at a time where this stands in a loop.

With x = 2^e m, m between sqrt(1/2) and sqrt(2), and s = (m - 1) / (m + 1),

    log2 x = e + (2 / ln 2) (s + s^3/3 + s^5/5 + ...)        x^p = 2^k exp(f ln 2),    p log2 x = k + f

The logarithm is carried in two numbers, the second the rounding of the first, so that p may multiply it. The series
and the exponential are polynomials that interpolate at Chebyshev's points; `tests/runtime/test_powers.py` says how near they
are.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit, types
from numba.core import config
from numba.extending import intrinsic

LOGARITHM = (
    0.3333333333333333,
    0.2000000000000044,
    0.14285714285401616,
    0.11111111195900235,
    0.09090897815442377,
    0.07693120102906739,
    0.06634379834280306,
    0.06543383504974087,
)
"""Of (artanh(s) / s - 1) / s^2 in powers of s^2."""

EXPONENTIAL = (
    0.5000000000000001,
    0.16666666666666669,
    0.041666666666623824,
    0.008333333333330039,
    0.0013888888917367081,
    0.00019841269863171557,
    2.4801521057868204e-05,
    2.7557268276905696e-06,
    2.7620201591031547e-07,
    2.5100472505694996e-08,
)
"""Of (exp(g) - 1 - g) / g^2 in powers of g."""

_L0, _L1, _L2, _L3, _L4, _L5, _L6, _L7 = LOGARITHM
_E0, _E1, _E2, _E3, _E4, _E5, _E6, _E7, _E8, _E9 = EXPONENTIAL

LOG2E = 1 / math.log(2)
LOG2E_REST = 2.0355273740931033e-17
"""1 / ln 2, and what is left of it."""

LN2 = math.log(2)

SMALLEST_NORMAL = 2.0**-1022
LIFT, LIFTED = 2.0**54, 54.0
"""Numbers below the smallest normal one are lifted by so much before their bits are read."""

MAGIC = 1.5 * 2.0**52
"""Added to a number and taken away again it leaves the nearest whole number, which the bits of the sum have at their end."""

MAGIC_BITS = int(np.float64(MAGIC).view(np.int64))
ROOT_BITS = int(np.float64(math.sqrt(0.5)).view(np.int64))
FRACTION_BITS, BIAS = 52, 1023
"""Of a 64-bit float."""

LARGEST_POWER_OF_TWO = 1100.0
"""Beyond this, up or down, powers of 2 are no numbers."""


def _bits_of(context: Any, x: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], context.get_value_type(types.int64))

    return types.int64(types.float64), generate


def _float_of(context: Any, bits: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], context.get_value_type(types.float64))

    return types.float64(types.int64), generate


def _fused(context: Any, x: Any, y: Any, z: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), generate


_intrinsic: Any = intrinsic
bits_of, float_of, fused = map(_intrinsic, (_bits_of, _float_of, _fused))
"""The bits of a float as a whole number, the float of such bits, and x y + z with one rounding."""


def _size_power(x: float, p: float) -> float:
    """x^p for x >= 0; 0 at x = 0, but 1 for p = 0, and NaN for NaN.

    Parameters
    ----------
    x, p : float
        The base and the exponent. The error is below 2 units in the last place where |p log2 x| is below 100, and below 8 up
        to the largest numbers.
    """
    small = x < SMALLEST_NORMAL
    bits = bits_of(x * LIFT if small else x)
    e = (bits - ROOT_BITS) >> FRACTION_BITS
    m = float_of(bits - (e << FRACTION_BITS))
    whole = (float_of(e + MAGIC_BITS) - MAGIC) - (LIFTED if small else 0.0)
    above, below = m - 1.0, m + 1.0
    below_rest = m - (below - 1.0)
    inverse = 1.0 / below
    s = above * inverse
    s_rest = (fused(-s, below, above) - s * below_rest) * inverse
    z = s * s
    series = fused(fused(fused(fused(fused(fused(fused(_L7, z, _L6), z, _L5), z, _L4), z, _L3), z, _L2), z, _L1), z, _L0)
    first = 2.0 * s
    rest = fused(first * z, series, 2.0 * s_rest)
    log = first + rest
    log_rest = (first - log) + rest
    part = log * LOG2E
    part_rest = fused(log, LOG2E, -part) + fused(log, LOG2E_REST, log_rest * LOG2E)
    log2 = whole + part
    log2_rest = ((whole - log2) + part) + part_rest
    y = p * log2
    y_rest = fused(p, log2, -y) + p * log2_rest
    y = min(max(y, -LARGEST_POWER_OF_TWO), LARGEST_POWER_OF_TWO)
    k = (y + MAGIC) - MAGIC
    g = ((y - k) + y_rest) * LN2
    tail = fused(fused(fused(fused(fused(_E9, g, _E8), g, _E7), g, _E6), g, _E5), g, _E4)
    tail = fused(fused(fused(fused(tail, g, _E3), g, _E2), g, _E1), g, _E0)
    value = fused(fused(tail, g, 1.0), g, 1.0)
    steps = bits_of(k + MAGIC) - MAGIC_BITS
    half = steps >> 1
    value = value * float_of((half + BIAS) << FRACTION_BITS) * float_of((steps - half + BIAS) << FRACTION_BITS)
    at_zero = 1.0 if p == 0.0 else 0.0
    at_infinity = 1.0 if p == 0.0 else (np.inf if p > 0.0 else 0.0)
    beyond = at_infinity if x == np.inf else x
    return value if 0.0 < x < np.inf else (at_zero if x == 0.0 else beyond)


def _plain_power(x: float, p: float) -> float:
    """The same without a compiler, as under a debugger."""
    return float(x**p) if x > 0.0 or p == 0.0 else 0.0 * x


size_power: Callable[[float, float], float] = (
    _plain_power if getattr(config, "DISABLE_JIT", 0) else njit(error_model="numpy", inline="always")(_size_power)
)
"""`_size_power` where it is called, in place of a call."""
