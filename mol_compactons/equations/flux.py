"""The nonlinear dispersive flux F[u] = a(u) + b(u) g(u)_xx that the equations of the paper share, made of power laws."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import Settings
from mol_compactons.errors import require
from mol_compactons.runtime.compiled import compiled
from mol_compactons.runtime.powers import size_power

DERIVATIVE_FLOOR = 1e-6
"""Where an exponent is negative (derivatives at the edge of a wave), |u| counts as at least this times the largest |u|: no
infinity enters a Jacobian, which is regularised there, and Newton's method converges fastest, in 4 to 7 iterations where 1e-12
and 1e-3 need more than 20."""


@compiled
def _size_power(size: float, quarters: int) -> float:
    """size^(quarters / 4) for size >= 0, by products and square roots."""
    value = 1.0
    for _ in range(quarters >> 2):
        value *= size
    if quarters & 3:
        root = math.sqrt(size)
        if quarters & 2:
            value *= root
        if quarters & 1:
            value *= math.sqrt(root)
    return value


@compiled
def power_law(
    u: NDArray[np.float64], coefficient: float, exponent: float, odd: bool, add: bool, out: NDArray[np.float64]
) -> None:
    """The law; the plain powers up to 3 have loops of their own, and the compiler vectorises all but those of quarters."""
    quarters = round(4 * exponent)
    exact = 4 * exponent == quarters
    if not add:
        out[:] = 0.0
    if exact and quarters == 0 and not odd:
        for j in range(u.size):
            out[j] = out[j] + coefficient
    elif exact and quarters == 4 and odd:
        for j in range(u.size):
            out[j] = out[j] + coefficient * u[j]
    elif exact and quarters == 8 and not odd:
        for j in range(u.size):
            out[j] = out[j] + coefficient * u[j] * u[j]
    elif exact and quarters == 12 and odd:
        for j in range(u.size):
            out[j] = out[j] + coefficient * u[j] * u[j] * u[j]
    elif exact and quarters == 2 and not odd:
        for j in range(u.size):
            out[j] = out[j] + coefficient * math.sqrt(abs(u[j]))
    elif exact and 0 <= quarters <= 32:
        for j in range(u.size):
            value = coefficient * _size_power(abs(u[j]), quarters)
            out[j] = out[j] + (value * np.sign(u[j]) if odd else value)
    else:
        floor = DERIVATIVE_FLOOR * np.abs(u).max() if exponent < 0 else 0.0
        for j in range(u.size):
            value = coefficient * size_power(max(abs(u[j]), floor), exponent)
            signed = (value if u[j] > 0.0 else -value) if u[j] != 0.0 else 0.0 * value
            out[j] = out[j] + (signed if odd else value)


@compiled
def evaluate_flux(
    table: NDArray[np.float64], u: NDArray[np.float64], b: NDArray[np.float64], g: NDArray[np.float64], a: NDArray[np.float64]
) -> None:
    """Write b(u), g(u) and a(u) of a flux, all of shape (N,), from its table (see `Flux.table`)."""
    for row in range(table.shape[0]):
        out = b if row == 0 else (g if row == 1 else a)
        power_law(u, table[row, 0], table[row, 1], table[row, 2] > 0, row > 2, out)


@dataclass(frozen=True)
class PowerLaw(Settings):
    """A power law of either parity: c |u|^p, or c sgn(u) |u|^p where `odd`.

    For a whole exponent, u^p is the odd law if p is odd and the even law if p is even.

    Parameters
    ----------
    coefficient, exponent : float
        c and p, nondimensional.
    odd : bool
        Which of the two.

    Examples
    --------
    >>> PowerLaw(2, 3, odd=True)(np.array([-1.0, 2.0]))
    array([-2., 16.])
    """

    coefficient: float
    exponent: float
    odd: bool = False

    def __call__(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """The value at each u, same shape."""
        u = np.asarray(u, dtype=float)
        out = np.empty(u.size)
        self.evaluate(u.ravel(), out)
        return out.reshape(u.shape)

    def evaluate(self, u: NDArray[np.float64], out: NDArray[np.float64], add: bool = False) -> None:
        """Write the value at each u, shape (N,), into `out`, or add it."""
        power_law(u, self.coefficient, self.exponent, self.odd, add, out)

    def derivative(self) -> PowerLaw:
        """The derivative with respect to u; one and the same object each time, since Jacobians ask for it."""
        return self._derivative

    @cached_property
    def _derivative(self) -> PowerLaw:
        return PowerLaw(self.coefficient * self.exponent, self.exponent - 1 if self.exponent else 0.0, not self.odd)

    def antiderivative(self) -> PowerLaw:
        """The antiderivative that vanishes at u = 0; one and the same object each time, as energies ask for it."""
        return self._antiderivative

    @cached_property
    def _antiderivative(self) -> PowerLaw:
        return PowerLaw(self.coefficient / (self.exponent + 1), self.exponent + 1, not self.odd)


def whole_power(coefficient: float, exponent: float) -> PowerLaw:
    """The law c u^p for a whole exponent p: odd for odd p, even for even p."""
    return PowerLaw(coefficient, exponent, odd=exponent % 2 == 1)


class DispersiveFlux(ABC):
    """A flux of the form F[u] = a(u) + b(u) g(u)_xx, as the compact scheme takes it; all arrays have the shape (N,)."""

    @abstractmethod
    def evaluate(self, u: NDArray[np.float64], b: NDArray[np.float64], g: NDArray[np.float64], a: NDArray[np.float64]) -> None:
        """Write b(u), g(u) and a(u)."""

    @abstractmethod
    def slopes(self, u: NDArray[np.float64], b: NDArray[np.float64], g: NDArray[np.float64], a: NDArray[np.float64]) -> None:
        """Write b'(u), g'(u) and a'(u)."""

    @property
    def table(self) -> NDArray[np.float64] | None:
        """The flux as power laws, for kernels that are compiled as a whole; None where it is not made of these."""
        return None


