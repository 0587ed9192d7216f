"""Families of runs that differ in one thing at a time: grid, scheme, viscosity, tolerance."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from mol_compactons.configuration import Settings
from mol_compactons.errors import InputError, IntegrationError, require
from mol_compactons.integrators.base import Integrator
from mol_compactons.schemes.base import Scheme
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.simulation import Simulation

CONSERVATIVE, VISCOUS, INVISCID = "conservative", "viscous", "inviscid"
"""The limits: viscosity nu h^(p-1) that vanishes with the grid; fixed while h -> 0, and then eps -> 0; none at all."""

Notice = Callable[[str], None]
"""Called with one line about each member that has run."""


class Cell(NamedTuple):
    """The place of a member in its family: limit, scheme without its viscosity, number of points, viscosity, tolerance."""

    limit: str
    scheme: str
    size: int
    viscosity: float
    tolerance: float

    @property
    def label(self) -> str:
        """One line that tells it from the others."""
        return f"{self.limit} {self.scheme} N={self.size} viscosity={self.viscosity:.12g} tolerance={self.tolerance:.12g}"


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
    def cell(self) -> Cell:
        """Its place in the family."""
        return Cell(self.limit, self.scheme, self.size, self.viscosity, self.tolerance)

    def is_independent_of(self, other: Member) -> bool:
        """Whether its scheme is of another kind than that of the other."""
        return self.simulation.scheme.is_independent_of(other.simulation.scheme)

    @property
    def label(self) -> str:
        """One line that tells it from the others."""
        return self.cell.label


@dataclass(frozen=True)
class Family(Settings):
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
        Relative tolerances, with which an absolute one goes along, or steps of `Midpoint` and its like; by default ten times
        and once that of the simulation, for steps twice. A step is the one that is taken: a fixed one is cut to fit between
        two frames.
    accuracy : float
        The relative error below which a quantity may be called converged.

    Raises
    ------
    InputError
        If a value is out of range or stands twice.
    """

    sizes: tuple[int, ...] = ()
    schemes: tuple[Scheme, ...] = ()
    viscosities: tuple[float, ...] = ()
    grid_viscosities: tuple[float, ...] = ()
    tolerances: tuple[float, ...] = ()
    accuracy: float = 0.01

    def __post_init__(self) -> None:
        super().__post_init__()
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
            If a chain, which has no grid to refine, is asked for anything but tolerances, or if two steps are one and the
            same between the frames.
        """
        scheme, integrator, size = simulation.scheme, simulation.integrator, simulation.grid.size
        if not scheme.refines:
            only = {"sizes": (size,), "schemes": (scheme,), "viscosities": (), "grid_viscosities": ()}
            for name, own in only.items():
                require(
                    getattr(self, name) in ((), own),
                    f"{name} is not to be varied: a chain has no grid to refine and one scheme; vary tolerances alone.",
                )
            complete = replace(self, sizes=(size,), schemes=(scheme,))
        else:
            complete = self
        for one in complete.schemes:
            require(
                one.suits(simulation.equation) > 0,
                f"{type(one).__name__} does not suit {type(simulation.equation).__name__}; choose other schemes.",
            )
        interval = simulation.t_end / (simulation.frames - 1)
        tolerances = _taken(self.tolerances, integrator, interval) or _ladder(integrator, interval, 2 if scheme.refines else 3)
        viscosities, grid_viscosities = self.viscosities, self.grid_viscosities
        if not viscosities and not grid_viscosities:
            viscosities, grid_viscosities = ((2 * amount, amount) if amount else () for amount in scheme.viscosities)
        return replace(
            complete,
            sizes=tuple(sorted(complete.sizes or (size // 4, size // 2, size))),
            schemes=complete.schemes or _with_another_kind(simulation),
            viscosities=tuple(sorted(viscosities, reverse=True)),
            grid_viscosities=tuple(sorted(grid_viscosities, reverse=True)),
            tolerances=tuple(sorted(tolerances, reverse=True)),
        )

    @property
    def limits(self) -> dict[str, tuple[float, ...]]:
        """The limits that the family approaches, and the viscosities of each."""
        limits = {CONSERVATIVE: self.grid_viscosities, VISCOUS: self.viscosities}
        return {limit: values for limit, values in limits.items() if values} or {INVISCID: (0.0,)}

    def cells(self) -> Iterator[tuple[Cell, Scheme]]:
        """The places of its members, coarse grids first, each with its scheme; of a family that is complete."""
        for limit, viscosities in self.limits.items():
            for scheme in self.schemes:
                for size in self.sizes:
                    for viscosity in viscosities:
                        every = size == self.sizes[-1] and viscosity == viscosities[-1]
                        for tolerance in self.tolerances if every else self.tolerances[-1:]:
                            yield Cell(limit, scheme.label, size, viscosity, tolerance), scheme

    def members(self, simulation: Simulation) -> Iterator[Member]:
        """The runs, coarse grids first; of a family that is complete."""
        for cell, scheme in self.cells():
            yield _member(simulation, cell, scheme)


def _taken(tolerances: tuple[float, ...], integrator: Integrator, interval: float) -> tuple[float, ...]:
    """The tolerances or steps that runs have which are asked for these."""
    taken = tuple(integrator.with_tolerance(tolerance).taken(interval) for tolerance in tolerances)
    for index, one in enumerate(taken):
        require(
            not _is_among(one, taken[:index]),
            f"tolerances = {', '.join(f'{tolerance:g}' for tolerance in tolerances)} are not all different: fixed steps are "
            f"cut to fit between frames that are {interval:g} apart, and two of these come to {one:g}; choose others.",
        )
    return taken


def _ladder(integrator: Integrator, interval: float, count: int) -> tuple[float, ...]:
    """The tolerance of an integrator and looser ones; where these come to the same steps, tighter ones."""
    own, factor = integrator.taken(interval), integrator.coarsening
    ladder: list[float] = []
    for power in (*range(count), *range(-1, -count, -1)):
        one = integrator.with_tolerance(own * factor**power).taken(interval)
        if len(ladder) < count and not _is_among(one, ladder):
            ladder.append(one)
    return tuple(ladder)


def _is_among(tolerance: float, others: Sequence[float]) -> bool:
    return any(math.isclose(tolerance, other, rel_tol=1e-6) for other in others)


def _with_another_kind(simulation: Simulation) -> tuple[Scheme, ...]:
    """The scheme of a simulation and one that shares nothing with it but the equation, where there is one."""
    other = simulation.scheme.independent_alternative(simulation.equation, simulation.grid)
    try:
        if other is not None:
            other.with_viscosity(*simulation.scheme.viscosities).discretize(simulation.equation, simulation.grid)
    except InputError:
        other = None
    return (simulation.scheme,) if other is None else (simulation.scheme, other)


def _member(simulation: Simulation, cell: Cell, scheme: Scheme) -> Member:
    amounts = (0.0, cell.viscosity) if cell.limit == CONSERVATIVE else (cell.viscosity, 0.0)
    scheme = scheme.with_viscosity(*amounts)
    grid = replace(simulation.grid, size=cell.size)
    integrator = _integrator(simulation.integrator, scheme.discretize(simulation.equation, grid), cell.tolerance, scheme)
    member = replace(simulation, scheme=scheme, grid=grid, integrator=integrator)
    return Member(cell.limit, scheme.label, cell.viscosity, cell.tolerance, member)


def _integrator(integrator: Integrator, system: SemiDiscretization, tolerance: float, scheme: Scheme) -> Integrator:
    """The integrator of the simulation with another tolerance or, where it cannot take the system, one that can."""
    own = integrator.with_tolerance(tolerance)
    for candidate in (own, *own.alternatives()):
        try:
            candidate.check_system(system)
        except InputError:
            continue
        return candidate
    raise IntegrationError(f"No integrator can take {scheme.label}.", 0.0)
