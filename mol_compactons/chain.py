"""The granular chain in stresses: discrete by nature, its own semi-discretisation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons import stencils
from mol_compactons.configuration import check
from mol_compactons.equations import CosinePower
from mol_compactons.errors import InputError, require
from mol_compactons.flux import PowerLaw
from mol_compactons.grid import Grid, Lattice
from mol_compactons.nesterenko import Nesterenko
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.stencils import convolve


@dataclass(frozen=True)
class GranularChain:
    r"""A chain of equal grains in the stresses R_k = Q_(k-1) - Q_k, Q_k the displacements.

    .. math::  \ddot R_k = F(R_{k-1}) - 2 F(R_k) + F(R_{k+1}),   F(z) = A |z|^{n-1} z + B z

    Conserved: mass = Sum R, momentum = Sum R_t (both of the ring), energy = Sum [p^2 / 2 + A |R|^(n+1) / (n+1) + B R^2 / 2]
    with the velocities p_k of the grains, R_t = p_(k-1) - p_k, in the frame where their sum is zero.

    Parameters
    ----------
    n : float
        The exponent of the force, larger than 1.
    strength : float
        A > 0.
    linear : float
        B >= 0; 0 for sonic vacuum.

    Raises
    ------
    InputError
        If a parameter is out of range.

    Notes
    -----
    All quantities are nondimensional; the grains have mass 1. Source: Nesterenko (1983), doi:10.1007/BF00905892; Vladimirov
    and Skurativskyi (2015), equations (DS_Nest) and (Forceint).
    """

    n: float
    strength: float = 1.0
    linear: float = 0.0

    variables = ("R", "R_t")

    def __post_init__(self) -> None:
        check(self)
        require(self.n > 1, f"GranularChain.n = {self.n:g} must be larger than 1; the Hertz contact has n = 1.5.")
        require(self.strength > 0, f"GranularChain.strength = {self.strength:g} must be positive.")
        require(self.linear >= 0, f"GranularChain.linear = {self.linear:g} must not be negative; 0 is none.")

    @cached_property
    def force(self) -> tuple[PowerLaw, ...]:
        """The terms of F."""
        contact = PowerLaw(self.strength, self.n, odd=True)
        return (contact, PowerLaw(self.linear, 1, odd=True)) if self.linear else (contact,)

    def compacton(self, speed: float, sign: int = 1) -> CosinePower:
        """The compacton of Nesterenko's equation with a = 1: the data of the paper for the chain, not its exact wave."""
        return Nesterenko(self.n, self.strength, 1.0, self.linear).compacton(speed, sign)

    def travelling_state(self, shape: CosinePower, z: NDArray[np.float64], speed: float) -> NDArray[np.float64]:
        """The state of a wave of this shape and speed, R and R_t = V [R(z - 1/2) - R(z + 1/2)], shape (2, N).

        That is -V R' as a difference of the velocities V R(z +- 1/2) of two neighbouring grains, which adds up to zero on
        the ring.
        """
        return np.array([shape(z), speed * (shape(z - 0.5) - shape(z + 0.5))])

    def check_state(self, state: NDArray[np.float64]) -> None:
        """Refuse rates that do not add up to zero: they are differences of the velocities of neighbouring grains on a ring."""
        total, size = float(state[1].sum()), float(np.abs(state[1]).sum())
        require(
            abs(total) <= 1e-9 * size,
            f"The rates R_t add up to {total:.4g}, but on a ring they must add up to 0; subtract their mean.",
        )

    def frequency_squared(self, wavenumber: float, stress: float) -> float:
        """omega^2 = F'(R0) 4 sin^2(k / 2) of small waves about a uniform stress R0 >= 0; never negative."""
        stiffness = self.n * self.strength * abs(stress) ** (self.n - 1) + self.linear
        return float(stiffness * 4 * np.sin(wavenumber / 2) ** 2)

    def invariants(self, state: NDArray[np.float64]) -> dict[str, float]:
        """Mass, momentum and energy of a state of shape (2, N); nondimensional."""
        stress, rate = state
        velocity = -np.cumsum(rate)
        velocity -= velocity.mean()
        potential = sum(float(term.antiderivative()(stress).sum()) for term in self.force)
        return {
            "mass": float(stress.sum()),
            "momentum": float(rate.sum()),
            "energy": 0.5 * float(velocity @ velocity) + potential,
        }


@dataclass(frozen=True)
class NearestNeighbours:
    """The differences that belong to a chain: exact, not an approximation.

    Raises
    ------
    InputError
        For anything but a GranularChain on a Lattice.
    """

    def discretize(self, equation: Any, grid: Grid | Lattice) -> SemiDiscretization:
        """The chain as a system of ordinary differential equations for R and R_t."""
        if not (isinstance(equation, GranularChain) and isinstance(grid, Lattice)):
            raise InputError(
                f"NearestNeighbours is for a GranularChain on a Lattice, not for {type(equation).__name__} on a "
                f"{type(grid).__name__}; choose a scheme for equations, such as CompactScheme."
            )
        second = stencils.SECOND_NEAREST.scaled(1.0)
        force, slope = np.empty((2, grid.size))

        def rhs(t: float, state: NDArray[np.float64], out: NDArray[np.float64]) -> None:
            for index, term in enumerate(equation.force):
                term.evaluate(state[0], force, add=index > 0)
            out[0] = state[1]
            convolve(second, force, out[1])

        def jacobian(t: float, state: NDArray[np.float64], out: NDArray[np.float64]) -> None:
            for index, term in enumerate(equation.force):
                term.derivative().evaluate(state[0], slope, add=index > 0)
            out[:] = 0
            out[0, 1, 1] = 1
            for offset, weight in zip((-1, 0, 1), second[1:4], strict=True):
                out[1, 0, 1 + offset] = weight * np.roll(slope, -offset)

        return SemiDiscretization(
            size=grid.size, components=2, reach=1, rhs=rhs, jacobian=jacobian, invariants=equation.invariants
        )
