"""At what rate the error of each scheme falls with the grid spacing: `python -m benchmarks.orders`.

On the exact smooth periodic wave of n = 3, on a manufactured solution for n = 3/2, 2, 3 and 4.2, and on compactons with their
edges for n = 3/2, 2 and 3. Prints the tables of docs/schemes.md. Takes about five minutes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mol_compactons import (
    Compacton,
    CompactScheme,
    ConservativeScheme,
    FourierScheme,
    GranularCompacton,
    Grid,
    Midpoint,
    PeriodicWave,
    Rosenbrock,
)
from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]
AnyScheme = CompactScheme | ConservativeScheme | FourierScheme

FORMAL_ORDERS: dict[AnyScheme, float] = {
    CompactScheme("wide", viscosity=0): 2,
    CompactScheme("nearest", viscosity=0): 2,
    CompactScheme("five_point", viscosity=0): 4,
    ConservativeScheme(order=2): 2,
    ConservativeScheme(order=4): 4,
    ConservativeScheme(order=6): 6,
    FourierScheme(): np.inf,
}
"""Each scheme and its order on smooth waves; the Fourier scheme's error falls exponentially."""

FINE = 1024
"""Points of the grid on which a source term is computed; every smaller power of two is a part of it."""

PRECISE = Midpoint(step=0.01, order=4)
"""Its error is about 1e-10 on the smooth waves here."""


def fitted_rate(sizes: Sequence[int], errors: Sequence[float]) -> float:
    """The rate p of error ~ size^-p, by least squares in logarithms."""
    return float(-np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def relative_error(values: Array, exact: Array) -> float:
    """The relative L2 distance."""
    return float(np.linalg.norm(values - exact) / np.linalg.norm(exact))


def periodic_wave_error(scheme: AnyScheme, size: int, t_end: float = 0.5) -> float:
    """The error on the exact wave W = sqrt(1 + cos(x - t) / 2) of n = 3."""
    equation, wave = GranularCompacton(3), PeriodicWave(speed=1, crest=float(np.sqrt(1.5)))
    grid = Grid(length=2 * np.pi, size=size)
    system = scheme.discretize(equation, grid)
    final = PRECISE.start(system, wave.values(equation, grid), t_end).advance(t_end)
    return relative_error(final, wave.values(equation, grid, t_end))


def manufactured_error(scheme: AnyScheme, n: float, size: int, t_end: float = 0.5) -> float:
    """The error on W = 1 + cos(x - t) / 4, which a source term makes a solution for any n."""
    grid = Grid(length=2 * np.pi, size=size)
    system = forced(scheme.discretize(GranularCompacton(n), grid), travelling_source(n, size))
    start = (1 + 0.25 * np.cos(grid.x))[None]
    final = PRECISE.start(system, start, t_end).advance(t_end)
    return relative_error(final, (1 + 0.25 * np.cos(grid.x - t_end))[None])


def travelling_source(n: float, size: int) -> Callable[[float], Array]:
    """W_t + F_x for W = 1 + cos(x - t) / 4 on a grid of a size that divides `FINE`, as a function of t."""
    fine = Grid(length=2 * np.pi, size=FINE)
    wave = 1 + 0.25 * np.cos(fine.x)
    phi = wave ** ((n + 1) / 2)
    second = np.fft.irfft(-(fine.wavenumbers**2) * np.fft.rfft(phi), n=FINE)
    flux = wave ** ((n - 1) / 2) * (phi + second)
    spectrum = 1j * fine.wavenumbers * np.fft.rfft(flux - wave)

    def source(t: float) -> Array:
        moved = np.fft.irfft(spectrum * np.exp(-1j * fine.wavenumbers * t), n=FINE)
        return np.asarray(moved[:: FINE // size])

    return source


def forced(system: SemiDiscretization, source: Callable[[float], Array]) -> SemiDiscretization:
    """M W' = f(W) + M s(t)."""

    def rhs(t: float, state: Array, out: Array) -> None:
        push = np.empty_like(state)
        system.apply_mass(source(t)[None], push)
        system.rhs(t, state, out)
        out += push

    return replace(system, rhs=rhs)


def compacton_error(scheme: AnyScheme, n: float, size: int, t_end: float = 4.0) -> float:
    """The error on one compacton of speed 1, edges and all."""
    equation, wave = GranularCompacton(n), Compacton(speed=1, center=10)
    grid = Grid(length=40 if n < 2 else 30, size=size)
    system = scheme.discretize(equation, grid)
    final = Rosenbrock(rtol=1e-5).start(system, wave.values(equation, grid), t_end).advance(t_end)
    return relative_error(final, wave.values(equation, grid, t_end))


def row(name: str, sizes: Sequence[int], error: Callable[[int], float]) -> str:
    """One line of a table: errors, and the rate fitted to all but the coarsest."""
    errors = [error(size) for size in sizes]
    return f"| {name} | {' | '.join(f'{value:.1e}' for value in errors)} | {fitted_rate(sizes[1:], errors[1:]):.2f} |"


def table(title: str, sizes: Sequence[int], rows: dict[str, Callable[[int], float]]) -> None:
    """Print a table in Markdown."""
    print(f"\n{title}\n\n| scheme | {' | '.join(f'N = {size}' for size in sizes)} | rate |")
    print(f"|{'---|' * (len(sizes) + 2)}")
    for name, error in rows.items():
        print(row(name, sizes, error), flush=True)


def short(scheme: AnyScheme) -> str:
    """A scheme in few words."""
    if isinstance(scheme, CompactScheme):
        return f"compact, {scheme.second_difference}"
    return f"conservative, order {scheme.order}" if isinstance(scheme, ConservativeScheme) else "Fourier"


def main() -> None:
    """Print the tables."""
    smooth = (16, 32, 64, 128)
    table(
        "Periodic wave, n = 3, t = 0.5",
        smooth,
        {short(scheme): partial(periodic_wave_error, scheme) for scheme in FORMAL_ORDERS},
    )
    for n in (1.5, 2.0, 3.0, 4.2):
        table(
            f"Manufactured wave, n = {n:g}, t = 0.5",
            smooth,
            {short(scheme): partial(manufactured_error, scheme, n) for scheme in FORMAL_ORDERS},
        )
    for n in (1.5, 2.0, 3.0):
        edged = [s for s in FORMAL_ORDERS if isinstance(s, ConservativeScheme) or s == CompactScheme("wide", viscosity=0)]
        table(
            f"Compacton, n = {n:g}, t = 4, no viscosity",
            (75, 150, 300, 600),
            {short(scheme): partial(compacton_error, scheme, n) for scheme in edged},
        )


if __name__ == "__main__":
    main()
