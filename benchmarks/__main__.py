"""Speed at matched error, beside what a user would pick instead: `python -m benchmarks [W1 W2 W3 W4 W5 W6] [-o FOLDER]`.

Install the peers with `pip install .[bench]`. Each work item runs all its candidates in one process, one after the other and
that several times, each with the loosest of its settings that reaches the error asked for against a reference of another
make; printed are the least processor time of the repetitions, the ratio to the fastest of ours, the error, steps and
right-hand sides where they are counted. Tables go to FOLDER as CSV, and the error against the time of W1 and W5 as pictures.
All items take about half an hour, most of it for the references and py-pde.
"""

from __future__ import annotations

import argparse
import csv
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks import lammps_chain, peers
from benchmarks.matched_error import REPEATS, Candidate, Row, compare, described, measured, picture, show
from mol_compactons import (
    CVODE,
    IDA,
    Compacton,
    CompactScheme,
    ConservativeScheme,
    GranularChain,
    GranularCompacton,
    Grid,
    IntegrationError,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Rosenbrock,
    Simulation,
    SolitaryWave,
    Symplectic,
    run,
)
from mol_compactons.integrators.linear.newton import BandedMatrix

Array = NDArray[np.float64]


def counted(simulation: Simulation, variable: str = "W") -> tuple[Array, str]:
    """The last frame of one of our runs, and what it took."""
    dataset = run(simulation)
    return dataset[variable].values[-1], f"{dataset.attrs['solver_steps']} steps, {dataset.attrs['solver_evaluations']} f"


def compacton_run(speeds: Sequence[float], centers: Sequence[float], length: float, size: int, t_end: float) -> Simulation:
    """The paper's scheme with a viscosity of 1e-3 and ten frames for each unit of time."""
    return Simulation(
        equation=GranularCompacton(3),
        grid=Grid(length, size),
        scheme=CompactScheme("wide", 1e-3),
        initial=[Compacton(speed, center) for speed, center in zip(speeds, centers, strict=True)],
        t_end=t_end,
        frames=round(10 * t_end) + 1,
    )


def of_the_compact_scheme(simulation: Simulation, slow_peers: bool) -> tuple[list[Candidate], Array]:
    """All who can solve the paper's semi-discrete system, and its solution by an explicit method of high order."""
    grid, times = simulation.grid, simulation.times
    system = peers.CompactSystem(grid.length, grid.size, 1e-3)
    start = simulation.initial_state()[0]

    def ours(integrator: Any) -> tuple[Array, str]:
        return counted(replace(simulation, integrator=integrator))

    def theirs(
        solve: Callable[[peers.CompactSystem, Array, Array, float], peers.Result],
    ) -> Callable[[Any], tuple[Array, str]]:
        def last(setting: float) -> tuple[Array, str]:
            frames, counts = solve(system, start, times, setting)
            return frames[-1], counts

        return last

    tolerances = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6)
    candidates = [
        Candidate("ours, Rosenbrock", True, [Rosenbrock(rtol=rtol) for rtol in tolerances], ours),
        Candidate("ours, IDA", True, [IDA(rtol=rtol) for rtol in tolerances], ours),
        Candidate("ours, IDA, order 5", True, [IDA(rtol=rtol, max_order=5) for rtol in tolerances], ours),
        Candidate("CasADi IDAS", False, tolerances, theirs(peers.by_casadi)),
        Candidate("midpoint with splu", False, (0.02, 0.01, 0.005, 0.0025, 0.00125), theirs(peers.by_midpoint), 1),
    ]
    if slow_peers:
        tight = (1e-4, 1e-5, 1e-6, 1e-7)
        for method in ("LSODA", "BDF", "Radau"):
            candidates.append(Candidate(f"solve_ivp {method}", False, tight, theirs(peers.by_solve_ivp(method)), 1))
        candidates.append(Candidate("scikit-sundae IDA, dense", False, tight, theirs(peers.by_scikit_sundae), 1))
        candidates.append(Candidate("py-pde", False, (1e-5, 1e-6), theirs(peers.by_py_pde), 1))
    return candidates, peers.reference(system, start, times)[-1]


