"""What a run writes into: the frames, one after the other, in memory or anywhere else."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mol_compactons.results.schema import SERIES_TIME, Layout, describe

if TYPE_CHECKING:
    import xarray as xr


Array = NDArray[np.float64]

PART = "part"
"""The dimension of what is recorded more often than the fields, from one frame to the next, while a file is written."""

Watch = Callable[[], None]
"""Called now and then during long work; it may raise KeyboardInterrupt."""


class Recorder(Protocol):
    """Takes the frames of a run, one after the other."""

    @property
    def layout(self) -> Layout:
        """What the result looks like."""

    def append(self, state: Array, between: Array) -> None:
        """Add a frame.

        Parameters
        ----------
        state : array, shape (components, size)
            The fields.
        between : array, shape (times, 1 + numbers)
            The time and the series at one or several times since the frame before, the last those of this frame.
        """

    @property
    def frames(self) -> int:
        """How many frames are safe."""

    @property
    def is_published(self) -> bool:
        """Whether others find the frames where they are to be."""

    def publish(self) -> None:
        """Let others find the frames, few as there may be."""

    def sync(self, t: float) -> None:
        """Make all frames safe."""

    def alive(self) -> None:
        """Show that the run goes on."""

    def close(self, attributes: dict[str, Any], memory: bytes = b"", watch: Watch = lambda: None) -> bool:
        """End the recording with the attributes of a run that has ended; whether what it needs to go on is in it too."""

    def dataset(self) -> xr.Dataset:
        """What was recorded."""


class MemoryRecorder:
    """A `Recorder` that keeps the frames in memory."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.attributes = layout.attributes
        self.frames = 0
        self._numbers = np.empty((layout.frames, 1 + len(layout.series)))
        self._states = np.empty((layout.frames, len(layout.fields), layout.coordinates.size))
        self._often = np.empty((layout.frames, len(layout.often), layout.series_per_frame))

    def append(self, state: Array, between: Array) -> None:
        """Add a frame."""
        self._states[self.frames] = state
        self._numbers[self.frames] = between[-1]
        self._often[self.frames] = self.layout.block(between)
        self.frames += 1

    @property
    def states(self) -> Array:
        """The fields so far, shape (frames, components, size)."""
        return self._states[: self.frames]

    @property
    def numbers(self) -> Array:
        """The times and the series so far, shape (frames, 1 + numbers)."""
        return self._numbers[: self.frames]

    is_published = False

    def publish(self) -> None:
        """Nobody looks."""

    def sync(self, t: float) -> None:
        """Nothing is safer than it was."""

    def alive(self) -> None:
        """Nobody looks."""

    def close(self, attributes: dict[str, Any], memory: bytes = b"", watch: Watch = lambda: None) -> bool:
        """End the recording; nothing can go on from it."""
        self.attributes = self.attributes | attributes
        return False

    def dataset(self) -> xr.Dataset:
        """What was recorded."""
        import xarray as xr

        layout, space = self.layout, self.layout.space
        states, numbers = self.states, self.numbers
        fields = {name: (("t", space), states[:, index], own) for index, (name, own) in enumerate(layout.fields.items())}
        series = {name: ("t", numbers[:, index], own) for index, (name, own) in enumerate(layout.series.items(), start=1)}
        coordinates = {
            "t": ("t", numbers[:, 0], describe("t")),
            space: (space, layout.coordinates, layout.coordinate_attributes),
        }
        often = self._often[: self.frames].swapaxes(0, 1)
        blocks = {name: (("t", PART), block, own) for (name, own), block in zip(layout.often.items(), often, strict=True)}
        return in_one_row(xr.Dataset({**fields, **series, **blocks}, coordinates, self.attributes))


def in_one_row(dataset: xr.Dataset) -> xr.Dataset:
    """The result with what is recorded more often than the fields along a coordinate, as a file has it at the end."""
    if SERIES_TIME not in dataset or dataset[SERIES_TIME].ndim < 2:
        return dataset
    first = dataset.sizes[PART] - 1
    rows = {
        name: (SERIES_TIME, variable.values.reshape(-1)[first:], variable.attrs)
        for name, variable in dataset.variables.items()
        if PART in variable.dims
    }
    result = dataset.drop_vars(list(rows)).assign_coords({SERIES_TIME: rows.pop(SERIES_TIME)}).assign(rows)
    result.set_close(dataset.close)
    return result
