"""Rules that end a run before its last time: what a rule is, and those that look at a state alone."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import Settings
from mol_compactons.errors import require
from mol_compactons.semidiscrete import SemiDiscretization, drift_scale

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

SoFar = Callable[[], "xr.Dataset"]
"""Gives the frames that have been recorded."""


class Watcher(Protocol):
    """A rule at work in one run."""

    def go_on(self, t: float, state: Array) -> None:
        """The run goes on from an earlier one, at t with a state of shape (components, size)."""

    def between(self, t: float) -> str:
        """Why to stop between two output times; empty to go on."""

    def at_frame(self, t: float, state: Array, so_far: SoFar) -> str:
        """Why to stop after the frame at t, whose state has shape (components, size); empty to go on."""


class StopRule(Settings):
    """A rule that ends a run, cleanly, before its last time. A subclass is a frozen dataclass; it has to give `begin`.

    The status of a run that was stopped is "stopped at t = ...: " and what its watcher said. It can be gone on from.
    """

    @abstractmethod
    def begin(self, system: SemiDiscretization, t: float, state: Array) -> Watcher:
        """A watcher for a run that began at t = 0 with a state of shape (components, size), wherever it goes on from."""


class Patient:
    """A `Watcher` that never stops a run, to derive others from."""

    def go_on(self, t: float, state: Array) -> None:
        """What was at first stays what it was."""

    def between(self, t: float) -> str:
        """Go on."""
        return ""

    def at_frame(self, t: float, state: Array, so_far: SoFar) -> str:
        """Go on."""
        return ""


@dataclass(frozen=True)
class WallClock(StopRule):
    """Stops a run before the time that a batch queue allows it is over, between two steps.

    Parameters
    ----------
    seconds : float
        The time that the run may take, by the clock on the wall.

    Raises
    ------
    InputError
        If it is not positive.
    """

    seconds: float

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.seconds > 0, f"seconds = {self.seconds:g} must be positive; give the time that the run may take.")

    def begin(self, system: SemiDiscretization, t: float, state: Array) -> Watcher:
        """The clock starts now."""
        return _Clock(self.seconds)


class _Clock(Patient):
    def __init__(self, seconds: float) -> None:
        self._seconds, self._end = seconds, time.monotonic() + seconds

    def between(self, t: float) -> str:
        return f"{self._seconds:g} s have passed" if time.monotonic() > self._end else ""

    def at_frame(self, t: float, state: Array, so_far: SoFar) -> str:
        return self.between(t)


@dataclass(frozen=True)
class BlowUp(StopRule):
    """Stops a run whose state grows beyond all that its initial data allow.

    Parameters
    ----------
    factor : float
        It stops where a component is more than so many times as large as its largest value at first.

    Raises
    ------
    InputError
        If the factor is not above 1.
    """

    factor: float = 10.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.factor > 1, f"factor = {self.factor:g} must be above 1; 10 is usual.")

    def begin(self, system: SemiDiscretization, t: float, state: Array) -> Watcher:
        """Sizes are those of this state; a component that is zero has no bound."""
        return _Bound(self.factor, np.abs(state).max(axis=1))


class _Bound(Patient):
    def __init__(self, factor: float, sizes: Array) -> None:
        self._factor, self._sizes = factor, sizes

    def at_frame(self, t: float, state: Array, so_far: SoFar) -> str:
        known = self._sizes > 0
        growth = float((np.abs(state).max(axis=1)[known] / self._sizes[known]).max()) if known.any() else 0.0
        return f"the state is {growth:.3g} times as large as at first" if growth > self._factor else ""


@dataclass(frozen=True)
class DriftBound(StopRule):
    """Stops a run that does not keep what its equation conserves.

    Parameters
    ----------
    bound : float
        The largest change, relative to what `drift` takes: the first value or, where its parts cancel, the sum of their sizes.
    quantity : str
        Which conserved quantity is watched; empty for all.

    Raises
    ------
    InputError
        If the bound is not positive, or the system conserves nothing of that name.
    """

    bound: float = 1e-3
    quantity: str = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.bound > 0, f"bound = {self.bound:g} must be positive; 1e-3 is usual.")

    def begin(self, system: SemiDiscretization, t: float, state: Array) -> Watcher:
        """Changes are from the values of this state."""
        first = system.invariants(state)
        names = [self.quantity] if self.quantity else list(first)
        require(
            set(names) <= set(first),
            f"quantity = {self.quantity!r} is not conserved here; choose one of {', '.join(first) or 'none'}.",
        )
        magnitudes = system.magnitudes(state)
        sizes = {name: drift_scale(value, magnitudes.get(name, abs(value))) for name, value in first.items()}
        return _Kept(self.bound, system, {name: first[name] for name in names}, sizes)


class _Kept(Patient):
    def __init__(self, bound: float, system: SemiDiscretization, first: dict[str, float], sizes: dict[str, float]) -> None:
        self._bound, self._system, self._first, self._sizes = bound, system, first, sizes

    def at_frame(self, t: float, state: Array, so_far: SoFar) -> str:
        now = self._system.invariants(state)
        for name, value in self._first.items():
            change = abs(now[name] - value)
            if not change <= self._bound * self._sizes[name]:
                return f"{name} has changed by {change / (self._sizes[name] or 1.0):.2g}"
        return ""


@dataclass(frozen=True)
class SteadyState(StopRule):
    r"""Stops a run that stands still: \|y_t\| < rate \|y\| in L2, for all components together, from frame to frame.

    Parameters
    ----------
    rate : float
        The relative change in a unit of time, nondimensional, that counts as none.

    Raises
    ------
    InputError
        If it is not positive.
    """

    rate: float = 1e-8

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.rate > 0, f"rate = {self.rate:g} must be positive; 1e-8 is usual.")

    def begin(self, system: SemiDiscretization, t: float, state: Array) -> Watcher:
        """The first change is that from this state."""
        return _Still(self.rate, t, state)


class _Still(Patient):
    def __init__(self, rate: float, t: float, state: Array) -> None:
        self._rate = rate
        self.go_on(t, state)

    def go_on(self, t: float, state: Array) -> None:
        self._t, self._state = t, state.copy()

    def at_frame(self, t: float, state: Array, so_far: SoFar) -> str:
        size = float(np.linalg.norm(state))
        change = float(np.linalg.norm(state - self._state)) / (t - self._t) if t > self._t else np.inf
        self.go_on(t, state)
        return "the state stands still" if change <= self._rate * size else ""
