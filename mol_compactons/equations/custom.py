"""An equation of one's own, whose flux and source are formulas."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from mol_compactons.equations.base import Array, Derivative, Equation, SecondDifference
from mol_compactons.equations.formula_flux import FormulaFlux, dispersive_form
from mol_compactons.errors import require
from mol_compactons.expressions import Node, Program, check_name, parse
from mol_compactons.grid import Grid
from mol_compactons.stencils import convolve

PROBES = 33
"""How many states near the background the formulas are tried at."""

PROBE_SIZE = 1e-3
"""How far these are from the background."""


@dataclass(frozen=True)
class CustomEquation(Equation):
    r"""An equation of one's own, with a flux F and a source s that are given as formulas.

    .. math::  u_t + F_x = s,   or in two-way form   u_t + v_x = 0,  v_t + F_x = s

    A formula is made of numbers, u, v (two-way), x, t, parameters, ``+ - * / **``, the functions of
    `mol_compactons.expressions.FUNCTIONS`, and d1, d2, d3 for the derivatives in space of what stands in their brackets. See
    docs/formulas.md.

    Without a source the mass Int u is conserved, in two-way form always, and there without a source also the momentum Int v.
    Where F = a(u) + b(u) g(u)_xx with b = kappa g', and there is no source, so is the energy: H = -E in one-way form, and
    Int v^2 / 2 + E in two-way form, E = Int [A(u) - (kappa / 2) g_x^2], A' = a. With a source the integrals are diagnostics.

    Parameters
    ----------
    flux : str
        The formula of F.
    source : str
        The formula of s; empty for none.
    parameters : mapping of str to float
        Names that stand for numbers in the formulas; each must be used.
    two_way : bool
        Which form.
    variable : str
        What the formulas call u.
    background : float
        The value of u where nothing moves; near it the formulas must have values.

    Raises
    ------
    InputError
        If a formula cannot be read or has no value near the background. The sentence shows the place.

    Examples
    --------
    >>> kdv = CustomEquation("3*u**2 + d2(u)")
    >>> damped = CustomEquation("W**3 + W*d2(W**2)", source="-nu*W", parameters={"nu": 0.1}, variable="W")
    >>> list(kdv.invariants(np.ones((1, 8)), 0.5, np.zeros_like)), damped.variables
    (['mass', 'energy'], ('W',))
    """

    flux: str
    source: str = ""
    parameters: Mapping[str, float] = field(default_factory=dict)
    two_way: bool = False
    variable: str = "u"
    background: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_names()
        trees = [self._flux_tree, *([self._parsed("source")] if self.source else [])]
        names = frozenset[str]().union(*(tree.names for tree in trees))
        object.__setattr__(self, "depends_on_time", "t" in names)
        self._check_background()

    def _check_names(self) -> None:
        taken = ["x", "t", *(["v"] if self.two_way else [])]
        check_name(self.variable, "CustomEquation.variable")
        for name in self.parameters:
            check_name(name, "CustomEquation.parameters")
        for name in (self.variable, *self.parameters):
            others = [*taken, *([self.variable] if name in self.parameters else [])]
            require(name not in others, f"CustomEquation: the name {name!r} is given twice; {', '.join(others)} are taken.")
        text = f"{self.flux} {self.source}"
        for name in self.parameters:
            used = any(name == word for word in _words(text))
            require(used, f"CustomEquation.parameters has {name!r}, which stands in no formula; take it out, or use it.")

    def _parsed(self, which: str) -> Node:
        names = (*self.variables, "x", "t")
        return parse(getattr(self, which), f"CustomEquation.{which}", names, self.parameters, derivatives=True)

    @property
    def has_source(self) -> bool:
        """Whether there is a formula for one."""
        return bool(self.source)

    @property
    def variables(self) -> tuple[str, ...]:
        """The names of the components."""
        return (self.variable, "v") if self.two_way else (self.variable,)

    @cached_property
    def _flux_tree(self) -> Node:
        return self._parsed("flux")

    @cached_property
    def _programs(self) -> dict[str, Program]:
        """What computes the flux, and the source where there is one."""
        programs = {"flux": Program((self._flux_tree,))}
        return programs | ({"source": Program((self._parsed("source"),))} if self.source else {})

    @cached_property
    def dispersive_flux(self) -> FormulaFlux | None:
        """The flux in the form a(u) + b(u) g(u)_xx, or None where it has another."""
        return dispersive_form(self._flux_tree, self.variable, self.background)

    def local_flux(self, t: float, x: Array, state: Array, derivative: Derivative) -> Array:
        """F at the grid points, shape (N,); see `Equation.local_flux`."""
        return self._value("flux", t, x, state, derivative)

    def local_source(self, t: float, x: Array, state: Array, derivative: Derivative) -> Array | None:
        """The source s at the grid points, shape (N,); None for none."""
        return self._value("source", t, x, state, derivative) if self.source else None

    def _value(self, which: str, t: float, x: Array, state: Array, derivative: Derivative) -> Array:
        program = self._programs[which]
        return np.asarray(program.evaluate(x.size, self._inputs(t, x, state), derivative)[program.outputs[0]])

    def _inputs(self, t: float, x: Array, state: Array) -> dict[str, Array | float]:
        return {**dict(zip(self.variables, state, strict=True)), "x": x, "t": t}

    def linearized(self, stencils: Mapping[int, Array]) -> FormulaLinearization:
        """The exact derivatives of the flux and the source, with given differences; see `Linearization`."""
        return FormulaLinearization(self, stencils)

    def _check_background(self) -> None:
        """Refuse formulas without a value near the background."""
        ripples = PROBE_SIZE * np.random.default_rng(0).normal(size=(4, PROBES))
        ripples[:, 0] = 0.0
        state = ripples[: len(self.variables)]
        state[0] += self.background
        unknown = np.full(PROBES, np.nan)
        self._refuse_singular(
            self._inputs(np.nan, unknown, state),
            lambda values, order: ripples[order],
            lambda index: f"near the background {self.variable} = {self.background:g}",
        )

    def check_state(self, state: Array) -> None:
        """Refuse a state for which a formula has no value."""
        unknown = np.full(state.shape[1], np.nan)
        self._refuse_singular(
            self._inputs(np.nan, unknown, state),
            lambda values, order: unknown,
            lambda index: f"where {self.variable} = {state[0, index]:g} in the state",
        )

    def check_grid(self, grid: Grid) -> None:
        """Refuse a grid on which a formula has no value at t = 0."""
        unknown = np.full(grid.size, np.nan)
        self._refuse_singular(
            self._inputs(0.0, grid.x, np.full((len(self.variables), grid.size), np.nan)),
            lambda values, order: unknown,
            lambda index: f"at x = {grid.x[index]:g}, t = 0",
        )

    def _refuse_singular(
        self, inputs: Mapping[str, Array | float], derivative: Callable[[Array, int], Array], where: Callable[[int], str]
    ) -> None:
        size = np.size(inputs["x"])
        for which, program in self._programs.items():
            program.refuse_singular(program.evaluate(size, inputs, derivative), f"CustomEquation.{which}", where)

    def densities(self, state: Array, second_difference: SecondDifference) -> dict[str, Array]:
        """Those of what is conserved, of a state of shape (components, N)."""
        integrals = super().densities(state, second_difference)
        return integrals if self.source else integrals | self._energy(state, second_difference)

    def _energy(self, state: Array, second_difference: SecondDifference) -> dict[str, Array]:
        flux = self.dispersive_flux
        if flux is None or flux.variational_constant is None:
            return {}
        stored = flux.energy_parts(state[0], second_difference(flux.g_values(state[0])))
        return {"energy": np.array([*stored, 0.5 * state[1] ** 2]) if self.two_way else -stored}


class FormulaLinearization:
    """The exact derivatives of the formulas of an equation; see `mol_compactons.equations.base.Linearization`.

    Parameters
    ----------
    equation : CustomEquation
        Whose formulas.
    stencils : mapping
        For each order of derivative the coefficients, shape (2 r + 1,).
    """

    def __init__(self, equation: CustomEquation, stencils: Mapping[int, Array]) -> None:
        self._equation, self._stencils = equation, stencils
        self.reach = max(program.reach(stencils) for program in equation._programs.values())

    def flux(self, t: float, x: Array, state: Array) -> Array:
        """The cyclic diagonals of dF/dy, shape (components, 2 R + 1, N)."""
        return self._diagonals(self._equation._programs["flux"], t, x, state)

    def source(self, t: float, x: Array, state: Array) -> Array | None:
        """The cyclic diagonals of ds/dy; None for no source."""
        program = self._equation._programs.get("source")
        return None if program is None else self._diagonals(program, t, x, state)

    def _diagonals(self, program: Program, t: float, x: Array, state: Array) -> Array:
        values = program.evaluate(x.size, self._equation._inputs(t, x, state), self._difference)
        return program.diagonals(values, self._stencils, self._equation.variables)

    def _difference(self, values: Array, order: int) -> Array:
        result = np.empty_like(values)
        convolve(self._stencils[order], values, result)
        return result


def _words(text: str) -> list[str]:
    """The names in a text."""
    spaced = "".join(character if character.isalnum() or character == "_" else " " for character in text)
    return spaced.split()
