"""Which order and which viscosity in grid units the conservative scheme wants: `python -m benchmarks.robustness`.

Prints the tables of docs/schemes.md: one compacton against its exact solution, and two compactons of the speeds 1 and 1/4,
bright and bright or bright and dark, on two grids. Dark-dark pairs are bright-bright ones turned over. Takes about
half an hour. With --k22, in two minutes: the least viscosity with which three waves of the classical K(2, 2) survive.
"""

from __future__ import annotations

import sys
from typing import Literal

import numpy as np
import xarray as xr

from mol_compactons import (
    Compacton,
    ConservativeScheme,
    GranularCompacton,
    Grid,
    IntegrationError,
    RosenauHyman,
    Rosenbrock,
    Simulation,
    run,
)
from mol_compactons.analysis.drift import drift

Order = Literal[2, 4, 6]

ORDERS: tuple[Order, ...] = (2, 4, 6)
DAMPINGS: tuple[tuple[Literal[4, 6], float], ...] = ((4, 0.0), (4, 0.1), (4, 1.0), (6, 0.01), (6, 0.03), (6, 0.1))
"""The order p of the viscosity, and nu in nu h^(p-1)."""

BOXES = {3.0: (60, 8, 18), 2.0: (60, 8, 20), 1.5: (80, 12, 30)}
"""For each n: the length of the box, and the centres of the fast and the slow wave."""


def single(n: float, order: Order, size: int) -> tuple[float, int]:
    """The relative L2 error of one compacton of speed 1 at t = 14 without viscosity, and the evaluations it took."""
    simulation = Simulation(
        equation=GranularCompacton(n),
        grid=Grid(length=40 if n < 2 else 30, size=size),
        scheme=ConservativeScheme(order),
        initial=[Compacton(speed=1, center=10)],
        t_end=14,
        frames=2,
        integrator=Rosenbrock(rtol=1e-4),
    )
    dataset = run(simulation)
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, 14)[0]
    error = np.linalg.norm(dataset.W.values[-1] - exact) / np.linalg.norm(exact)
    return float(error), int(dataset.attrs["solver_evaluations"])


def collision(n: float, sign: int, order: Order, damping: tuple[Literal[4, 6], float], size: int) -> xr.Dataset:
    """Two compactons until t = 40, when the fast one is well ahead."""
    length, fast, slow = BOXES[n]
    simulation = Simulation(
        equation=GranularCompacton(n),
        grid=Grid(length=length, size=size),
        scheme=ConservativeScheme(order, grid_viscosity=damping[1], viscosity_order=damping[0]),
        initial=[Compacton(speed=1, center=fast), Compacton(speed=1 / 4, center=slow, sign=sign)],
        t_end=40,
        frames=41,
        integrator=Rosenbrock(rtol=1e-4, max_steps=5_000),
    )
    return run(simulation)


def main() -> None:
    """Print the tables in Markdown."""
    print("| n | N | order 2 | order 4 | order 6 | evaluations |\n|---|---|---|---|---|---|")
    for n in BOXES:
        for size in (150, 300, 600):
            results = [single(n, order, size) for order in ORDERS]
            errors = " | ".join(f"{error:.1e}" for error, _ in results)
            print(f"| {n:g} | {size} | {errors} | {', '.join(str(count) for _, count in results)} |", flush=True)
    print("\n| n | pair | order | p | nu | heights, N = 600 | heights, N = 1200 | 600 against 1200 | Q lost | evaluations |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for n in BOXES:
        for sign, pair in ((1, "bright-bright"), (-1, "bright-dark")):
            for order in ORDERS:
                for damping in DAMPINGS:
                    power, amount = damping
                    start = f"| {n:g} | {pair} | {order} | {power} | {amount:g} |"
                    print(f"{start} {row(n, sign, order, damping)} |", flush=True)


def survives(size: int, amount: float) -> bool:
    """Whether compactons of K(2, 2) with the speeds 3, 2 and 1 in a box of 110 reach t = 60."""
    simulation = Simulation(
        equation=RosenauHyman(2, 2),
        grid=Grid(length=110, size=size),
        scheme=ConservativeScheme(4, grid_viscosity=amount, viscosity_order=6),
        initial=[Compacton(3, 10), Compacton(2, 25), Compacton(1, 40)],
        t_end=60,
        frames=2,
        integrator=Rosenbrock(rtol=1e-4),
    )
    try:
        run(simulation)
    except IntegrationError:
        return False
    return True


def least_viscosities() -> None:
    """Print, for each grid, the least nu / speed of a ladder of powers of 2 that survives, beside the default."""
    print("| N | h | least nu / 3 | default nu / 3, 0.01 / h^2 |\n|---|---|---|---|")
    for size in (275, 550, 1100):
        least, amount = float("nan"), 4.0
        while survives(size, 3 * amount):
            least, amount = amount, amount / 2
        print(f"| {size} | {110 / size:g} | {least:.4g} | {0.01 * (size / 110) ** 2:.4g} |", flush=True)


def row(n: float, sign: int, order: Order, damping: tuple[Literal[4, 6], float]) -> str:
    """The measured columns of one line of the second table."""
    try:
        coarse, fine = (collision(n, sign, order, damping, size) for size in (600, 1200))
    except IntegrationError as error:
        return f"{error} | | | |"
    last, finer = coarse.W.values[-1], fine.W.values[-1]
    difference = np.linalg.norm(last - finer[::2]) / np.linalg.norm(last)
    lost = ", ".join(f"{-float(drift(dataset).momentum[-1]):.1e}" for dataset in (coarse, fine))
    counts = ", ".join(str(dataset.attrs["solver_evaluations"]) for dataset in (coarse, fine))
    heights = " | ".join(f"{frame.max():.4f}, {frame.min():.4f}" for frame in (last, finer))
    return f"{heights} | {difference:.1e} | {lost} | {counts}"


if __name__ == "__main__":
    least_viscosities() if "--k22" in sys.argv[1:] else main()
