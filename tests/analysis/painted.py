"""Results made by hand: exact compactons where they should be, without any integration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from mol_compactons import Compacton, GranularCompacton, Grid, Simulation

GRID = Grid(length=60, size=600)


def painted(n: float, flights: Sequence[tuple[Compacton, float, float]], t_end: float = 40, grid: Grid = GRID) -> xr.Dataset:
    """A result made by hand: exact compactons that jump ahead by a shift at a moment, each (wave, moment, shift)."""
    equation = GranularCompacton(n)
    simulation = Simulation(equation=equation, grid=grid, initial=[wave for wave, _, _ in flights], t_end=t_end, frames=161)
    frames = np.zeros((simulation.frames, grid.size))
    for wave, moment, shift in flights:
        for index, t in enumerate(simulation.times):
            moved = Compacton(wave.speed, wave.center + (shift if t > moment else 0), wave.sign)
            frames[index] += moved.values(equation, grid, t)[0]
    return xr.Dataset({"W": (("t", "x"), frames)}, {"t": simulation.times, "x": grid.x}, {"simulation": simulation.to_json()})
