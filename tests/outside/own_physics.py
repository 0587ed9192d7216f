"""Physics of one's own, as a module outside the package: one class for each kind of part."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import xlogy

from mol_compactons import (
    ContactLaw,
    Equation,
    GranularChain,
    GranularCompacton,
    Grid,
    Integrator,
    Lattice,
    Scheme,
    SemiDiscretization,
)
from mol_compactons.equations.base import Derivative, SecondDifference
from mol_compactons.errors import InputError, IntegrationError, require
from mol_compactons.integrators.base import Counters, Report, no_report
from mol_compactons.stencils import central
from mol_compactons.waves.base import LocalizedWave

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LogKdV(Equation):
    r"""The logarithmic Korteweg-de Vries equation, the limit n -> 1 of granular chains.

    .. math::  u_t + (u \log|u| + u_{xx})_x = 0

    Conserved: mass = Int u and energy H = Int [u_x^2 / 2 - u^2 log|u| / 2 + u^2 / 4]. Source: James and Pelinovsky, Proc. R.
    Soc. A 470 (2014) 20130462, doi:10.1098/rspa.2013.0462.
    """

    variables = ("u",)
    long_names: ClassVar[Mapping[str, str]] = {"u": "amplitude", "energy": "energy H, the Hamiltonian"}
    reference = "James, G., and Pelinovsky, D. (2014): Gaussian solitary waves and compactons in Fermi-Pasta-Ulam lattices"

    def local_flux(self, t: float, x: Array, state: Array, derivative: Derivative) -> Array:
        """F = u log|u| + u_xx, where the first term is 0 at u = 0."""
        (u,) = state
        return np.asarray(xlogy(u, np.abs(u)) + derivative(u, 2))

    def invariants(self, state: Array, spacing: float, second_difference: SecondDifference) -> dict[str, float]:
        """Mass and energy, as sums over the grid."""
        (u,) = state
        density = u * (u / 2 - xlogy(u, np.abs(u)) - second_difference(u)) / 2
        return {"mass": spacing * float(u.sum()), "energy": spacing * float(density.sum())}


@dataclass(frozen=True)
class GaussianWave(LocalizedWave):
    """The solitary wave of `LogKdV`, u = sign exp(c + 1/2) exp(-(x - center - c t)^2 / 4), of any speed c."""

    speed: float
    center: float
    sign: Literal[1, -1] = 1

    def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> Array:
        """The wave at time t, shape (1, N)."""
        require(isinstance(equation, LogKdV), f"GaussianWave is a wave of LogKdV, not of {type(equation).__name__}.")
        height, _ = self.outline(equation)
        z = grid.offset(self.center + self.speed * t)
        return np.asarray(height * np.exp(-(z**2) / 4))[None]

    def outline(self, equation: Equation) -> tuple[float, float]:
        """Its height, and the distance between the places where it is a thousandth of that."""
        return self.sign * math.exp(self.speed + 0.5), 4 * math.sqrt(math.log(1000))


@dataclass(frozen=True)
class PadeScheme(Scheme):
    """Fourth order by Padé's first difference: M u' = -D F, M = (1, 4, 1) / 6, D = (-1, 0, 1) / (2 h)."""

    formal_order = 4.0

    def suits(self, equation: Equation) -> float:
        """The two equations that it was tried on, after the schemes of the package."""
        return 0.1 if isinstance(equation, LogKdV | GranularCompacton) and not equation.has_source else 0.0

    def discretize(self, equation: Equation, grid: Grid | Lattice) -> SemiDiscretization:
        """The semi-discretisation, with five-point differences inside of F."""
        require(self.suits(equation) > 0 and isinstance(grid, Grid), "PadeScheme is for LogKdV and GranularCompacton.")
        require(grid.size > 8, f"grid.size = {grid.size} is too small for PadeScheme; choose at least 9 points.")

        def derivative(values: Array, order: int) -> Array:
            return central(order, 4).apply(values, grid.spacing)

        def rhs(t: float, state: Array, out: Array) -> None:
            flux = equation.local_flux(t, grid.coordinates, state, derivative)
            out[0] = (np.roll(flux, 1) - np.roll(flux, -1)) / (2 * grid.spacing)

        return SemiDiscretization(
            size=grid.size,
            components=1,
            reach=4,
            rhs=rhs,
            invariants=lambda state: equation.invariants(state, grid.spacing, lambda values: derivative(values, 2)),
            mass=np.array([1.0, 4.0, 1.0]) / 6,
        )


@dataclass(frozen=True)
class TodaContact(ContactLaw):
    """The contacts of Toda's lattice, F(z) = (exp(b z) - 1) / b; b > 0."""

    b: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.b > 0, f"TodaContact.b = {self.b:g} must be positive.")

    def force(self, z: Array, factor: Array) -> Array:
        """F."""
        return np.asarray(factor * np.expm1(self.b * z) / self.b)

    def stiffness(self, z: Array, factor: Array) -> Array:
        """F' = exp(b z)."""
        return np.asarray(factor * np.exp(self.b * z))

    def energy(self, z: Array, factor: Array) -> Array:
        """(F - z) / b."""
        return (self.force(z, factor) - factor * z) / self.b

    def resists(self, sign: int) -> bool:
        """Compression alone."""
        return sign > 0


