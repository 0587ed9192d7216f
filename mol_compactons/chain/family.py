"""The solitary waves of a chain by their height: shape and speed.

Without a linear term and a static compression all have one shape, and V^2 = A r^(n-1) for a wave r times as high as that of
V^2 = A. With them there is a speed of sound c0, and the shape changes with the height: waves are computed at speeds with
equal steps of log(V^2 / c0^2 - 1), and between these all is interpolated by polynomials.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mol_compactons.chain.profile import SolitaryProfile, profile_of_speed
from mol_compactons.errors import InputError

Array = NDArray[np.float64]

STEP = 0.15
"""The distance of the computed waves in log(V^2 / c0^2 - 1)."""

NODES = 8
"""How many of them a value between is made of."""

INVERSIONS = 4
"""Newton's steps from a height to its place between the nodes, each of which doubles the digits of the last."""

LOWEST, HIGHEST = -40, 160
"""The numbers of the first and the last of them: V / c0 - 1 from 0.0012, where a wave is hundreds of sites long, to 1.6e5."""


@dataclass(frozen=True, eq=False)
class ChainShape:
    """The shape of a solitary wave of a chain: the sum of some profiles, each with a weight.

    Parameters
    ----------
    amplitude : float
        The signed height, R at the centre.
    width, half_width : float
        The distances between the places where R is a thousandth and a half of its height, in sites.
    profiles, weights : sequences
        What is added.
    """

    amplitude: float
    width: float
    half_width: float
    profiles: tuple[SolitaryProfile, ...]
    weights: tuple[float, ...]

    @property
    def core(self) -> float:
        """The width and a site to either side: it is smooth everywhere, and a chain has few points in it."""
        return self.width + 2

    def __call__(self, z: Array) -> Array:
        """R at the distances z, any shape."""
        return self._sum(np.abs(np.asarray(z, dtype=float)), 0)

    def slope(self, z: Array) -> Array:
        """Its derivative."""
        z = np.asarray(z, dtype=float)
        return np.sign(z) * self._sum(np.abs(z), 1)

    def _sum(self, distance: Array, order: int) -> Array:
        total = np.zeros_like(distance)
        for profile, weight in zip(self.profiles, self.weights, strict=True):
            inside = distance < profile.half_length
            total[inside] += weight * profile.spline(distance[inside], order)
        return total


def chain_shape(n: float, strength: float, linear: float, static: float, height: float, sign: int) -> ChainShape | None:
    """The wave of a height, for the force F(R) = A [(R + static)^n - static^n] + B R.

    Parameters
    ----------
    n, strength, linear, static : float
        The exponent, A, B and the static stress.
    height : float
        |R| at the centre.
    sign : {1, -1}
        That of the shape.

    Returns
    -------
    ChainShape or None
        None where there is none within reach: too near to the speed of sound.
    """
    if not linear and not static:
        unit = _unit(n)
        return ChainShape(sign * height, unit.width, unit.half_width, (unit,), (sign * height / unit.amplitude,))
    first, place = _place(n, strength, linear, static, height) or (0, math.nan)
    if math.isnan(place):
        return None
    profiles = tuple(_node(n, strength, linear, static, first + index) for index in range(NODES))
    weights = _lagrange(place)
    sizes = np.log([(profile.width, profile.half_width) for profile in profiles])
    width, half_width = np.exp(weights @ sizes).tolist()
    # The interpolated profile has its height where the weights add up to it.
    parts = weights / np.array([profile.amplitude for profile in profiles])
    return ChainShape(sign * height, width, half_width, profiles, tuple((sign * height * parts).tolist()))


def chain_speed(n: float, strength: float, linear: float, static: float, height: float) -> float | None:
    """The speed V > 0 of the wave of a height; None where there is none within reach. Parameters as of `chain_shape`."""
    if not linear and not static:
        return math.sqrt(strength) * math.pow(height / _unit(n).amplitude, (n - 1) / 2)
    found = _place(n, strength, linear, static, height)
    if found is None:
        return None
    first, place = found
    return _sound(n, strength, linear, static) * math.sqrt(1 + math.exp(STEP * (first + place)))


def _unit(n: float) -> SolitaryProfile:
    return profile_of_speed(n, 1.0, 0.0, 0.0, 1.0)


def _sound(n: float, strength: float, linear: float, static: float) -> float:
    return math.sqrt(linear + (strength * n * static ** (n - 1) if static else 0.0))


@lru_cache(maxsize=256)
def _node(n: float, strength: float, linear: float, static: float, number: int) -> SolitaryProfile:
    """The wave of a number on the ladder of speeds."""
    return profile_of_speed(
        n, strength, linear, static, _sound(n, strength, linear, static) * math.sqrt(1 + math.exp(STEP * number))
    )


@lru_cache(maxsize=256)
def _place(n: float, strength: float, linear: float, static: float, height: float) -> tuple[int, float] | None:
    """Where a height lies on the ladder: the first of the nodes around it, and its distance from that in steps."""

    def logarithm(number: int) -> float:
        return math.log(_node(n, strength, linear, static, number).amplitude / height)

    try:
        below = _bisect(lambda number: logarithm(number) <= 0)
        if below is None:
            return None
        first = min(max(below - NODES // 2 + 1, LOWEST), HIGHEST - NODES + 1)
        nodes = np.array([logarithm(first + index) for index in range(NODES)])
    except InputError:
        return None
    place = below - first + nodes[below - first] / (nodes[below - first] - nodes[below - first + 1])
    for _ in range(INVERSIONS):
        value, slope = (float(weights @ nodes) for weights in (_lagrange(place), _lagrange_slope(place)))
        place -= value / slope
    return first, float(place)


def _bisect(is_below: Callable[[int], bool]) -> int | None:
    """The last number on the ladder whose wave is below; None where that is none, or the last of all."""
    low, high = LOWEST, HIGHEST
    if not is_below(low) or is_below(high):
        return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if is_below(middle) else (low, middle)
    return low


def _lagrange(place: float) -> Array:
    """The weights of the nodes 0, 1, ... in the value of their polynomial at a place."""
    nodes = np.arange(NODES)
    factors = (place - nodes) / np.where(nodes[:, None] == nodes, 1, nodes[:, None] - nodes)
    np.fill_diagonal(factors, 1.0)
    return np.asarray(factors.prod(axis=1))


def _lagrange_slope(place: float) -> Array:
    """Their derivatives by the place, by central differences, which are good enough for Newton's steps."""
    return (_lagrange(place + 1e-3) - _lagrange(place - 1e-3)) / 2e-3
