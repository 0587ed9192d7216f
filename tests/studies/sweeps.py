"""Small sweeps, and work for engines, in a module that other processes can load."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import xarray as xr

from mol_compactons import Rosenbrock, Simulation
from tests.systems import one_compacton

FATAL = "fatal"
"""A file with this name makes a process kill itself, once."""

BAD_SIZE = 5
"""A grid that is too small."""


def small(size: int = 60) -> Simulation:
    return one_compacton(size=size, t_end=0.2, frames=3, integrator=Rosenbrock())


def doubled(task: tuple[str, int]) -> int:
    """Twice a number, noted in a file; the process is killed where a file named after the number asks for it."""
    folder, number = task
    note(Path(folder), f"{number}")
    if (Path(folder) / f"{FATAL}-{number}-always").exists():
        os.kill(os.getpid(), signal.SIGKILL)
    kill_once(Path(folder) / f"{FATAL}-{number}")
    return 2 * number


def kill_once(marker: Path) -> None:
    if marker.exists():
        marker.unlink()
        os.kill(os.getpid(), signal.SIGKILL)


def note(folder: Path, line: str) -> None:
    with (folder / "notes.txt").open("a", encoding="utf-8") as file:
        file.write(f"{line} {os.getpid()}\n")


def noted(folder: Path) -> list[str]:
    path = folder / "notes.txt"
    return [line.split()[0] for line in path.read_text(encoding="utf-8").splitlines()] if path.exists() else []


def forever(task: str) -> None:
    note(Path(task), "began")
    time.sleep(600)


def peak(dataset: xr.Dataset) -> float:
    """The height at the end; notes that the member has run, and may kill its process, where the environment says so."""
    folder = os.environ.get("NOTES")
    size = dataset.sizes["x"]
    if folder:
        note(Path(folder), f"{size}-{float(dataset.W[0].max()):.6f}")
        if size == 61:
            kill_once(Path(folder) / FATAL)
    return float(dataset.W[-1].max())


def deadly(dataset: xr.Dataset) -> float:
    """The height at the start; the process is killed where that is large."""
    height = float(dataset.W[0].max())
    if height > 1.3:
        os.kill(os.getpid(), signal.SIGKILL)
    return height


def broken(dataset: xr.Dataset) -> float:
    return float(dataset.nothing_of_this_name)
