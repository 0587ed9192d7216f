"""Checkpoints: what a run needs to go on from where it was, in two files beside its result, of which one is always whole."""

from __future__ import annotations

import contextlib
import io
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from mol_compactons.integrators.base import Counters, Memory
from mol_compactons.results.places import beside, leftovers, written_whole

KEPT = 2
"""How many checkpoints are kept, the last ones."""

ABOUT = "about"
"""The entry of a checkpoint that is text."""


@dataclass(frozen=True)
class Checkpoint:
    """A run between two of its steps.

    Parameters
    ----------
    t : float
        The time that the integrator has reached.
    frames : int
        How many frames of the result come before it.
    memory : dict of arrays
        What the integrator needs to go on, see `Integrator.resume`.
    counters : Counters
        What the run has cost.
    seconds : float
        How much CPU time it took.
    simulation : str
        Its settings as JSON.
    source : str
        The program and the libraries, with their versions.
    between : list
        What was recorded more often than the fields since the last of these frames, see `Layout.block`.
    """

    t: float
    frames: int
    memory: Memory
    counters: Counters
    seconds: float
    simulation: str
    source: str
    between: list[list[float]] = field(default_factory=list)

    def about(self) -> str:
        """All but the memory, as JSON."""
        return json.dumps({name: value for name, value in asdict(self).items() if name != "memory"})

    def packed(self) -> Memory:
        """The memory with all else beside it, as arrays."""
        return self.memory | {ABOUT: np.array(self.about())}

    @classmethod
    def restored(cls, about: str, memory: Memory) -> Checkpoint:
        """The inverse of `about`."""
        values = json.loads(about)
        return cls(**values | {"counters": Counters(**values["counters"]), "memory": memory})


def places(path: Path) -> list[Path]:
    """Where the checkpoints of a result are."""
    return [beside(path, f"checkpoint-{number}") for number in range(KEPT)]


def save(path: Path, number: int, checkpoint: Checkpoint) -> None:
    """Write the checkpoint of a result that has a number; every second takes the place of the one before the last.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    content = io.BytesIO()
    np.savez(content, **checkpoint.packed())  # type: ignore[arg-type]
    with written_whole(places(path)[number % KEPT]) as part:
        part.write_bytes(content.getvalue())


def last(path: Path) -> Checkpoint | None:
    """The checkpoint of a result that went farthest, of those that are whole."""
    found = [checkpoint for checkpoint in map(_read, places(path)) if checkpoint is not None]
    return max(found, key=lambda checkpoint: checkpoint.t, default=None)


def _read(place: Path) -> Checkpoint | None:
    try:
        with np.load(io.BytesIO(place.read_bytes()), allow_pickle=False) as archive:
            memory = {name: archive[name] for name in archive.files if name != ABOUT}
            return Checkpoint.restored(str(archive[ABOUT]), memory)
    except Exception:  # a damaged archive fails in as many ways as it can be damaged
        return None


def discard(path: Path) -> None:
    """Remove the checkpoints of a result, and what was to become one."""
    for place in places(path):
        with contextlib.suppress(OSError):
            for file in (place, *leftovers(place)):
                file.unlink(missing_ok=True)
