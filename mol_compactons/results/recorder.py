"""What a run writes into: the frames, one after the other, in memory or anywhere else."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mol_compactons.results.schema import Layout, describe

if TYPE_CHECKING:
    import xarray as xr


class Recorder(Protocol):
    """Takes the frames of a run, one after the other."""

    def append(self, t: float, state: NDArray[np.float64], numbers: dict[str, float]) -> None:
        """Add a frame: a state of shape (components, size) and the numbers along t."""

    def close(self, attributes: dict[str, Any]) -> None:
        """End the recording with the attributes of a run that has ended."""

    def dataset(self) -> xr.Dataset:
        """What was recorded."""


class MemoryRecorder:
    """A `Recorder` that keeps the frames in memory."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._attributes = layout.attributes
        self._t: list[float] = []
        self._states: list[NDArray[np.float64]] = []
        self._values: list[dict[str, float]] = []

    def append(self, t: float, state: NDArray[np.float64], numbers: dict[str, float]) -> None:
        """Add a frame."""
        self._t.append(t)
        self._states.append(state.copy())
        self._values.append(numbers)

    def close(self, attributes: dict[str, Any]) -> None:
        """End the recording."""
        self._attributes = self._attributes | attributes

    def dataset(self) -> xr.Dataset:
        """What was recorded."""
        import xarray as xr

        layout, space = self._layout, self._layout.space
        frames = np.array(self._states).reshape(len(self._t), len(layout.fields), layout.coordinates.size)
        fields = {name: (("t", space), frames[:, index], own) for index, (name, own) in enumerate(layout.fields.items())}
        series = {
            name: ("t", np.array([numbers[name] for numbers in self._values]), own) for name, own in layout.series.items()
        }
        coordinates = {
            "t": ("t", np.array(self._t), describe("t")),
            space: (space, layout.coordinates, layout.coordinate_attributes),
        }
        return xr.Dataset({**fields, **series}, coordinates, self._attributes)