@dataclass(frozen=True)
class Flux(DispersiveFlux, Settings):
    """The flux F[u] = a(u) + b(u) g(u)_xx.

    Parameters
    ----------
    a : tuple of PowerLaw
        The convective part, a sum.
    b, g : PowerLaw
        The dispersive part.
    """

    a: tuple[PowerLaw, ...]
    b: PowerLaw
    g: PowerLaw

    def __post_init__(self) -> None:
        super().__post_init__()
        require(len(self.a) > 0, "Flux.a = () must hold at least one power law; use PowerLaw(0, 1) for none.")

    @cached_property
    def table(self) -> NDArray[np.float64]:
        """Coefficient, exponent and parity (1 for odd) of b, of g and of the terms of a, shape (2 + terms, 3)."""
        return np.array([(law.coefficient, law.exponent, float(law.odd)) for law in (self.b, self.g, *self.a)])

    def evaluate(self, u: NDArray[np.float64], b: NDArray[np.float64], g: NDArray[np.float64], a: NDArray[np.float64]) -> None:
        """Write b(u), g(u) and a(u)."""
        evaluate_flux(self.table, u, b, g, a)

    def slopes(self, u: NDArray[np.float64], b: NDArray[np.float64], g: NDArray[np.float64], a: NDArray[np.float64]) -> None:
        """Write b'(u), g'(u) and a'(u)."""
        self.b.derivative().evaluate(u, b)
        self.g.derivative().evaluate(u, g)
        self.convective_derivative(u, a)

    def convective(self, u: NDArray[np.float64], out: NDArray[np.float64]) -> None:
        """Write a(u), shape (N,), into `out`."""
        for index, law in enumerate(self.a):
            law.evaluate(u, out, add=index > 0)

    def convective_derivative(self, u: NDArray[np.float64], out: NDArray[np.float64]) -> None:
        """Write a'(u), shape (N,), into `out`."""
        for index, law in enumerate(self.a):
            law.derivative().evaluate(u, out, add=index > 0)

    @property
    def variational_constant(self) -> float | None:
        """The kappa for which b = kappa g', or None.

        With it F is the variational derivative of the integral of A(u) - (kappa / 2) g_x^2, A' = a.
        """
        slope = self.g.derivative()
        same_power = math.isclose(slope.exponent, self.b.exponent, rel_tol=0, abs_tol=1e-12)
        if slope.coefficient and same_power and slope.odd == self.b.odd:
            return self.b.coefficient / slope.coefficient
        return None

    def energy_parts(self, u: NDArray[np.float64], g_second: NDArray[np.float64]) -> NDArray[np.float64]:
        """A(u) and (kappa / 2) g g_xx, shape (2, N): after integration by parts the density whose variation is F is their sum.

        Parameters
        ----------
        u : array, shape (N,)
            The state.
        g_second : array, shape (N,)
            The second difference or derivative of g(u).
        """
        kappa = self.variational_constant
        require(kappa is not None, "The flux has no energy: b must be a multiple of the derivative of g.")
        parts = np.zeros((2, u.size))
        for law in self.a:
            parts[0] += law.antiderivative()(u)
        parts[1] = 0.5 * float(kappa or 0) * self.g(u) * g_second
        return parts


def contact_flux(n: float, strength: float, dispersion: float) -> Flux:
    """The flux of a contact of exponent n: a = C |u|^(n-1) u, b = C beta |u|^((n-1)/2), g = |u|^((n-1)/2) u.

    For n = 3 the smooth polynomials u^3, u, u^2 take their place, of which they are the same flux.
    """
    if n == 3:
        return Flux((whole_power(strength, 3),), whole_power(strength * dispersion, 1), whole_power(1, 2))
    a = PowerLaw(strength, n, odd=True)
    return Flux((a,), PowerLaw(strength * dispersion, (n - 1) / 2), PowerLaw(1, (n + 1) / 2, odd=True))
