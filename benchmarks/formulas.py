"""How accurate a compacton is whose equation is a formula: `python -m benchmarks.formulas`.

Prints the table of docs/formulas.md: the relative L2 error of one compacton of speed 1 on 400 points of a line of length 40
at t = 14, by `Rosenbrock(rtol=1e-6)`: the default scheme of formulas with and without its damping, and the compact scheme.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mol_compactons import (
    CentralScheme,
    Compacton,
    CompactScheme,
    CustomEquation,
    Equation,
    GranularCompacton,
    Grid,
    IntegrationError,
    RosenauHyman,
    Rosenbrock,
    Samples,
    Scheme,
    Simulation,
    run,
)

FORMULAS: dict[str, tuple[str, Equation]] = {
    "K(2, 2)": ("u**2 + d2(u**2)", RosenauHyman(2, 2)),
    "K(3, 3)": ("u**3 + d2(u**3)", RosenauHyman(3, 3)),
    "granular, n = 3/2": ("abs(u)**0.5*u + abs(u)**0.25*d2(abs(u)**0.25*u)", GranularCompacton(1.5)),
    "granular, n = 3": ("u**3 + u*d2(u**2)", GranularCompacton(3)),
}
"""The formulas, and the equations that have the same solutions and know their compactons."""

GRID, T_END = Grid(40, 400), 14.0


def error(formula: str, known: Equation, scheme: Scheme | None) -> str:
    """The relative L2 error at the end, or that there is none."""
    wave = Compacton(speed=1, center=12)
    start = wave.values(known, GRID)[0]
    simulation = Simulation(
        CustomEquation(formula), GRID, [Samples(start)], T_END, frames=2, integrator=Rosenbrock(rtol=1e-6, max_steps=10**6)
    )
    if scheme is not None:
        simulation = replace(simulation, scheme=scheme)
    try:
        end = run(simulation)["u"].values[-1]
    except IntegrationError:
        return "blows up"
    exact = wave.values(known, GRID, T_END)[0]
    return f"{float(np.linalg.norm(end - exact) / np.linalg.norm(exact)):.1e}"


def main() -> None:
    """Print the table in Markdown."""
    print('| formula of | `CentralScheme(4)`, default damping | the same, no damping | `CompactScheme("wide")`, no damping |')
    print("|---|---|---|---|")
    for name, (formula, known) in FORMULAS.items():
        schemes = (None, CentralScheme(4, grid_viscosity=0), CompactScheme(second_difference="wide", viscosity=0))
        print(f"| {name} | {' | '.join(error(formula, known, scheme) for scheme in schemes)} |", flush=True)


if __name__ == "__main__":
    main()