def single(folder: Path) -> None:
    """W1: one compacton, N = 600, L = 30, t = 14, 141 frames."""
    candidates, exact = of_the_compact_scheme(compacton_run((1,), (5.5,), 30, 600, 14), slow_peers=True)
    rows = compare("W1: one compacton, N = 600, t = 14", candidates, exact, 1e-5, folder, beyond=3)
    picture(rows, "W1: one compacton, N = 600, t = 14", folder / "W1.png")


def collision(folder: Path) -> None:
    """W2: two compactons, N = 1200, L = 60, t = 40, 401 frames."""
    candidates, exact = of_the_compact_scheme(compacton_run((1, 0.25), (5.5, 15.5), 60, 1200, 40), slow_peers=False)
    compare("W2: a collision, N = 1200, t = 40", candidates, exact, 1e-4, folder)


def scaling(folder: Path) -> None:
    """W3: the cost of an unknown and a step against N, each N in a process of its own."""
    print("\nW3: cost against N, the paper's scheme, t = 0.2")
    header = ("N", "solver", "steps", "microseconds / (N step)", "peak MB")
    print(f"\n| {' | '.join(header)} |\n|---|---|---|---|---|")
    rows = []
    for solver in ("IDA", "Rosenbrock"):
        for size in (600, 1200, 2400, 4800, 9600, 19200, 38400, 76800):
            command = [sys.executable, "-c", f"from benchmarks.__main__ import one_size; one_size({size}, '{solver}')"]
            line = subprocess.run(command, capture_output=True, text=True, check=True, env=os.environ).stdout
            rows.append([str(size), solver, *line.split()])
            print(f"| {' | '.join(rows[-1])} |", flush=True)
    with (folder / "W3.csv").open("w", newline="") as file:
        csv.writer(file).writerows([header, *rows])


def one_size(size: int, solver: str) -> None:
    """Print the last entries of a line of W3; the grid grows with N at the paper's spacing, so that the stiffness stays."""
    integrator = IDA(rtol=1e-5) if solver == "IDA" else Rosenbrock(rtol=1e-5)
    simulation = replace(compacton_run((1,), (5.5,), size / 20, size, 0.2), frames=2, integrator=integrator)
    run(replace(simulation, t_end=1e-4))
    datasets = [run(simulation) for _ in range(REPEATS)]
    steps = datasets[0].attrs["solver_steps"]
    cost = 1e6 * min(dataset.attrs["cpu_seconds"] for dataset in datasets) / steps / size
    print(f"{steps} {cost:.4f} {peak_megabytes():.0f}")


