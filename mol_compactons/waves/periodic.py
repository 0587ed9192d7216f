"""The smooth periodic travelling waves of the granular compacton equation, for any n."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mol_compactons.equations.base import Equation
from mol_compactons.equations.granular import GranularCompacton
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.waves.base import Wave, check_center

GAUSS_NODES = 24
"""Nodes in each direction of the quadrature for a divided difference: round-off for waves well below the compacton."""

PHASES = 512
"""Points on the phase circle. The integrand is smooth and periodic there, so that the sums converge exponentially."""


@dataclass(frozen=True)
class PeriodicWave(Wave):
    r"""A smooth periodic travelling wave of the granular compacton equation, W = W(x - c t) > 0 or its mirror image.

    phi = W^((n+1)/2) obeys phi'' = c phi^((3-n)/(n+1)) - phi. With the trough phi_0 and the crest phi_1 its first integral is

    .. math::  \phi'^2 = (\phi_1 - \phi) (\phi - \phi_0) R(\phi),

    R > 0 a divided difference of the potential. With phi = (phi_0 + phi_1) / 2 + (phi_1 - phi_0) / 2 cos(theta) the phase
    theta has dx / dtheta = R^(-1/2), smooth and periodic, so that the period and the profile come from exponentially
    convergent sums. For n = 3, R = 1 and W = sqrt(c + A cos(x - c t)) with period 2 pi.

    Parameters
    ----------
    speed : float
        The speed c > 0, nondimensional.
    crest : float
        The largest |W|; between c^(1/(n-1)), where the wave is flat, and the height of the compacton, where the trough is
        zero.
    center : float
        Where a crest is at t = 0, nondimensional.
    sign : {1, -1}
        1 for compression, -1 for rarefaction.

    Raises
    ------
    InputError
        If the crest is out of range, the equation is another one, or the grid is no whole number of periods long.

    Notes
    -----
    Source: derived from Vladimirov and Skurativskyi (2015), equation (PDE3C), once integrated.

    Examples
    --------
    >>> wave = PeriodicWave(speed=1, crest=1.2)
    >>> round(wave.period(GranularCompacton(n=3)), 12)
    6.28318530718
    """

    speed: float
    crest: float
    center: float = 0.0
    sign: int = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.speed > 0, f"PeriodicWave.speed = {self.speed:g} must be positive; sign=-1 gives a rarefaction.")
        require(self.sign in (1, -1), f"PeriodicWave.sign = {self.sign} must be 1 or -1.")

    def trough(self, equation: Equation) -> float:
        """The smallest |W|, nondimensional."""
        orbit = self._orbit(equation)
        return float(orbit.lowest ** (2 / (orbit.n + 1)))

    def amplitude(self, equation: Equation) -> float:
        """Half the distance from trough to crest, nondimensional."""
        return (self.crest - self.trough(equation)) / 2

    def period(self, equation: Equation) -> float:
        """The period in x, nondimensional."""
        return self._orbit(equation).period

    def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> NDArray[np.float64]:
        """The wave at time t, shape (1, size)."""
        check_center(self, grid)
        orbit = self._orbit(equation)
        count = grid.length / orbit.period
        require(
            round(count) >= 1 and abs(count - round(count)) < 1e-9 * count,
            f"grid.length = {grid.length:.17g} is {count:.6g} periods of the wave; make it a whole multiple of "
            f"{orbit.period:.17g}.",
        )
        phi = orbit.profile(grid.offset(self.center + self.speed * t))
        return np.asarray(self.sign * phi ** (2 / (orbit.n + 1)))[None]

    def is_solution(self, equation: Equation) -> bool:
        """So it is wherever it exists."""
        return isinstance(equation, GranularCompacton)

    def _orbit(self, equation: Equation) -> _Orbit:
        if not isinstance(equation, GranularCompacton):
            raise InputError(f"PeriodicWave is a wave of GranularCompacton, not of {type(equation).__name__}.")
        n = equation.n
        flat = self.speed ** (1 / (n - 1))
        compacton = equation.compacton(self.speed).amplitude
        require(
            flat < self.crest < compacton,
            f"PeriodicWave.crest = {self.crest:g} must lie between {flat:.6g}, the flat wave, and {compacton:.6g}, the "
            f"compacton, for speed {self.speed:g} and n = {n:g}.",
        )
        orbit = _Orbit(n, self.speed, self.crest ** ((n + 1) / 2))
        require(
            orbit.is_resolved,
            f"PeriodicWave.crest = {self.crest:.10g} is too near to {compacton:.10g}, the compacton, for the period and the "
            "profile to be computed to ten digits; choose a lower crest, or a Compacton.",
        )
        return orbit


@dataclass(frozen=True)
class _Orbit:
    """The closed orbit phi'^2 = 2 E - phi^2 + c (n+1)/2 phi^(4/(n+1)) through the crest `highest`."""

    n: float
    speed: float
    highest: float

    def _potential(self, phi: float) -> float:
        return float(self.speed * (self.n + 1) / 2 * phi ** (4 / (self.n + 1)) - phi**2)

    @cached_property
    def lowest(self) -> float:
        """The trough, where the potential is what it is at the crest."""
        from scipy.optimize import brentq

        flat = self.speed ** ((self.n + 1) / (2 * (self.n - 1)))
        level = self._potential(self.highest)
        return float(brentq(lambda phi: self._potential(phi) - level, 0.0, flat, xtol=1e-300, rtol=1e-15))

    def _quotient(self, phi: NDArray[np.float64], count: int) -> NDArray[np.float64]:
        """R = -[phi_0, phi_1, phi] of the potential, by Gauss quadrature with `count` nodes in each direction.

        By Hermite and Genocchi the second divided difference is the integral of the second derivative over a triangle.
        """
        nodes, weights = np.polynomial.legendre.leggauss(count)
        nodes, weights = (nodes + 1) / 2, weights / 2
        first, inner = np.meshgrid(nodes, nodes, indexing="ij")
        share = np.outer(weights * (1 - nodes), weights)
        second = (1 - first) * inner
        power = 4 / (self.n + 1)
        places = self.lowest * first[..., None] + self.highest * second[..., None] + phi * (1 - first - second)[..., None]
        curvature = self.speed * (self.n + 1) / 2 * power * (power - 1) * places ** (power - 2) - 2
        return np.asarray(-np.tensordot(share, curvature, axes=2))

    @cached_property
    def is_resolved(self) -> bool:
        """Whether the quadrature has converged, and the cosine series has ended, to ten digits."""
        phi = self._phi(np.pi * np.arange(9) / 8)
        coarse, fine = self._quotient(phi, GAUSS_NODES), self._quotient(phi, 2 * GAUSS_NODES)
        settled = float(np.abs(coarse / fine - 1).max()) < 1e-10
        return settled and float(np.abs(self._rates[-8:]).max()) < 1e-10 * float(self._rates[0])

    @cached_property
    def _rates(self) -> NDArray[np.float64]:
        """The cosine coefficients of dx / dtheta = R^(-1/2)."""
        theta = np.pi * np.arange(PHASES // 2 + 1) / (PHASES // 2)
        quotient = self._quotient(self._phi(theta), GAUSS_NODES)
        symmetric = np.concatenate([quotient, quotient[-2:0:-1]]) ** -0.5
        rates = np.fft.rfft(symmetric).real / PHASES
        rates[1:] *= 2
        return np.asarray(rates)

    def _phi(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray((self.highest + self.lowest) / 2 + (self.highest - self.lowest) / 2 * np.cos(theta))

    @property
    def period(self) -> float:
        """The period in x."""
        return float(2 * np.pi * self._rates[0])

    def profile(self, z: NDArray[np.float64]) -> NDArray[np.float64]:
        """Phi at the distances z from a crest, by Newton's method for the phase."""
        rates = self._rates[:-1]
        orders = np.arange(rates.size)
        theta = np.mod(np.asarray(z) / rates[0], 2 * np.pi)
        target = np.mod(np.asarray(z), self.period)
        for _ in range(50):
            angles = np.multiply.outer(theta, orders[1:])
            error = rates[0] * theta + np.sin(angles) @ (rates[1:] / orders[1:]) - target
            theta -= error / (rates[0] + np.cos(angles) @ rates[1:])
            if np.abs(error).max() < 1e-14 * self.period:
                break
        return self._phi(theta)
