"""What a tolerance buys: `python -m benchmarks.tolerances [--only TEXT]`, about ten minutes.

For each scheme and each integrator that can be had together: the relative L2 error in time, against the same
semi-discretisation taken through time by an explicit method of order 8 at a tolerance of 3e-13, on one compacton with a kink
(n = 3), on a smooth wave, and on a collision of compactons. An adaptive method is run at rtol = 1e-3 to 1e-6; printed are the
errors and by what factor they fell. A method with a fixed step is run with three steps that resolve the ripples of the grid,
each half of the one before (on a chain with five); printed is the observed order.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853

from benchmarks.orders import relative_error
from mol_compactons import (
    CVODE,
    IDA,
    CentralScheme,
    Compacton,
    CompactScheme,
    ConservativeScheme,
    FourierScheme,
    GaussLegendre,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    Lattice,
    Midpoint,
    PadeScheme,
    PeriodicWave,
    PowerContact,
    RosenauHyman,
    Rosenbrock,
    Simulation,
    SolitaryWave,
    Symplectic,
)
from mol_compactons.integrators.base import Integrator
from mol_compactons.schemes.base import Scheme
from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]

RTOLS = (1e-3, 1e-4, 1e-5, 1e-6)
"""A thousandfold; the error should fall at least a hundredfold."""

LEAST_FALL = 100.0

HALVINGS = (1, 2, 4)

CHAIN_HALVINGS = (1, 2, 4, 8, 16)
"""A wave of a chain is a few grains wide, so that a long step does not resolve it, and short ones cost little."""

SCATTER = 0.5
"""How far an observed order may be below that of the method."""

CONTACT_SCATTER = 1.0
"""The same where contacts open: what each leaves depends on where in a step it opens."""

FLOOR = 1e-9
"""Errors below this are those of the reference, or of Newton's method."""

REFERENCE_TOLERANCE = 3e-13

STENCILS: tuple[tuple[str, Literal["de_frutos", "ismail_taha", "pade_6", "pade_8"]], ...] = (
    ("de Frutos", "de_frutos"),
    ("Ismail-Taha", "ismail_taha"),
    ("Pade-6", "pade_6"),
    ("Pade-8", "pade_8"),
)
"""The stencils of the literature by the names of the table."""

FRAMES = 11
"""The limit of steps of an integrator is for the time between two."""

ADAPTIVE: tuple[Integrator, ...] = (
    IDA(),
    IDA(linear_solver="sparse"),
    CVODE(),
    CVODE(linear_solver="krylov"),
    CVODE(method="Adams"),
    Rosenbrock(),
)
FIXED: dict[Integrator, int] = {
    Midpoint(): 2,
    Midpoint(order=4): 4,
    Midpoint(order=6): 6,
    Midpoint(points=2): 2,
    GaussLegendre(order=4): 4,
    GaussLegendre(order=6): 6,
    Symplectic(order=2): 2,
    Symplectic(order=4): 4,
    Symplectic(order=6): 6,
}
"""The methods with a fixed step, and the orders of their errors."""

FIRST_STEPS = {2: 0.5, 4: 2.0, 6: 3.0}
"""The longest step by the order, relative to the time of the fastest ripple."""


@dataclass(frozen=True)
class Problem:
    """A run whose error in time is asked for."""

    name: str
    simulation: Simulation
    contact_order: float = np.inf
    """The order that a law of contact without enough derivatives allows: n + 1 where contacts open, as the force goes
    like the n-th power of the time."""

    def reference(self) -> Array:
        """The state at the end, by an explicit method of order 8."""
        system, start = self.simulation.discretize(), self.simulation.initial_state()

        def rate(t: float, state: Array) -> Array:
            return system.rate(t, state.reshape(start.shape)).ravel()

        smallest = 1e-2 * REFERENCE_TOLERANCE * float(np.abs(start).max())
        solver = DOP853(rate, 0.0, start.ravel(), self.simulation.t_end, rtol=REFERENCE_TOLERANCE, atol=smallest)
        while solver.status == "running":
            solver.step()
        return np.asarray(solver.y.reshape(start.shape))

    def error(self, integrator: Integrator, reference: Array) -> float:
        """The relative L2 error at the end."""
        simulation = self.simulation
        run = integrator.start(simulation.discretize(), simulation.initial_state(), simulation.t_end)
        for t in simulation.times[1:]:
            final = run.advance(float(t))
        return relative_error(final, reference)

    def errors(self, integrator: Integrator, reference: Array) -> list[float]:
        """The errors at the tolerances, or with the steps, of an integrator, from the loosest."""
        if integrator in FIXED:
            longest = FIRST_STEPS[FIXED[integrator]] * shortest_time(self.simulation)
            halvings = CHAIN_HALVINGS if isinstance(self.simulation.grid, Lattice) else HALVINGS
            ladder: Sequence[float] = [longest / halving for halving in halvings]
        else:
            ladder = RTOLS
        return [self.error(integrator.with_tolerance(step), reference) for step in ladder]

    def order(self, integrator: Integrator, errors: Sequence[float]) -> float:
        """The order that the errors show: the last halving, or all of them where contacts open."""
        limited = FIXED[integrator] > self.contact_order
        return observed_order([errors[0], errors[-1]]) / (len(errors) - 1) if limited else observed_order(errors)

    def follows(self, integrator: Integrator, errors: Sequence[float]) -> bool:
        """Whether the errors fall a hundredfold from the loosest tolerance to the tightest, or at the order there is."""
        if errors[-1] < FLOOR:
            return True
        if integrator not in FIXED:
            return errors[0] / errors[-1] >= LEAST_FALL
        limited = FIXED[integrator] > self.contact_order
        expected = self.contact_order - CONTACT_SCATTER if limited else FIXED[integrator] - SCATTER
        return self.order(integrator, errors) > expected

    def shown(self, integrator: Integrator, errors: Sequence[float]) -> str:
        """By what factor the errors fell, or their order; marked where that is not enough."""
        told = f"order {self.order(integrator, errors):.1f}" if integrator in FIXED else f"{errors[0] / errors[-1]:.0f}-fold"
        return told if self.follows(integrator, errors) else f"{told} (!)"


