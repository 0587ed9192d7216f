"""An equation of one's own whose flux is made of three power laws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from mol_compactons.equations.base import Array, Equation, SecondDifference
from mol_compactons.equations.flux import Flux, PowerLaw
from mol_compactons.errors import require


@dataclass(frozen=True)
class PowerLawEquation(Equation):
    r"""An equation of one's own with the flux F = a(u) + b(u) g(u)_xx of three power laws.

    .. math::  u_t + F_x = 0,   or in two-way form   u_t + v_x = 0,  v_t + F_x = 0

    Conserved: mass = Int u; where b = kappa g', also energy: for the one-way form H = -E, for the two-way form
    Int v^2 / 2 + E, with E = Int [A(u) - (kappa / 2) g_x^2] and A' = a. A two-way equation also
    conserves momentum = Int v.

    Parameters
    ----------
    a, b, g : PowerLaw
        The three laws.
    two_way : bool
        Which form.

    Examples
    --------
    >>> PowerLawEquation(a=PowerLaw(1, 2), b=PowerLaw(1, 0), g=PowerLaw(1, 1, odd=True)).variables  # Korteweg-de Vries
    ('u',)
    """

    a: PowerLaw
    b: PowerLaw
    g: PowerLaw
    two_way: bool = False

    long_names: ClassVar[Mapping[str, str]] = {"u": "amplitude", "v": "rate, with u_t = -v_x"}

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("a", "b", "g"):
            exponent = getattr(self, name).exponent
            require(exponent >= 0, f"PowerLawEquation.{name} has the exponent {exponent:g}; it must not be negative.")

    @property
    def variables(self) -> tuple[str, ...]:
        """The names of the components."""
        return ("u", "v") if self.two_way else ("u",)

    @cached_property
    def dispersive_flux(self) -> Flux:
        """The flux."""
        return Flux((self.a,), self.b, self.g)

    def densities(self, state: Array, second_difference: SecondDifference) -> dict[str, Array]:
        """Those of mass, and of momentum and energy where they are conserved."""
        result, flux = super().densities(state, second_difference), self.dispersive_flux
        if flux.variational_constant is not None:
            stored = flux.energy_parts(state[0], second_difference(flux.g(state[0])))
            result["energy"] = np.array([*stored, 0.5 * state[1] ** 2]) if self.two_way else -stored
        return result
