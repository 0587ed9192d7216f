"""What a member of a sweep costs besides its solver: `python -m benchmarks.sweeping [--members 10000] [--per-file 100]`.

Small runs (N = 75, order 6, t = 2) with random speeds and viscosities in two processes. Printed are the seconds, the processor
time of each member outside its run, that of the process of the study included, files, bytes and memory, and then how long
`open_sweep` takes and a mean over one axis of all last frames. The seconds depend on what else the machine does, the processor
time hardly.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from pathlib import Path

import numpy as np
import xarray as xr

from mol_compactons import (
    Compacton,
    ConservativeScheme,
    GranularCompacton,
    Grid,
    Processes,
    Rosenbrock,
    Simulation,
    open_sweep,
    sweep,
)

WORKERS = 2
VISCOSITIES = 10


def processor_seconds() -> float:
    """The processor time of this process and of those that it has waited for."""
    return sum(
        one.ru_utime + one.ru_stime for one in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    )


def main() -> None:
    """Print the costs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--members", type=int, default=10000)
    parser.add_argument("--per-file", type=int, default=None)
    options = parser.parse_args()
    simulation = Simulation(
        equation=GranularCompacton(3),
        grid=Grid(30, 75),
        scheme=ConservativeScheme(order=6),
        initial=[Compacton(1, 10)],
        t_end=2,
        frames=11,
        integrator=Rosenbrock(),
    )
    varied = {
        "initial.0.speed": np.linspace(0.5, 1, options.members // VISCOSITIES).tolist(),
        "scheme.grid_viscosity": np.linspace(0.01, 0.03, VISCOSITIES).tolist(),
    }
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "sweep"
        started, spent = time.monotonic(), processor_seconds()
        table = sweep(simulation, varied, folder, engine=Processes(WORKERS), tracked=False, per_file=options.per_file)
        seconds, spent = time.monotonic() - started, processor_seconds() - spent
        files = list((folder / "members").iterdir())
        solver = float(table["cpu_seconds"].mean())
        memory = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)) / 1024
        count = table["status"].size
        print(f"{count} members in {seconds:.1f} s by {WORKERS} processes; a run takes {1e3 * solver:.2f} ms")
        print(f"besides, each takes {1e3 * (spent / count - solver):.2f} ms of processor time")
        print(f"with the time that {WORKERS} processes wait, {1e3 * (WORKERS * seconds / count - solver):.2f} ms")
        print(
            f"{len(files)} files, {sum(file.stat().st_size for file in files) / 2**20:.0f} MB; a process has {memory:.0f} MB"
        )
        started = time.monotonic()
        members = open_sweep(folder)
        assert isinstance(members, xr.Dataset)
        print(f"open_sweep: {time.monotonic() - started:.2f} s")
        started = time.monotonic()
        mean = members["W"].isel(t=-1).mean("speed").compute()
        print(f"mean over the speeds of all last frames, {mean.shape}: {time.monotonic() - started:.1f} s")


if __name__ == "__main__":
    main()
