"""The largest one-cell Floquet multipliers of a compacton under the schemes that are offered for its equation.

    python -m benchmarks.multipliers                          # |K|(2, 2), L = 16, h = 0.08 and 0.04
    python -m benchmarks.multipliers --sizes 800              # h = 0.02, some minutes
    python -m benchmarks.multipliers --granular 2 --length 20 # the granular compacton equation

The map is "advance by h / c, shift back by one cell", with ten steps of Gauss-Legendre 4, about its own fixed point. Two
values stand for each size: followed around the ring, and on a window about the wave. s is the speed of a sawtooth: a small
(-1)^j v(x) with smooth v on u = 1 obeys v_t = -s k v_x / h^2, with k that of k u_xxx in the linear equation.
"""

from __future__ import annotations

import argparse

import numpy as np

from mol_compactons import (
    Compacton,
    CompactScheme,
    ConservativeScheme,
    Equation,
    GranularCompacton,
    Grid,
    InputError,
    PadeScheme,
    RosenauHyman,
    Scheme,
    Simulation,
)
from mol_compactons.analysis.floquet import spectrum
from mol_compactons.analysis.orbits import Period, close
from mol_compactons.analysis.wave_orbits import window

SHARED: tuple[Scheme, ...] = (
    CompactScheme("wide", viscosity=0),
    CompactScheme("nearest", viscosity=0),
    CompactScheme("five_point", viscosity=0),
    ConservativeScheme(2),
    ConservativeScheme(4),
    ConservativeScheme(6),
)

OF_THE_LITERATURE: tuple[Scheme, ...] = (
    PadeScheme("ismail_taha"),
    PadeScheme("de_frutos"),
    PadeScheme("pade_8"),
    PadeScheme("pade_6"),
)


def sawtooth_speed(scheme: Scheme, equation: Equation, size: int = 400) -> float:
    """S of a scheme, for an even size."""
    grid = Grid(2 * np.pi, size)
    system = scheme.discretize(equation, grid)
    sawtooth = np.where(np.arange(size) % 2, -1.0, 1.0)
    small = 1e-4 * sawtooth * np.sin(grid.coordinates)
    ahead, behind = (system.rate(0.0, np.asarray(1 + sign * small)[None])[0] for sign in (1, -1))
    rate = sawtooth * (ahead - behind) / 2e-4
    stiffness = equation.n if isinstance(equation, RosenauHyman) else (equation.n + 1) / 2  # type: ignore[attr-defined]
    return float(-2 / size * rate @ np.cos(grid.coordinates) * grid.spacing**2 / stiffness)


def multipliers(scheme: Scheme, equation: Equation, grid: Grid) -> tuple[float, float]:
    """The largest around the ring and on the window; NaN where the window does not fit in."""
    simulation = Simulation(equation, grid, [Compacton(1, grid.length / 2)], 1, scheme)
    orbit = close(simulation.discretize(), simulation.initial_state(), Period(grid.spacing))
    ring = float(abs(spectrum(orbit).values[0]))
    try:
        return ring, float(abs(spectrum(orbit, window(simulation)).values[0]))
    except InputError:
        return ring, float("nan")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--granular", type=float, metavar="N", help="the granular compacton equation of this exponent")
    parser.add_argument("--length", type=float, default=16.0, help="length of the ring (default 16)")
    parser.add_argument("--sizes", default="200,400", help="numbers of points (default 200,400)")
    options = parser.parse_args()
    equation = RosenauHyman(2, 2, absolute=True) if options.granular is None else GranularCompacton(options.granular)
    sizes = [int(size) for size in options.sizes.split(",")]
    print("| scheme | s |", " | ".join(f"N = {size}" for size in sizes), "|")
    print("|---" * (2 + len(sizes)) + "|")
    for scheme in (*SHARED, *(OF_THE_LITERATURE if options.granular is None else ())):
        cells = [multipliers(scheme, equation, Grid(options.length, size)) for size in sizes]
        values = " | ".join(f"{ring:.4f}, {near:.4f}" for ring, near in cells)
        print(f"| {scheme.label} | {round(sawtooth_speed(scheme, equation), 1) + 0.0:.1f} | {values} |", flush=True)


if __name__ == "__main__":
    main()