def shortest_time(simulation: Simulation) -> float:
    """The reciprocal of a bound of |M^-1 df/dy| at the start, from its largest row sum; for an oscillator, of its root."""
    system: SemiDiscretization = simulation.discretize()
    diagonals = np.empty_like(system.mass_diagonals)
    system.jacobian(0.0, simulation.initial_state(), diagonals)
    fastest = float(np.abs(diagonals).sum(axis=(1, 2)).max())
    if system.mass is not None:
        # The shortest ripple has the smallest symbol of M.
        fastest /= abs(float(system.mass @ np.cos(np.pi * np.arange(system.mass.size))))
    return fastest**-0.5 if system.split_steps is not None else 1 / fastest


def observed_order(errors: Sequence[float]) -> float:
    """The order that the last of the errors above the floor show, when each step is half of the one before."""
    known = [error for error in errors if error > FLOOR]
    return float(np.log2(known[-2] / known[-1])) if len(known) > 1 else np.inf


def problems(scheme: Scheme) -> Iterator[Problem]:
    """The three waves of n = 3; the compact scheme without damping does not survive the last, whatever the integrator.

    The Fourier scheme without damping is for smooth waves: with the ripples of an edge CVODE comes to its limit of steps.
    """
    equation = GranularCompacton(3)
    integrator = CVODE(linear_solver="krylov") if isinstance(scheme, FourierScheme) else IDA()

    def problem(name: str, grid: Grid, waves: Sequence[Compacton | PeriodicWave], t_end: float) -> Problem:
        return Problem(name, Simulation(equation, grid, waves, t_end, scheme=scheme, integrator=integrator, frames=FRAMES))

    if not isinstance(scheme, FourierScheme) or any(scheme.viscosities):
        yield problem("compacton", Grid(30, 80), [Compacton(1, 10)], 5)
    yield problem("smooth", Grid(2 * np.pi, 32), [PeriodicWave(1, crest=float(np.sqrt(1.5)))], 2)
    if not isinstance(scheme, CompactScheme | FourierScheme) or any(scheme.viscosities):
        yield problem("collision", Grid(30, 80), [Compacton(2, 8), Compacton(0.5, 15)], 8)


def of_other_equations() -> Iterator[tuple[str, list[Problem]]]:
    """K(2, 2) with its default scheme and with the stencils of the literature, and two chains."""
    one, two = [Compacton(1, 15)], [Compacton(1, 12), Compacton(0.5, 26)]
    grid = Grid(40, 100)
    damped: dict[str, Any] = {"grid_viscosity": 0.0625, "viscosity_order": 6}
    choices: list[tuple[str, dict[str, Any]]] = [("K(2, 2), default", {})]
    choices += [(f"K(2, 2), {title}, damped", {"scheme": PadeScheme(name, **damped)}) for title, name in STENCILS]
    for name, chosen in choices:
        yield (
            name,
            [
                Problem(kind, Simulation(RosenauHyman(2, 2), grid, waves, t_end, frames=FRAMES, **chosen))
                for kind, waves, t_end in (("compacton", one, 5), ("collision", two, 40))
            ],
        )
    yield "chain, Hertz", chain_problems(PowerContact(1.5), speed=1, contact_order=2.5)
    yield "chain, prestressed", chain_problems(PowerContact(3, linear=1), speed=1.3)


