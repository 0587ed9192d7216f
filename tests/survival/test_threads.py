"""Runs and readers side by side in threads and in pools of processes: nothing crashes, nothing is mixed up."""

from __future__ import annotations

import multiprocessing
import subprocess
import sys
import threading
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mol_compactons import IDA, Compacton, IntegrationError, Midpoint, Rosenbrock, Simulation, open_result, run
from tests.systems import one_compacton

SIMULATIONS = [
    one_compacton(t_end=0.3, frames=4, integrator=Rosenbrock()),
    one_compacton(t_end=0.3, frames=4, integrator=Midpoint(step=0.05)),
    one_compacton(t_end=0.3, frames=4, integrator=IDA()),
    replace(one_compacton(t_end=0.3, frames=4), initial=[Compacton(0.5, 9)], integrator=Rosenbrock()),
]

FAILING = one_compacton(t_end=2, frames=21, integrator=IDA(max_steps=10))


def side_by_side(folder: Path, rounds: int) -> None:
    """Each simulation in a thread of its own, again and again, and two that read what is there."""
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

    def read() -> None:
        while not over.is_set():
            for path in sorted(folder.glob("[0-9]*.nc")):
                try:
                    with open_result(path) as dataset:
                        if not np.isfinite(dataset.load().W).all():
                            wrong.append(f"{path.name} has gaps")
                except Exception as error:
                    wrong.append(f"{path.name}: {error!r}")

    writers = [threading.Thread(target=write, args=(index,)) for index in range(len(SIMULATIONS))]
    readers = [threading.Thread(target=read) for _ in range(2)]
    for thread in (*writers, *readers):
        thread.start()
    for thread in writers:
        thread.join()
    over.set()
    for thread in readers:
        thread.join()
    assert wrong == []
    assert len(list(folder.glob("*.nc"))) == rounds * len(SIMULATIONS)


PROGRAM = """
import sys, pathlib
from tests.survival.test_threads import side_by_side
side_by_side(pathlib.Path(sys.argv[1]), {rounds})
"""


@pytest.mark.parametrize("rounds", [4, pytest.param(50, marks=pytest.mark.slow)])
def test_runs_in_threads_are_those_of_one(rounds: int, tmp_path: Path) -> None:
    """In a process of its own, whose crash would be seen."""
    command = [sys.executable, "-c", PROGRAM.format(rounds=rounds), str(tmp_path)]
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