def peak_megabytes() -> float:
    """The most memory that this process had; `resource` would count that of the parent before the child began as well."""
    status = Path("/proc/self/status")
    if status.is_file():
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return int(line.split()[1]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def chains(folder: Path) -> None:
    """W4: the granular chain, 1,000 grains until t = 200 and 100,000 until t = 20, n = 3 and 3/2, against the exact wave."""
    for n in (3.0, 1.5):
        for size, t_end in ((1000, 200.0), (100_000, 20.0)):
            wave = SolitaryWave(speed=1, center=100)
            simulation = Simulation(
                equation=GranularChain(PowerContact(n)),
                grid=Lattice(size),
                scheme=NearestNeighbours(),
                initial=[wave],
                t_end=t_end,
                frames=2,
            )
            exact = wave.values(simulation.equation, simulation.grid, t_end)[0]
            start = simulation.initial_state().ravel()
            theirs = (1e-6, 3e-7, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9, 1e-10)
            candidates = [
                Candidate("ours, Symplectic, order 4", True, by_steps(simulation, 4), ours),
                Candidate("ours, Symplectic, order 6", True, by_steps(simulation, 6), ours),
                Candidate("solve_ivp DOP853, numpy", False, theirs, partial(by_scipy, n, start, t_end), 1),
                Candidate("Verlet, numba", False, (5e-3, 2e-3, 1e-3, 5e-4), partial(peers.by_verlet, n, start, t_end), 1),
            ]
            if n == 1.5 and size == 1000 and lammps_is_here():
                candidates.append(
                    Candidate("LAMMPS, gran/hertz", False, (2e-3, 1e-3, 5e-4), partial(by_lammps, wave, size, t_end), 1)
                )
            compare(f"W4 n={n:g} {size} grains: a solitary wave, t = {t_end:g}", candidates, exact, 1e-5, folder)


def by_steps(simulation: Simulation, order: Literal[4, 6]) -> list[Simulation]:
    """A chain by a splitting method with ever shorter steps."""
    steps = (0.6, 0.5, 0.4, 0.3, 0.25, 0.2, 0.15, 0.1, 0.05, 0.02, 0.01)
    return [replace(simulation, integrator=Symplectic(step, order), title=f"step {step:g}") for step in steps]


def ours(simulation: Simulation) -> tuple[Array, str]:
    """The last frame of a chain of ours."""
    return counted(simulation, "R")


def by_scipy(n: float, start: Array, t_end: float, rtol: float) -> tuple[Array, str]:
    """Scipy's DOP853 with a right-hand side in numpy."""
    from scipy.integrate import solve_ivp

    size = start.size // 2

    def rates(t: float, y: Array) -> Array:
        force = np.abs(y[:size]) ** (n - 1) * y[:size]
        return np.concatenate([y[size:], np.roll(force, 1) - 2 * force + np.roll(force, -1)])

    solution = solve_ivp(rates, (0, t_end), start, "DOP853", t_eval=[t_end], rtol=rtol, atol=rtol / 100)
    return solution.y[:size, -1], f"{solution.nfev} f"


def lammps_is_here() -> bool:
    """Whether LAMMPS can be loaded; it is no part of the extra, since its wheels want an MPI library beside them."""
    try:
        lammps_chain.load_lammps().close()
    except (ImportError, OSError) as error:
        print(f"  LAMMPS is left out: {error}", file=sys.stderr)
        return False
    return True


def by_lammps(wave: SolitaryWave, size: int, t_end: float, step: float) -> tuple[Array, str]:
    """The stresses of a free chain of Hertz's grains, whose ends the wave does not reach."""
    free = replace(lammps_chain.chain(1.5, size, t_end, step), initial=[wave])
    displacement = lammps_chain.hertz_by_lammps(free)
    return -np.diff(displacement, prepend=displacement[0]), f"{round(t_end / step)} f"


def schemes(folder: Path) -> None:
    """W5: one compacton, n = 3, t = 14: error against the exact solution for each of our schemes.

    Each has a tolerance below the error of its scheme, which is what is compared.
    """
    base = replace(compacton_run((1,), (5.5,), 30, 600, 14), frames=2)
    rows = []
    for name, scheme, size, integrator in (
        ("the paper's scheme and viscosity, IDA", CompactScheme("wide", 1e-3), 600, IDA(rtol=1e-2)),
        ("the same, Rosenbrock", CompactScheme("wide", 1e-3), 600, Rosenbrock(rtol=1e-2)),
        ("nearest, eps = 1e-5, IDA", CompactScheme("nearest", 1e-5), 600, IDA(rtol=1e-3)),
        ("conservative, order 6, N = 75, CVODE", ConservativeScheme(6), 75, CVODE(rtol=1e-2)),
        ("conservative, order 6, N = 75, Rosenbrock", ConservativeScheme(6), 75, Rosenbrock(rtol=1e-2)),
        ("conservative, order 6, N = 150, Rosenbrock", ConservativeScheme(6), 150, Rosenbrock(rtol=1e-3)),
        ("conservative, order 6, N = 300, CVODE", ConservativeScheme(6), 300, CVODE(rtol=1e-3)),
        ("conservative, order 6, N = 300, Rosenbrock", ConservativeScheme(6), 300, Rosenbrock(rtol=1e-3)),
    ):
        rows.append(against_the_wave(base, name, scheme, size, integrator))
    title = "W5: one compacton, n = 3, t = 14, against the exact solution"
    show(title, rows, folder)
    points = []
    for name, scheme in (
        ("ours, conservative, order 2", ConservativeScheme(2)),
        ("ours, conservative, order 4", ConservativeScheme(4)),
        ("ours, conservative, order 6", ConservativeScheme(6)),
        ("the paper's, eps = 1e-3", CompactScheme("wide", 1e-3)),
        ("compact, nearest, eps = 1e-5", CompactScheme("nearest", 1e-5)),
    ):
        for size in (75, 150, 300, 600, 1200):
            try:
                points.append(against_the_wave(base, name, scheme, size, Rosenbrock(rtol=1e-4)))
            except IntegrationError as error:
                print(f"  not in the picture: {name}, N = {size}: {error}", file=sys.stderr)
    picture(points, "W5: one compacton, t = 14, N = 75 to 1200, Rosenbrock", folder / "W5.png")


def kernels(folder: Path) -> None:
    """W6: what one right-hand side, Jacobian, factoring and solve cost on 1,200 points, in microseconds."""
    header = ("scheme", "n", "f", "Jacobian", "LU", "solve")
    rows = []
    for scheme in (CompactScheme("wide", 1e-3), ConservativeScheme(2), ConservativeScheme(4), ConservativeScheme(6)):
        for n in (3.0, 2.0, 1.5, 1.7):
            equation, grid = GranularCompacton(n), Grid(60, 1200)
            system, state = scheme.discretize(equation, grid), Compacton(1, 30).values(equation, grid)
            matrix, out = BandedMatrix(system), np.empty_like(state)
            calls = (
                partial(system.rhs, 0.0, state, out),
                partial(matrix.linearize, 0.0, state),
                partial(matrix.factor_linearized, 0.01),
                partial(matrix.solve_into, state, out),
            )
            rows.append([scheme.label, f"{n:g}", *(f"{microseconds(call):.1f}" for call in calls)])
    print(f"\nW6: microseconds at N = 1,200\n\n| {' | '.join(header)} |\n|{'---|' * len(header)}")
    for row in rows:
        print(f"| {' | '.join(row)} |")
    with (folder / "W6.csv").open("w", newline="") as file:
        csv.writer(file).writerows([header, *rows])


def microseconds(call: Callable[[], Any], repeats: int = 500) -> float:
    """The least time of many calls, after a first one."""
    call()
    least = np.inf
    for _ in range(repeats):
        started = time.perf_counter()
        call()
        least = min(least, time.perf_counter() - started)
    return 1e6 * least


def against_the_wave(base: Simulation, name: str, scheme: Any, size: int, integrator: Any) -> Row:
    """The fastest of some runs with a scheme on a grid, measured against the exact solution."""
    simulation = replace(base, scheme=scheme, grid=Grid(base.grid.length, size), integrator=integrator)
    exact = base.initial[0].values(base.equation, simulation.grid, base.t_end)[0]
    candidate = Candidate(name, True, [simulation], counted)
    row = min((measured(candidate, simulation, exact) for _ in range(REPEATS)), key=lambda row: row.seconds)
    return replace(row, setting=described(integrator))


ITEMS = {"W1": single, "W2": collision, "W3": scaling, "W4": chains, "W5": schemes, "W6": kernels}


def main() -> None:
    """Run the items asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("items", nargs="*", metavar="ITEM", help="which work items; by default all")
    parser.add_argument("-o", "--output", default="benchmark_results", metavar="FOLDER", help="where tables and picture go")
    options = parser.parse_args()
    if unknown := sorted(set(options.items) - set(ITEMS)):
        parser.error(f"{unknown[0]} is no work item; choose among {', '.join(ITEMS)}")
    folder = Path(options.output)
    folder.mkdir(parents=True, exist_ok=True)
    for item in options.items or ITEMS:
        ITEMS[item](folder)


if __name__ == "__main__":
    main()
