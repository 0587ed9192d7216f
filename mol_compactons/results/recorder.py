"""What a run writes into: the frames, one after the other, in memory or anywhere else."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mol_compactons.integrators.base import Memory
from mol_compactons.results.schema import Layout, describe

if TYPE_CHECKING:
    import xarray as xr


Watch = Callable[[], None]
"""Called now and then during long work; it may raise KeyboardInterrupt."""


class Recorder(Protocol):
    """Takes the frames of a run, one after the other."""

    def append(self, t: float, state: NDArray[np.float64], numbers: dict[str, float]) -> None:
        """Add a frame: a state of shape (components, size) and the numbers along t."""

    @property
    def frames(self) -> int:
        """How many frames are safe."""

    def sync(self, t: float) -> None:
        """Make all frames safe."""

    def alive(self) -> None:
        """Show that the run goes on."""

    def close(self, attributes: dict[str, Any], memory: Memory | None = None, watch: Watch = lambda: None) -> bool:
        """End the recording with the attributes of a run that has ended; whether what it needs to go on is in it too."""

    def dataset(self) -> xr.Dataset:
        """What was recorded."""


class MemoryRecorder:
    """A `Recorder` that keeps the frames in memory."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._attributes = layout.attributes
        self.frames = 0
        self._numbers = np.empty((layout.frames, 1 + len(layout.series)))
        self._states = np.empty((layout.frames, len(layout.fields), layout.coordinates.size))

    def append(self, t: float, state: NDArray[np.float64], numbers: dict[str, float]) -> None:
        """Add a frame."""
        self._states[self.frames] = state
        self._numbers[self.frames] = t, *(numbers[name] for name in self._layout.series)
        self.frames += 1

    def sync(self, t: float) -> None:
        """Nothing is safer than it was."""

    def alive(self) -> None:
        """Nobody looks."""

    def close(self, attributes: dict[str, Any], memory: Memory | None = None, watch: Watch = lambda: None) -> bool:
        """End the recording; nothing can go on from it."""
        self._attributes = self._attributes | attributes
        return False

    def dataset(self) -> xr.Dataset:
        """What was recorded."""
        import xarray as xr

        layout, space = self._layout, self._layout.space
        states, numbers = self._states[: self.frames], self._numbers[: self.frames]
        fields = {name: (("t", space), states[:, index], own) for index, (name, own) in enumerate(layout.fields.items())}
        series = {name: ("t", numbers[:, index], own) for index, (name, own) in enumerate(layout.series.items(), start=1)}
        coordinates = {
            "t": ("t", numbers[:, 0], describe("t")),
            space: (space, layout.coordinates, layout.coordinate_attributes),
        }
        return xr.Dataset({**fields, **series}, coordinates, self._attributes)
