r"""The exact solitary wave of the granular chain, for any exponent.

A wave R_k(t) = R(k - V t) of the chain obeys

.. math::  V^2 R(\xi) = (\Lambda * F(R))(\xi), \qquad \Lambda(\xi) = \max(0, 1 - |\xi|),

solved here by Petviashvili's stabilised iteration in Fourier space, where the hat has the symbol sinc^2(k / 2), to round-off.
The grains move with the velocity that is the mean of F(R) / V over one distance between grains. English and Pego, Proc. AMS
133 (2005) 1763, doi:10.1090/S0002-9939-05-07851-2; Petviashvili, Sov. J. Plasma Phys. 2 (1976) 257.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import InputError, require

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

Array = NDArray[np.float64]

POINTS_PER_SITE = 32
"""Resolution of the profile; its spectrum has fallen to round-off there."""

MOST_ITERATIONS = 2000

BLOCK = 256
"""How many values of a series are computed at once."""

REFINEMENT = 2
"""How many more points the spline has, of the fifth degree: it is within 1e-10 of the series."""

MARGIN = 16
"""Points of the spline beyond the centre, where it has its end."""

SLOWEST, FASTEST = 1e-6, 1e6
"""The speeds for which a wave is computed."""

CONVERGED_BELOW = 1e-15
"""The iteration ends when the profile changes by less than this, relative to its height, or no longer improves."""

LONGEST_PROFILE = 2000.0
"""Half the length, in sites, beyond which a wave is too near the speed of sound."""


@dataclass(frozen=True, eq=False)
class SolitaryProfile:
    """The profile of a solitary wave, even about its centre; a function of the distance in sites.

    Parameters
    ----------
    speed : float
        V, sites for each unit of time.
    spectrum : array, shape (K,)
        The cosine coefficients of R at the wavenumbers pi j / half_length.
    velocity_spectrum : array, shape (K,)
        Those of the velocity of the grains.
    half_length : float
        Half the period of these series, in sites; beyond it the wave is zero.
    kinetic_energy, potential_energy : float
        The mean energies of the wave.
    residual : float
        The largest |V^2 R - Lambda * F(R)|, relative to V^2 times the height.
    """

    speed: float
    spectrum: Array
    velocity_spectrum: Array
    half_length: float
    kinetic_energy: float
    potential_energy: float
    residual: float

    def __call__(self, z: Array) -> Array:
        """R at the distances z, any shape."""
        return self._series(self.spectrum, z)

    def velocity(self, z: Array) -> Array:
        """The velocity of a grain at the distances z, any shape."""
        return self._series(self.velocity_spectrum, z)

    def _series(self, coefficients: Array, z: Array) -> Array:
        z = np.asarray(z, dtype=float)
        value = np.zeros_like(z)
        inside = np.abs(z) < self.half_length
        places = z[inside]
        series = np.empty_like(places)
        for start in range(0, places.size, BLOCK):
            block = slice(start, start + BLOCK)
            angles = np.pi / self.half_length * np.multiply.outer(places[block], np.arange(coefficients.size))
            series[block] = np.cos(angles) @ coefficients
        value[inside] = series
        return value

    @cached_property
    def spline(self) -> BSpline:
        """R and its derivatives on [0, half_length], to 1e-10 of the height, for many values at little cost."""
        from scipy.interpolate import make_interp_spline

        size = 2 * REFINEMENT * (self.spectrum.size - 1)
        transform = np.zeros(size // 2 + 1)
        transform[: self.spectrum.size] = self.spectrum * size / 2
        transform[0] *= 2
        values = np.fft.irfft(transform, n=size)
        indices = np.arange(-MARGIN, size // 2 + 1)
        return make_interp_spline(2 * self.half_length / size * indices, values[indices], k=5)

    @property
    def amplitude(self) -> float:
        """The height, R at the centre."""
        return float(self.spectrum.sum())

    @property
    def total_stress(self) -> float:
        """The integral of R: by how much the chain is shortened."""
        return float(2 * self.half_length * self.spectrum[0])

    @cached_property
    def width(self) -> float:
        """The distance between the places where R is a thousandth of its height, in sites."""
        return 2 * self._distance(1e-3)

    @cached_property
    def half_width(self) -> float:
        """The width at half the height, in sites."""
        return 2 * self._distance(0.5)

    def _distance(self, fraction: float) -> float:
        from scipy.optimize import brentq

        height = self.amplitude
        return float(brentq(lambda z: float(self(np.array([z]))[0]) - fraction * height, 0.0, self.half_length))


LARGEST_RATIO = 1e12
"""The largest ratio of the speed to that of sound for which the decay of the tails is computed."""


@lru_cache(maxsize=64)
def profile_of_speed(n: float, strength: float, linear: float, static: float, speed: float) -> SolitaryProfile:
    """The wave for F(R) = A [(R + static)^n - static^n] + B R."""
    sound, half_length = _extent(n, strength, linear, static, speed)
    size = int(2 * half_length) * POINTS_PER_SITE
    wavenumbers = np.pi / half_length * np.arange(size // 2 + 1)
    sinc = np.sinc(wavenumbers / (2 * np.pi))
    inertia = (speed**2 - sound**2 * sinc**2) / strength

    def nonlinear(stress: Array) -> Array:
        positive = np.maximum(stress, 0.0)
        if not static:
            return np.asarray(positive**n)
        return np.asarray((positive + static) ** n - static**n - n * static ** (n - 1) * positive)

    z = half_length * (2 * np.arange(size) / size - 1)
    height = ((speed**2 - sound**2) * (n + 1) / (2 * strength)) ** (1 / (n - 1)) if not static else speed**2 / sound**2 - 1
    decay = (n - 1) / (n + 1) / math.sqrt(n / (6 * (n + 1)))
    stress = height / np.cosh(np.minimum(decay * np.abs(z), 300.0)) ** 2
    gamma = n / (n - 1) if not static else 2.0
    best = np.inf
    for _ in range(MOST_ITERATIONS):
        source = np.fft.rfft(nonlinear(stress))
        transform = np.fft.rfft(stress)
        ratio = _inner(transform, inertia * transform) / _inner(transform, sinc**2 * source)
        update = np.fft.irfft(ratio**gamma * sinc**2 * source / inertia, n=size)
        change = float(np.abs(update - stress).max() / np.abs(update).max())
        stress = update
        if not np.isfinite(change):
            break
        if change < CONVERGED_BELOW or (change < 1e-12 and change > 0.9 * best):
            return _finish(stress, nonlinear(stress), sinc, half_length, strength, sound, speed, (n, linear, static))
        best = min(best, change)
    raise InputError(
        f"The solitary wave of speed {speed:g} was not found; choose a speed farther from that of sound, {sound:.6g}."
    )


def _extent(n: float, strength: float, linear: float, static: float, speed: float) -> tuple[float, float]:
    """The speed of sound and half the length of the box, refused where there is no wave."""
    sound = math.sqrt(linear + strength * n * static ** (n - 1)) if static else math.sqrt(linear)
    require(
        speed > sound * (1 + 1e-6) and speed > 0,
        f"SolitaryWave.speed = {speed:g} is not faster than sound, {sound:.6g}; solitary waves of the chain are supersonic.",
    )
    half_length = float(math.ceil(_half_length(n, speed, sound)))
    near_sound = f"SolitaryWave.speed = {speed:g} is too near to that of sound, {sound:.6g}"
    cause = near_sound if sound else f"n = {n:g} is too near to 1"
    require(
        half_length <= LONGEST_PROFILE,
        f"{cause}: the wave is longer than {LONGEST_PROFILE:g} sites; choose a higher one.",
    )
    return sound, half_length


def _half_length(n: float, speed: float, sound: float) -> float:
    """How far the wave reaches before it is below round-off: exponential tails for sound > 0, double exponential else."""
    core = 12 + 4 * math.pi * math.sqrt(n * (n + 1) / 6) / (n - 1)
    if not sound:
        return core
    from scipy.optimize import brentq

    # Tails as short as those of the largest ratio are shorter than the core.
    ratio = min(speed / sound, LARGEST_RATIO)
    decay = brentq(lambda kappa: math.sinh(kappa / 2) / (kappa / 2) - ratio, 1e-9, 80.0)
    return max(core, 40 / float(decay))


def _inner(a: NDArray[np.complex128], b: NDArray[np.complex128]) -> float:
    weights = np.full(a.size, 2.0)
    weights[0] = weights[-1] = 1.0
    return float((weights * (a.conj() * b).real).sum())


def _finish(
    stress: Array,
    nonlinear: Array,
    sinc: Array,
    half_length: float,
    strength: float,
    sound: float,
    speed: float,
    law: tuple[float, float, float],
) -> SolitaryProfile:
    """Energies, residual and cosine series of a profile on the grid whose first point is the end of the box."""
    n, linear, static = law
    size = stress.size
    force = strength * nonlinear + sound**2 * stress
    transform = np.fft.rfft(force)
    velocity = np.fft.irfft(sinc * transform, n=size) / speed
    residual = speed**2 * stress - np.fft.irfft(sinc**2 * transform, n=size)
    positive = np.maximum(stress, 0.0) + static
    stored = strength * (positive ** (n + 1) - static ** (n + 1)) / (n + 1) - strength * static**n * (positive - static)
    stored += 0.5 * linear * stress**2
    spacing = 2 * half_length / size
    signs = (-1.0) ** np.arange(size // 2 + 1) * 2 / size
    signs[0] /= 2
    signs[-1] /= 2
    return SolitaryProfile(
        speed=speed,
        spectrum=np.fft.rfft(stress).real * signs,
        velocity_spectrum=np.fft.rfft(velocity).real * signs,
        half_length=half_length,
        kinetic_energy=0.5 * spacing * float(velocity @ velocity),
        potential_energy=spacing * float(stored.sum()),
        residual=float(np.abs(residual).max() / (speed**2 * stress.max())),
    )
