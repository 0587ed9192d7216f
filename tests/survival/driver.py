"""Kills runs at chosen calls that change files, looks at what is left, and lets them go on; started with faults.c loaded.

Each trial is a fork, so that nothing is imported twice. With a stride of 0 the kills come at random times. Prints one line of
JSON for each simulation.
"""

from __future__ import annotations

import ctypes
import json
import os
import signal
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from mol_compactons import (
    CVODE,
    IDA,
    Compacton,
    ConservativeScheme,
    GaussLegendre,
    GranularChain,
    GranularCompacton,
    Grid,
    Lattice,
    Midpoint,
    PowerContact,
    Rosenbrock,
    Simulation,
    SolitaryWave,
    Symplectic,
    course,
    run,
)
from mol_compactons.results import running_file

WAVE = Simulation(GranularCompacton(3), Grid(30, 60), [Compacton(1, 6)], 1.2, ConservativeScheme(4, grid_viscosity=0.03), 7)
CHAIN = Simulation(
    GranularChain(PowerContact(1.5)), Lattice(40), [SolitaryWave(1, 20)], 1.2, frames=7, integrator=Symplectic(0.05)
)

SIMULATIONS = {
    "Midpoint": replace(WAVE, integrator=Midpoint(step=0.05)),
    "Rosenbrock": replace(WAVE, integrator=Rosenbrock()),
    "GaussLegendre": replace(WAVE, integrator=GaussLegendre(step=0.1)),
    "IDA": replace(WAVE, integrator=IDA()),
    "CVODE": replace(WAVE, integrator=CVODE()),
    "Symplectic": CHAIN,
}

RANDOM_KILLS = 7
"""How many for each simulation."""

MOMENTS = ("before", "middle", "after")


class Trials:
    """All trials of one simulation in a folder.

    Parameters
    ----------
    simulation : Simulation
        What is run.
    folder : Path
        Where; nothing else is in it.
    """

    def __init__(self, simulation: Simulation, folder: Path) -> None:
        self._simulation, self._path = simulation, folder / "result.nc"
        self._faults = ctypes.CDLL(None)
        self._faults.counted.restype = ctypes.c_long
        self.exact = run(simulation)
        self.trials, self.lost, self.faults = 0, 0, []  # type: ignore[var-annotated]

    def calls(self) -> int:
        """How many calls an undisturbed run makes."""
        self._clear()
        self._run(0, 0)
        return self._counted

    def kill(self, at: int, moment: int) -> None:
        """One trial: kill, look, go on, compare."""
        self._clear()
        self._look_at_what_is_left(self._run(at, moment), f"{MOMENTS[moment]} call {at}")

    def kill_after(self, seconds: float) -> None:
        """One trial at a time by the clock."""
        self._clear()
        self._look_at_what_is_left(self._run(0, 0, seconds), f"after {seconds:.4f} s")

    def _look_at_what_is_left(self, synced: int, where: str) -> None:
        self.trials += 1
        try:
            if self._path.exists():
                with xr.open_dataset(self._path) as left:
                    self._check(left, synced)
            elif synced:
                self.lost += 1
                self.faults.append(f"{where}: {synced} frames were safe, and there is no file")
            self._run(0, 0)
            with xr.open_dataset(self._path) as done:
                self._compare(done)
            left_over = sorted(path.name for path in self._path.parent.iterdir())
            assert left_over == ["result.nc"], left_over
        except Exception as error:
            self.faults.append(f"{where}: {type(error).__name__}: {error}")

    def _check(self, left: xr.Dataset, synced: int) -> None:
        count = left.sizes["t"]
        assert count >= synced, f"{synced} frames were safe, {count} are there"
        assert np.array_equal(left.t, self.exact.t[:count])
        for name in self.exact.data_vars:
            assert np.array_equal(left[name], self.exact[name][:count]), name

    def _compare(self, done: xr.Dataset) -> None:
        assert done.attrs["status"] == "complete"
        assert np.array_equal(done.t, self.exact.t)
        bar = 0.0 if self._simulation.integrator.exact_restart else 10 * self._simulation.integrator.own_tolerance
        for name in self.exact.data_vars:
            size = float(abs(self.exact[name]).max())
            assert float(abs(done[name] - self.exact[name]).max()) <= bar * size, name

    def _run(self, at: int, moment: int, seconds: float | None = None) -> int:
        """A run in a process of its own, from the start or from what is there; how many frames it knew to be safe."""
        readable, writable = os.pipe()
        child = os.fork()
        if not child:
            os.close(readable)
            self._in_the_child(at, moment, writable)
        os.close(writable)
        if seconds is not None:
            time.sleep(seconds)
            os.kill(child, signal.SIGKILL)
        with os.fdopen(readable) as told:
            lines = [line.split() for line in told.read().splitlines()]
        os.waitpid(child, 0)
        self._counted = int(lines[-1][1]) if lines and lines[-1][0] == "calls" else 0
        return max((int(number) for word, number in lines if word == "safe"), default=0)

    def _in_the_child(self, at: int, moment: int, writable: int) -> None:
        sync = running_file.RunningFile.sync

        def telling(file: Any) -> None:
            sync(file)
            os.write(writable, f"safe {file.frames if self._path.exists() else 0}\n".encode())

        running_file.RunningFile.sync = telling  # type: ignore[method-assign,assignment]
        running_file.SYNC_SECONDS = course.CHECKPOINT_SECONDS = -1.0
        try:
            self._faults.arm(str(self._path.parent).encode(), ctypes.c_long(at), moment)
            run(self._simulation, self._path, resume=True)
            os.write(writable, f"calls {self._faults.counted()}\n".encode())
        finally:
            os._exit(0)

    def _clear(self) -> None:
        for path in self._path.parent.iterdir():
            path.unlink()


def main(folder: Path, stride: int, names: list[str]) -> None:
    """Try each simulation at every `stride`-th call, and at each moment of it, or at random times."""
    for name in names:
        place = folder / name
        place.mkdir()
        trials = Trials(SIMULATIONS[name], place)
        calls = trials.calls()
        if stride:
            for at in range(1, calls + 1, stride):
                for moment in range(len(MOMENTS)):
                    trials.kill(at, moment)
        else:
            chance, began = np.random.default_rng(0), time.perf_counter()
            trials.calls()
            whole = time.perf_counter() - began
            for _ in range(RANDOM_KILLS):
                trials.kill_after(chance.uniform(0, whole))
        print(json.dumps({"name": name, "calls": calls, "trials": trials.trials, "faults": trials.faults}), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3:])
