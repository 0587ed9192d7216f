"""Runs and readers side by side in threads and in pools of processes: nothing crashes, nothing is mixed up."""

from __future__ import annotations

import multiprocessing
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from dask.base import compute
from dask.delayed import delayed

from mol_compactons import IDA, Compacton, IntegrationError, Midpoint, Rosenbrock, Simulation, open_result, run
from tests.systems import Array, one_compacton

SIMULATIONS = [
    one_compacton(t_end=0.3, frames=4, integrator=Rosenbrock()),
    one_compacton(t_end=0.3, frames=4, integrator=Midpoint(step=0.05)),
    one_compacton(t_end=0.3, frames=4, integrator=IDA()),
    replace(one_compacton(t_end=0.3, frames=4), initial=[Compacton(0.5, 9)], integrator=Rosenbrock()),
]

FAILING = one_compacton(t_end=2, frames=21, integrator=IDA(max_steps=10))


def by_plain_xarray(path: Path) -> xr.Dataset:
    """Opened without us; once more where the finished file, of another format, took the place of the running one meanwhile.

    netCDF4 looks at the beginning of a file first, and opens it by its name after that.
    """
    before = path.stat().st_ino
    try:
        return xr.open_dataset(path)
    except OSError:
        if path.stat().st_ino == before:
            raise
        return xr.open_dataset(path)


def side_by_side(folder: Path, rounds: int) -> None:
    """Each simulation in a thread of its own, again and again, and three that read what is there, one of them by plain xarray.

    Only one, as xarray asks netCDF4 for the variables of a file without a lock: two such readers crash each other.
    """
    expected = [run(simulation).W.values for simulation in SIMULATIONS]
    wrong: list[str] = []
    over = threading.Event()

    def write(index: int) -> None:
        for turn in range(rounds):
            try:
                with run(SIMULATIONS[index], folder / f"{index}-{turn}.nc") as dataset:
                    if not np.array_equal(dataset.W.values, expected[index]):
                        wrong.append(f"{index}-{turn} differs")
            except Exception as error:
                wrong.append(f"{index}-{turn}: {error!r}")

    def read(opened: Callable[[Path], xr.Dataset]) -> None:
        while not over.is_set():
            for path in sorted(folder.glob("[0-9]*.nc")):
                try:
                    with opened(path) as dataset:
                        if not np.isfinite(dataset.load().W).all():
                            wrong.append(f"{path.name} has gaps")
                except Exception as error:
                    wrong.append(f"{path.name}: {error!r}")

    writers = [threading.Thread(target=write, args=(index,)) for index in range(len(SIMULATIONS))]
    readers = [threading.Thread(target=read, args=(opened,)) for opened in (open_result, open_result, by_plain_xarray)]
    for thread in (*writers, *readers):
        thread.start()
    for thread in writers:
        thread.join()
    over.set()
    for thread in readers:
        thread.join()
    assert wrong == [], wrong
    assert len(list(folder.glob("*.nc"))) == rounds * len(SIMULATIONS)


def tasks_of_dask(folder: Path, rounds: int) -> None:
    """Runs and readers of what they wrote as tasks of Dask's threads."""

    @delayed  # type: ignore[untyped-decorator]
    def write(index: int, turn: int) -> Path:
        path = folder / f"{index}-{turn}.nc"
        run(SIMULATIONS[index], path).close()
        return path

    @delayed  # type: ignore[untyped-decorator]
    def read(path: Path) -> Array:
        with open_result(path) as dataset:
            return np.asarray(dataset.W.values)

    expected = [run(simulation).W.values for simulation in SIMULATIONS]
    tasks = [read(write(index, turn)) for turn in range(rounds) for index in range(4)]
    found = compute(*tasks, scheduler="threads", num_workers=4)  # type: ignore[no-untyped-call]
    assert [np.array_equal(one, expected[index % 4]) for index, one in enumerate(found)] == [True] * (4 * rounds)


PROGRAM = """
import sys, pathlib
from tests.survival import test_threads
test_threads.{work}(pathlib.Path(sys.argv[1]), {rounds})
"""


@pytest.mark.parametrize("work", [side_by_side, tasks_of_dask], ids=lambda work: str(work.__name__))
@pytest.mark.parametrize("rounds", [4, pytest.param(200, marks=pytest.mark.slow)])
def test_runs_in_threads_are_those_of_one(rounds: int, work: Callable[[Path, int], None], tmp_path: Path) -> None:
    """In a process of its own, whose crash would be seen."""
    command = [sys.executable, "-c", PROGRAM.format(work=work.__name__, rounds=rounds), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]


def steps_of(simulation: Simulation) -> int:
    return int(run(simulation).attrs["solver_steps"])


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_a_member_that_fails_leaves_its_pool_at_work(method: str) -> None:
    context = multiprocessing.get_context(method)
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        good, bad, again = (pool.submit(steps_of, simulation) for simulation in (SIMULATIONS[0], FAILING, SIMULATIONS[0]))
        with pytest.raises(IntegrationError, match="max_steps") as failure:
            bad.result(timeout=120)
        assert failure.value.t < 2
        assert failure.value.dataset.sizes["t"] >= 1
        assert good.result(timeout=120) == again.result(timeout=120) > 1