@dataclass(frozen=True)
class TodaSoliton(LocalizedWave):
    r"""The exact soliton of Toda's lattice, of the speed V = sinh(kappa) / kappa > 1.

    .. math::  R_k = \frac1b \log\left(1 + \frac{\sinh^2\kappa}{\cosh^2 \kappa (k - \text{center} - V t)}\right)
    """

    speed: float
    center: float
    sign = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        require(1.001 <= self.speed <= 1e6, f"TodaSoliton.speed = {self.speed:g} must lie between 1.001 and 1e6.")

    @cached_property
    def kappa(self) -> float:
        """The wavenumber."""
        return float(brentq(lambda kappa: math.sinh(kappa) / kappa - self.speed, 1e-3, 20.0, xtol=1e-15))

    def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> Array:
        """The wave at time t, shape (2, N), from the stress and the velocity of the grains."""
        chain, b = _toda(equation)
        kappa, steepness = self.kappa, math.sinh(self.kappa)

        def stress(z: Array) -> Array:
            decay = np.exp(-np.abs(kappa * z))
            return np.asarray(np.log1p((2 * steepness * decay / (1 + decay**2)) ** 2) / b)

        def velocity(z: Array) -> Array:
            return np.asarray(steepness / b * (np.tanh(kappa * (z + 0.5)) - np.tanh(kappa * (z - 0.5))))

        return chain.travelling_state(stress, grid.offset(self.center + self.speed * t), self.speed, velocity)

    def outline(self, equation: Equation) -> tuple[float, float]:
        """The height 2 log(cosh(kappa)) / b, and the width where 1 / cosh^2 is a thousandth."""
        return 2 * math.log(math.cosh(self.kappa)) / _toda(equation)[1], 2 * math.acosh(math.sqrt(1000)) / self.kappa


def _toda(equation: Equation) -> tuple[GranularChain, float]:
    """The chain and its b."""
    if isinstance(equation, GranularChain) and isinstance(equation.law, TodaContact):
        return equation, equation.law.b
    raise InputError("TodaSoliton is a wave of a GranularChain with a TodaContact; choose equation.law=TodaContact().")


@dataclass(frozen=True)
class RungeKutta4(Integrator):
    """The classical Runge-Kutta method of fourth order, with equal steps of at most the length `step`."""

    step: float = 0.01
    coarsening = 2.0
    fixed_step = True

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.step > 0, f"RungeKutta4.step = {self.step:g} must be positive.")

    @property
    def own_tolerance(self) -> float:
        """The step."""
        return self.step

    def with_tolerance(self, tolerance: float) -> RungeKutta4:
        """The same method with another step."""
        return replace(self, step=tolerance)

    def start(self, system: SemiDiscretization, state: Array, t_end: float) -> RungeKutta4Run:
        """Begin a run at t = 0."""
        return RungeKutta4Run(self.step, system, state)


class RungeKutta4Run:
    """A run in progress."""

    def __init__(self, step: float, system: SemiDiscretization, state: Array) -> None:
        self.counters = Counters()
        self._step, self._rate, self._state, self._t = step, system.rate, state, 0.0

    def advance(self, t: float, report: Report = no_report) -> Array:
        """The state at the output time t."""
        start, count = self._t, max(1, math.ceil((t - self._t) / self._step - 1e-9))
        for index in range(count):
            self._take((t - start) / count)
            self._t = start + (t - start) * (index + 1) / count
            report(self._t)
        return self._state.copy()

    def _take(self, step: float) -> None:
        y, f, t = self._state, self._rate, self._t
        with np.errstate(all="ignore"):
            k1 = f(t, y)
            k2 = f(t + step / 2, y + step / 2 * k1)
            k3 = f(t + step / 2, y + step / 2 * k2)
            k4 = f(t + step, y + step * k3)
            self._state = y + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        self.counters.steps += 1
        self.counters.evaluations += 4
        if not np.isfinite(self._state).all():
            raise IntegrationError(f"RungeKutta4 blew up after t = {t:.6g}; choose a shorter integrator.step.", t)
