"""Families of runs that differ in one thing at a time: grid, scheme, viscosity, tolerance."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from typing import Any, Literal

from mol_compactons.configuration import check
from mol_compactons.errors import InputError, IntegrationError, require
from mol_compactons.grid import Grid
from mol_compactons.integrators import CVODE, IDA, Midpoint, Symplectic
from mol_compactons.schemes import CompactScheme, ConservativeScheme, FourierScheme
from mol_compactons.schemes.compact import SECOND_DIFFERENCES
from mol_compactons.simulation import Integrator, Simulation

CONSERVATIVE, VISCOUS, INVISCID = "conservative", "viscous", "inviscid"
"""The limits: viscosity nu h^(p-1) that vanishes with the grid; fixed while h -> 0, and then eps -> 0; none at all."""

GridScheme = CompactScheme | ConservativeScheme | FourierScheme
"""The schemes that have a grid to refine."""

Notice = Callable[[str], None]
"""Called with one line about each member that has run."""


@dataclass(frozen=True)
class Member:
    """One run of a family.

    Parameters
    ----------
    limit : str
        "conservative", "viscous" or "inviscid".
    scheme : str
        The scheme, without its viscosity.
    viscosity, tolerance : float
        In the units of the limit, and in those of the integrator.
    simulation : Simulation
        What is run.
    """

    limit: str
    scheme: str
    viscosity: float
    tolerance: float
    simulation: Simulation

    @property
    def size(self) -> int:
        """The number of grid points."""
        return self.simulation.grid.size

    @property
    def label(self) -> str:
        """One line that tells it from the others."""
        return f"{self.limit} {self.scheme} N={self.size} viscosity={self.viscosity:g} tolerance={self.tolerance:g}"


@dataclass(frozen=True)
class Family:
    """Which runs a convergence study makes of one simulation.

    Every scheme runs on every grid with every viscosity at the tightest tolerance, and on the finest grid with the smallest
    viscosity at each of the other tolerances. What is left empty is chosen from the simulation.

    Parameters
    ----------
    sizes : tuple of int
        Numbers of grid points; by default a quarter, half and all of the simulation's.
    schemes : tuple of schemes
        By default the simulation's and one of another kind. Their own viscosity does not count.
    viscosities : tuple of float
        Coefficients eps, kept fixed while the grid is refined: the viscous limit.
    grid_viscosities : tuple of float
        Coefficients nu in grid units: the conservative limit. By default twice and once the viscosity of the simulation, in
        the units in which it has one.
    tolerances : tuple of float
        Relative tolerances, with which an absolute one goes along, or steps of `Midpoint`; by default ten times and once
        that of the simulation, for steps twice.
    accuracy : float
        The relative error below which a quantity may be called converged.

    Raises
    ------
    InputError
        If a value is out of range or stands twice.
    """

    sizes: tuple[int, ...] = ()
    schemes: tuple[GridScheme, ...] = ()
    viscosities: tuple[float, ...] = ()
    grid_viscosities: tuple[float, ...] = ()
    tolerances: tuple[float, ...] = ()
    accuracy: float = 0.01

    def __post_init__(self) -> None:
        check(self)
        for name in ("sizes", "schemes", "viscosities", "grid_viscosities", "tolerances"):
            values = getattr(self, name)
            require(
                len(set(values)) == len(values), f"{name} = {', '.join(map(str, values))} holds a value twice; give each once."
            )
        require(
            min(self.viscosities + self.grid_viscosities, default=0) >= 0,
            "A viscosity of the family is negative; give positive ones, or 0 for none.",
        )
        require(min(self.tolerances, default=1) > 0, "A tolerance of the family is not positive; give positive ones.")
        require(0 < self.accuracy < 1, f"accuracy = {self.accuracy:g} must lie between 0 and 1; 0.01 is one per cent.")

    def completed(self, simulation: Simulation) -> Family:
        """The family with nothing left empty, sizes ascending, viscosities and tolerances descending.

        Raises
        ------
        InputError
            If the simulation has no grid to refine.
        """
        scheme, integrator = simulation.scheme, simulation.integrator
        if (
            isinstance(integrator, Symplectic)
            or not isinstance(simulation.grid, Grid)
            or not isinstance(scheme, CompactScheme | ConservativeScheme | FourierScheme)
        ):
            raise InputError("A chain has no grid to refine: converge is for equations on a Grid.")
        size = simulation.grid.size
        stepping = isinstance(integrator, Midpoint)
        tolerance = integrator.step if isinstance(integrator, Midpoint) else integrator.rtol
        tolerances = self.tolerances or (tolerance * (2 if stepping else 10), tolerance)
        viscosities, grid_viscosities = self.viscosities, self.grid_viscosities
        if not viscosities and not grid_viscosities:
            viscosities = (2 * scheme.viscosity, scheme.viscosity) if scheme.viscosity else ()
            grid_viscosities = (2 * scheme.grid_viscosity, scheme.grid_viscosity) if scheme.grid_viscosity else ()
        return replace(
            self,
            sizes=tuple(sorted(self.sizes or (size // 4, size // 2, size))),
            schemes=self.schemes or _with_another_kind(simulation),
            viscosities=tuple(sorted(viscosities, reverse=True)),
            grid_viscosities=tuple(sorted(grid_viscosities, reverse=True)),
            tolerances=tuple(sorted(tolerances, reverse=True)),
        )

    @property
    def limits(self) -> dict[str, tuple[float, ...]]:
        """The limits that the family approaches, and the viscosities of each."""
        limits = {CONSERVATIVE: self.grid_viscosities, VISCOUS: self.viscosities}
        return {limit: values for limit, values in limits.items() if values} or {INVISCID: (0.0,)}

    def members(self, simulation: Simulation) -> Iterator[Member]:
        """The runs, coarse grids first; of a family that is complete."""
        for limit, viscosities in self.limits.items():
            for scheme in self.schemes:
                for size in self.sizes:
                    for viscosity in viscosities:
                        every = size == self.sizes[-1] and viscosity == viscosities[-1]
                        for tolerance in self.tolerances if every else self.tolerances[-1:]:
                            yield _member(simulation, limit, scheme, size, viscosity, tolerance)


def _with_another_kind(simulation: Simulation) -> tuple[GridScheme, ...]:
    """The scheme of a simulation and one that shares nothing with it but the equation, and stands what it stands."""
    scheme: Any = simulation.scheme
    power: Literal[4, 6] = 6 if scheme.viscosity_order == 6 else 4
    others: tuple[Any, ...] = (ConservativeScheme(order=4, viscosity_order=power),)
    if isinstance(scheme, ConservativeScheme):
        spectral = FourierScheme(dealias=False, viscosity_order=power)
        compact = CompactScheme("wide", viscosity_order=power)
        others = (spectral, compact) if scheme.grid_viscosity else (compact,)
    for other in others:
        try:
            other.discretize(simulation.equation, simulation.grid)
        except InputError:
            continue
        return (scheme, other)
    return (scheme,)


def describe_scheme(scheme: Any) -> str:
    """A scheme in one word and its discrete choices, without its viscosity: "ConservativeScheme(order=4)"."""
    usual = {"viscosity", "grid_viscosity"} | ({"viscosity_order"} if scheme.viscosity_order == 4 else set())
    choices = [f"{field.name}={getattr(scheme, field.name)}" for field in fields(scheme) if field.name not in usual]
    return f"{type(scheme).__name__}({', '.join(choices)})"


def formal_order(scheme: Any) -> float:
    """The power of h at which the error of a scheme falls on smooth waves; that of a Fourier scheme is taken for 6."""
    if isinstance(scheme, ConservativeScheme):
        return scheme.order
    return 6.0 if isinstance(scheme, FourierScheme) else SECOND_DIFFERENCES[scheme.second_difference].order


def _member(simulation: Simulation, limit: str, scheme: Any, size: int, viscosity: float, tolerance: float) -> Member:
    amounts = {"viscosity": 0.0, "grid_viscosity": 0.0}
    amounts["grid_viscosity" if limit == CONSERVATIVE else "viscosity"] = viscosity
    scheme = replace(scheme, **amounts)
    grid = replace(simulation.grid, size=size)
    integrator = _integrator(simulation.integrator, scheme, simulation.equation, grid, tolerance)
    member = replace(simulation, scheme=scheme, grid=grid, integrator=integrator)
    return Member(limit, describe_scheme(scheme), viscosity, tolerance, member)


def _integrator(integrator: Integrator, scheme: Any, equation: Any, grid: Any, tolerance: float) -> Integrator:
    """The integrator of the simulation with another tolerance or, where it cannot take the scheme, one that can."""
    if isinstance(integrator, Midpoint):
        return replace(integrator, step=tolerance)
    assert not isinstance(integrator, Symplectic)
    atol = None if integrator.atol is None else integrator.atol * tolerance / integrator.rtol
    own = replace(integrator, rtol=tolerance, atol=atol)
    system = scheme.discretize(equation, grid)
    step, steps = own.max_step, own.max_steps
    for candidate in (
        own,
        CVODE(rtol=tolerance, atol=atol, max_step=step, max_steps=steps),
        CVODE(rtol=tolerance, atol=atol, max_step=step, max_steps=steps, linear_solver="krylov"),
        IDA(rtol=tolerance, atol=atol, max_step=step, max_steps=steps),
    ):
        try:
            candidate.check_system(system)
        except InputError:
            continue
        return candidate
    raise IntegrationError(f"No integrator can take {describe_scheme(scheme)}.", 0.0)
