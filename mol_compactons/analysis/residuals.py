"""How well an exact wave satisfies its own equation.

A travelling wave u(x - c t) of the one-way equation u_t + F_x = 0 whose constant of integration is zero has F[u] = c u;
one of the two-way equation u_t = -v_x, v_t = -F_x has F[u] = c^2 u.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mol_compactons.equations.base import Equation
from mol_compactons.equations.flux import Flux, PowerLaw
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid
from mol_compactons.waves.compacton import Compacton

CAUCHY_NODES = 64
"""Points on the circle of Cauchy's integral; the error falls like 2^-CAUCHY_NODES."""


class TravellingWave(Protocol):
    """A wave with a speed."""

    @property
    def speed(self) -> float:
        """The speed c."""

    def values(self, equation: Equation, grid: Grid, t: float = 0.0) -> NDArray[np.float64]:
        """The wave at time t, shape (components, size)."""


def residual(wave: TravellingWave, equation: Equation, grid: Grid) -> NDArray[np.float64]:
    """F[u] - c u (one-way) or F[u] - c^2 u (two-way) at the grid points, with g_xx by Fourier differentiation.

    Parameters
    ----------
    wave, equation : travelling wave and its equation
        The wave is taken at t = 0.
    grid : Grid
        One or more periods, or a box around a compacton.

    Returns
    -------
    array, shape (size,)
        Nondimensional. For a smooth wave it is round-off, about 1e-16 k_max^2; at the edge of a compacton it falls
        algebraically, see the tests.
    """
    u = wave.values(equation, grid)[0]
    g_second = np.fft.irfft(-(grid.wavenumbers**2) * np.fft.rfft(_flux_of(equation).g(u)), n=grid.size)
    return _balance(u, g_second, wave.speed, equation)


def interior_residual(wave: Compacton, equation: Equation, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same inside the support of a compacton, where it is analytic, with g_xx by Cauchy's integral; round-off.

    Parameters
    ----------
    wave, equation : Compacton and its equation
        The wave is taken at t = 0.
    points : array, shape (K,)
        Places within the support as fractions of its half-width: 0 is the centre, -1 and 1 are the edges, both excluded.

    Returns
    -------
    array, shape (K,)
        Nondimensional.

    Raises
    ------
    InputError
        If a point is not inside.
    """
    points = np.asarray(points, dtype=float)
    require(bool((np.abs(points) < 1).all()), "The points must lie strictly between -1 and 1, the edges of the compacton.")
    shape = equation.compacton(wave.speed, wave.sign)
    z = points * shape.width / 2
    radius = 0.5 * (shape.width / 2 - np.abs(z))
    circle = np.exp(2j * np.pi * np.arange(CAUCHY_NODES) / CAUCHY_NODES)
    cosine = np.cos(shape.wavenumber * (z[:, None] + radius[:, None] * circle))
    g = _continued(_flux_of(equation).g, shape.amplitude, cosine, shape.exponent)
    g_second = 2 / radius**2 * (g * circle**-2).mean(axis=1).real
    return _balance(shape(z), g_second, wave.speed, equation)


def _continued(law: PowerLaw, amplitude: float, cosine: NDArray[np.complex128], exponent: float) -> NDArray[np.complex128]:
    """The law of amplitude cosine^exponent, continued into the complex plane from the side where cosine > 0."""
    sign = np.sign(amplitude) if law.odd else 1.0
    return np.asarray(sign * law.coefficient * abs(amplitude) ** law.exponent * cosine ** (exponent * law.exponent))


def _balance(u: NDArray[np.float64], g_second: NDArray[np.float64], speed: float, equation: Equation) -> NDArray[np.float64]:
    convective = np.empty_like(u)
    flux = _flux_of(equation)
    flux.convective(u, convective)
    factor = speed**2 if equation.two_way else speed
    return convective + flux.b(u) * g_second - factor * u


def _flux_of(equation: Equation) -> Flux:
    flux = equation.dispersive_flux
    if not isinstance(flux, Flux):
        raise InputError(f"Residuals are those of a flux of power laws, which {type(equation).__name__} has not.")
    return flux
