"""A rule that ends a run when its waves have collided and settled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mol_compactons.analysis.collisions import first_collision
from mol_compactons.analysis.tracking import track
from mol_compactons.errors import InputError, require
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.stop_rules import Array, Patient, SoFar, StopRule, Watcher

LOOK_AGAIN = 1.2
"""By what factor the number of frames grows from one look at the waves to the next."""


@dataclass(frozen=True)
class CollisionOver(StopRule):
    """Stops a run when all its waves have met, are apart again, and are as fast as exact waves of their heights.

    Parameters
    ----------
    accuracy : float
        The largest relative distance of a speed from that of the exact wave of the same height.
    apart : float
        How long the waves must have been clear of each other, as a part of the time since the last of the first collisions.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    accuracy: float = 0.01
    apart: float = 0.5

    def __post_init__(self) -> None:
        super().__post_init__()
        require(0 < self.accuracy < 1, f"accuracy = {self.accuracy:g} must lie between 0 and 1; 0.01 is usual.")
        require(0 < self.apart < 1, f"apart = {self.apart:g} must lie between 0 and 1; 0.5 is usual.")

    def begin(self, system: SemiDiscretization, t: float, state: Array) -> Watcher:
        """Waves are looked at as frames come."""
        return _Onlooker(self)


class _Onlooker(Patient):
    def __init__(self, rule: CollisionOver) -> None:
        self._rule = rule
        self._seen, self._next = 0, 8

    def at_frame(self, t: float, state: Array, so_far: SoFar) -> str:
        self._seen += 1
        if self._seen < self._next:
            return ""
        self._next = int(self._seen * LOOK_AGAIN) + 1
        with so_far() as dataset:
            return self._verdict(dataset.load())

    def _verdict(self, dataset: object) -> str:
        try:
            tracks = track(dataset, newborn=False)  # type: ignore[arg-type]
        except InputError:
            return ""
        moments = first_collision(tracks)["moment"].values
        if tracks.sizes["wave"] < 2 or not np.isfinite(moments).all():
            return ""
        last, now = float(moments.max()), float(tracks["t"][-1])
        late = tracks.isel(t=tracks["t"].values > now - self._rule.apart * (now - last))
        if late.sizes["t"] < 2 or not bool(late["isolated"].all()):
            return ""
        speed, family = late["speed"].median("t").values, late["family_speed"].median("t").values
        settled = np.abs(speed - family) <= self._rule.accuracy * np.abs(family)
        return f"the waves met by t = {last:.4g} and have settled" if settled.all() else ""
