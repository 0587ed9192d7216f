"""The nonlinear dispersive flux F[u] = a(u) + b(u) g(u)_xx that every continuous model here shares, made of power laws."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mol_compactons.compiled import compiled
from mol_compactons.configuration import check
from mol_compactons.errors import require

DERIVATIVE_FLOOR = 1e-6
"""Where an exponent is negative (derivatives at the edge of a wave), |u| counts as at least this times the largest |u|: no
infinity enters a Jacobian, which is regularised there, and Newton's method converges fastest, in 4 to 7 iterations where 1e-12
and 1e-3 need more than 20."""


@compiled
def _power_law(
    u: NDArray[np.float64], coefficient: float, exponent: float, odd: bool, add: bool, out: NDArray[np.float64]
) -> None:
    quarters = round(4 * exponent)
    floor = DERIVATIVE_FLOOR * np.abs(u).max() if exponent < 0 else 0.0
    products_suffice = 4 * exponent == quarters and 0 <= quarters <= 32
    for j in range(u.size):
        size = abs(u[j])
        if products_suffice:
            value = coefficient
            for _ in range(quarters >> 2):
                value *= size
            if quarters & 3:
                root = math.sqrt(size)
                if quarters & 2:
                    value *= root
                if quarters & 1:
                    value *= math.sqrt(root)
        else:
            size = max(size, floor)
            value = coefficient * size**exponent if size > 0 or exponent >= 0 else 0.0
        if odd:
            value *= np.sign(u[j])
        out[j] = out[j] + value if add else value


@dataclass(frozen=True)
class PowerLaw:
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

    def __post_init__(self) -> None:
        check(self)

    def __call__(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """The value at each u, same shape."""
        u = np.asarray(u, dtype=float)
        out = np.empty(u.size)
        self.evaluate(u.ravel(), out)
        return out.reshape(u.shape)

    def evaluate(self, u: NDArray[np.float64], out: NDArray[np.float64], add: bool = False) -> None:
        """Write the value at each u, shape (N,), into `out`, or add it."""
        _power_law(u, self.coefficient, self.exponent, self.odd, add, out)

    def derivative(self) -> PowerLaw:
        """The derivative with respect to u; one and the same object each time, since Jacobians ask for it."""
        return self._derivative

    @cached_property
    def _derivative(self) -> PowerLaw:
        return PowerLaw(self.coefficient * self.exponent, self.exponent - 1 if self.exponent else 0.0, not self.odd)

    def antiderivative(self) -> PowerLaw:
        """The antiderivative that vanishes at u = 0."""
        return PowerLaw(self.coefficient / (self.exponent + 1), self.exponent + 1, not self.odd)


def whole_power(coefficient: float, exponent: float) -> PowerLaw:
    """The law c u^p for a whole exponent p: odd for odd p, even for even p."""
    return PowerLaw(coefficient, exponent, odd=exponent % 2 == 1)


@dataclass(frozen=True)
class Flux:
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
        check(self)
        require(len(self.a) > 0, "Flux.a = () must hold at least one power law; use PowerLaw(0, 1) for none.")

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

    def energy_density(self, u: NDArray[np.float64], g_second: NDArray[np.float64]) -> NDArray[np.float64]:
        """A(u) + (kappa / 2) g g_xx, shape (N,): after integration by parts the density whose variation is F.

        Parameters
        ----------
        u : array, shape (N,)
            The state.
        g_second : array, shape (N,)
            The second difference or derivative of g(u).
        """
        kappa = self.variational_constant
        require(kappa is not None, "The flux has no energy: b must be a multiple of the derivative of g.")
        density = 0.5 * float(kappa or 0) * self.g(u) * g_second
        for law in self.a:
            density += law.antiderivative()(u)
        return np.asarray(density)
