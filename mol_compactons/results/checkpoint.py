"""Checkpoints: what a run needs to go on from where it was, in two files beside its result, of which one is always whole."""

from __future__ import annotations

import contextlib
import io
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mol_compactons.integrators.base import Counters, Memory
from mol_compactons.results.places import beside, leftovers, written_whole

KEPT = 2
"""How many checkpoints are kept, the last ones."""

ABOUT, BETWEEN = "_about", "_between"
"""The entries beside the memory: all numbers and texts as JSON, and what was recorded since the last frame."""


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
    between : array, shape (times, 1 + numbers)
        What was recorded more often than the fields since the last of these frames, see `Layout.block`.
    """

    t: float
    frames: int
    memory: Memory
    counters: Counters
    seconds: float
    simulation: str
    source: str
    between: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 0)))

    def about(self) -> str:
        """All but the arrays, as JSON."""
        return json.dumps({name: value for name, value in asdict(self).items() if name not in ("memory", "between")})

    def to_bytes(self) -> bytes:
        """The content of a file of numpy (npz)."""
        content = io.BytesIO()
        np.savez(content, **self.memory, **{ABOUT: np.array(self.about()), BETWEEN: self.between})  # type: ignore[arg-type]
        return content.getvalue()

    @classmethod
    def from_bytes(cls, content: bytes) -> Checkpoint | None:
        """The inverse of `to_bytes`; None where the content is not whole."""
        try:
            with np.load(io.BytesIO(content), allow_pickle=False) as archive:
                arrays = {name: archive[name] for name in archive.files}
            values, between = json.loads(str(arrays.pop(ABOUT))), arrays.pop(BETWEEN)
            return cls(**values | {"counters": Counters(**values["counters"])}, memory=arrays, between=between)
        except Exception:  # a damaged archive fails in as many ways as it can be damaged
            return None


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
    with written_whole(places(path)[number % KEPT]) as part:
        part.write_bytes(checkpoint.to_bytes())


def last(path: Path) -> Checkpoint | None:
    """The checkpoint of a result that went farthest, of those that are whole."""
    found = [checkpoint for checkpoint in map(_read, places(path)) if checkpoint is not None]
    return max(found, key=lambda checkpoint: checkpoint.t, default=None)


def _read(place: Path) -> Checkpoint | None:
    try:
        return Checkpoint.from_bytes(place.read_bytes())
    except OSError:
        return None


def discard(path: Path) -> None:
    """Remove the checkpoints of a result, and what was to become one."""
    for place in places(path):
        with contextlib.suppress(OSError):
            for file in (place, *leftovers(place)):
                file.unlink(missing_ok=True)
