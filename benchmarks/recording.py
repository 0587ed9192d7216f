"""What a frame costs on disk: `python -m benchmarks.recording [--sizes 75,600] [--frames 20000]`.

For each number of points: the time for a frame and the memory that grows, of a `NetCDFRecorder` with its compression at the
end, and of frames that are written one by one into a compressed NetCDF-4 file which is synchronised every sixteenth frame.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import netCDF4
import numpy as np
from numpy.typing import NDArray

from mol_compactons import Compacton, ConservativeScheme, GranularCompacton, Grid, Simulation
from mol_compactons.results.netcdf import NetCDFRecorder
from mol_compactons.results.schema import layout_of

Array = NDArray[np.float64]

DIFFERENT = 64
"""How many different frames there are, with noise that does not compress."""


def by_recorder(path: Path, simulation: Simulation, states: list[Array]) -> None:
    """All frames through the recorder of a run."""
    system = simulation.discretize()
    numbers = system.invariants(states[0])
    layout = layout_of(simulation, list(numbers), [], system.magnitudes(states[0]))
    recorder = NetCDFRecorder(layout, path, overwrite=False)
    for index, t in enumerate(simulation.times):
        recorder.append(states[index % DIFFERENT], np.array([[t, *numbers.values()]]))
    recorder.close({"status": "complete"})


def one_by_one(path: Path, simulation: Simulation, states: list[Array]) -> None:
    """All frames into a NetCDF-4 file."""
    numbers = simulation.discretize().invariants(states[0])
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("t", None)
        file.createDimension("x", simulation.grid.size)
        for name in ("t", *numbers):
            file.createVariable(name, "f8", ("t",))
        file.createVariable("W", "f8", ("t", "x"), chunksizes=(1, simulation.grid.size), zlib=True, complevel=1)
        for index, t in enumerate(simulation.times):
            file["W"][index] = states[index % DIFFERENT][0]
            file["t"][index] = t
            for name, value in numbers.items():
                file[name][index] = value
            if index % 16 == 0:
                file.sync()


def measured(write: Callable[[Path, Simulation, list[Array]], None], size: int, frames: int) -> str:
    """The microseconds for a frame, the megabytes of the file, and by how much the memory has grown."""
    simulation = Simulation(
        GranularCompacton(3), Grid(30, size), [Compacton(1, 6)], 10, ConservativeScheme(4, grid_viscosity=0.03), frames
    )
    start, noise = simulation.initial_state(), np.random.default_rng(0)
    states = [start * (1 + 1e-3 * noise.normal(size=start.shape)) for _ in range(DIFFERENT)]
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with tempfile.TemporaryDirectory() as folder:
        path, began = Path(folder, "frames.nc"), time.perf_counter()
        write(path, simulation, states)
        cost = 1e6 * (time.perf_counter() - began) / frames
        grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
        return f"{cost:8.1f} us a frame, {path.stat().st_size / 1e6:7.1f} MB, memory grown by {grown:.0f} MB"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--sizes", default="75,600")
    parser.add_argument("--frames", type=int, default=20_000)
    options = parser.parse_args()
    for size in map(int, options.sizes.split(",")):
        for name, write in (("recorder", by_recorder), ("one by one", one_by_one)):
            print(f"N = {size:6}, {options.frames} frames, {name:10}: {measured(write, size, options.frames)}", flush=True)


if __name__ == "__main__":
    main()