def chain_problems(law: PowerContact, speed: float, contact_order: float = np.inf) -> list[Problem]:
    """A wave, and two that meet head-on, after which contacts open where nothing holds the grains together."""
    right, left = SolitaryWave(speed, 15), SolitaryWave(-speed, 45)

    def simulated(waves: list[SolitaryWave], t_end: float) -> Simulation:
        return Simulation(GranularChain(law), Lattice(60), waves, t_end=t_end, frames=FRAMES)

    return [
        Problem("wave", simulated([right], 20)),
        Problem("head-on", simulated([right, left], 25), contact_order),
    ]


def granular_schemes() -> Iterator[tuple[str, Scheme]]:
    """Each scheme of the granular compacton equation, without damping where it survives, and with the default amount."""
    damped: dict[str, Any] = {"grid_viscosity": 0.03, "viscosity_order": 6}
    orders: tuple[Literal[2, 4, 6], ...] = (2, 4, 6)
    for order in orders:
        yield f"conservative, order {order}", ConservativeScheme(order)
    yield "compact, wide", CompactScheme("wide")
    yield "Fourier", FourierScheme()
    yield "conservative, order 2, damped", ConservativeScheme(2, **damped)
    yield "conservative, order 4, damped", ConservativeScheme(4, **damped)
    yield "compact, wide, damped", CompactScheme("wide", **damped)
    yield "compact, nearest, damped", CompactScheme("nearest", **damped)
    yield "compact, five-point, damped", CompactScheme("five_point", **damped)
    yield "central, order 4, damped", CentralScheme(4, **damped)
    yield "Fourier, damped", FourierScheme(**damped)


def families() -> Iterator[tuple[str, list[Problem]]]:
    """What is discretised in one way, under its name."""
    for name, scheme in granular_schemes():
        yield name, list(problems(scheme))
    yield from of_other_equations()


def described(integrator: Integrator) -> str:
    """An integrator with the settings that tell it from the others."""
    default = type(integrator)()
    names = [name for name in ("linear_solver", "method", "order", "points") if hasattr(integrator, name)]
    told = [f"{name}={getattr(integrator, name)!r}" for name in names if getattr(integrator, name) != getattr(default, name)]
    return f"{type(integrator).__name__}({', '.join(told)})"


def refusal(integrator: Integrator, problem: Problem) -> str | None:
    """Why a pair is refused; None if it is not."""
    try:
        replace(problem.simulation, integrator=integrator)
    except InputError as sentence:
        return str(sentence)
    return None


def show(name: str, cases: list[Problem]) -> dict[Integrator, list[list[float]]]:
    """Print the table of one discretisation; the errors of every integrator that it is offered with, for each wave."""
    print(f"\n### {name}\n\n| integrator | {' | '.join(case.name for case in cases)} |\n|---|{'---|' * len(cases)}")
    references = [case.reference() for case in cases]
    known = {}
    for integrator in (*ADAPTIVE, *FIXED):
        if refusal(integrator, cases[0]):
            continue
        known[integrator] = [case.errors(integrator, reference) for case, reference in zip(cases, references, strict=True)]
        cells = [
            f"{' '.join(f'{error:.0e}' for error in errors)}, {case.shown(integrator, errors)}"
            for case, errors in zip(cases, known[integrator], strict=True)
        ]
        print(f"| {described(integrator)} | {' | '.join(cells)} |", flush=True)
    return known


Tables = dict[str, tuple[list[Problem], dict[Integrator, list[list[float]]]]]
"""The waves of each discretisation, and the errors of every integrator that it is offered with, for each wave."""


def summary(tables: Tables) -> list[str]:
    """For each discretisation and integrator the wave whose error follows least."""
    rows = ["| discretisation | " + " | ".join(described(one) for one in (*ADAPTIVE, *FIXED)) + " |"]
    rows.append(f"|---|{'---|' * (len(ADAPTIVE) + len(FIXED))}")
    for name, (cases, known) in tables.items():
        cells = [least_following(one, cases, known[one]) if one in known else "refused" for one in (*ADAPTIVE, *FIXED)]
        rows.append(f"| {name} | {' | '.join(cells)} |")
    return rows


def least_following(integrator: Integrator, cases: list[Problem], errors: list[list[float]]) -> str:
    """What is shown of the wave whose error follows least."""

    def measure(index: int) -> float:
        one = errors[index]
        return cases[index].order(integrator, one) if integrator in FIXED else one[0] / one[-1]

    least = min(range(len(cases)), key=measure)
    return cases[least].shown(integrator, errors[least])


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables; 1 if a pair does not follow its tolerance."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.tolerances", description=__doc__)
    parser.add_argument("--only", default="", metavar="TEXT", help="only the discretisations whose name has this text")
    only = parser.parse_args(arguments).only
    tables = {name: (cases, show(name, cases)) for name, cases in families() if only in name}
    print("", *summary(tables), sep="\n")
    all_follow = all(
        case.follows(integrator, errors)
        for cases, known in tables.values()
        for integrator, waves in known.items()
        for case, errors in zip(cases, waves, strict=True)
    )
    return 0 if all_follow else 1


if __name__ == "__main__":
    sys.exit(main())
