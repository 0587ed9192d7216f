"""What an integrator is to the rest of the program: its settings, a run of it in progress, and what that has cost."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, TypeVar, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import Settings
from mol_compactons.errors import IntegrationError, require
from mol_compactons.semidiscrete import SemiDiscretization

Own = TypeVar("Own", bound="Integrator")

REPORT_INTERVAL = 0.2
"""Seconds between two reports of progress within an output interval."""

Memory = dict[str, NDArray[Any]]
"""What an integration needs to go on from where it is: arrays by name, the time ``t`` and the ``state`` there among them."""

Report = Callable[[float], None]
"""Called now and then with the time reached."""


def no_report(t: float) -> None:
    """A `Report` that says nothing."""


def steps_between(start: float, end: float, step: float) -> int:
    """Into how many equal steps, none longer than `step` but by round-off, the time between two frames is cut."""
    return max(1, math.ceil((end - start) / step * (1 - 1e-9))) if end > start else 0


def rounded(step: float) -> float:
    """A step without its last digits: output intervals differ by round-off, and steps no farther apart share a matrix."""
    return float(f"{step:.9e}")


@dataclass
class Counters:
    """What a run has cost so far.

    Parameters
    ----------
    steps, evaluations, jacobians, failures : int
        Accepted steps, evaluations of f or of the residual (those for difference-quotient Jacobians included), Jacobians,
        and step attempts that were repeated with a smaller step.
    warnings : int
        How many lines SUNDIALS printed on the way.
    first_warning : str
        The first of them.
    """

    steps: int = 0
    evaluations: int = 0
    jacobians: int = 0
    failures: int = 0
    warnings: int = 0
    first_warning: str = ""


class Integration(Protocol):
    """A run in progress."""

    counters: Counters

    def advance(self, t: float, report: Report = no_report) -> NDArray[np.float64]:
        """The state at the output time t, shape (components, size); raises `IntegrationError`."""


@runtime_checkable
class RemembersItself(Protocol):
    """An integration that says what it needs to go on, between two output times too."""

    def memory(self) -> Memory:
        """What `Integrator.resume` takes; to be asked for between two steps."""


@runtime_checkable
class CanBeClosed(Protocol):
    """An integration that holds what is to be let go."""

    def close(self) -> None:
        """End it, wherever it is."""


ORIGIN = "origin"
"""The entry of a memory that has the time at which an integration began that did not begin at t = 0, and its own clock."""


class ShiftedIntegration:
    """An integration that began at t = 0 with its clock shifted, for methods that can only begin there.

    Parameters
    ----------
    inner : Integration
        It takes times from `origin` on as times from 0.
    origin : float
        When it began.
    state : array, shape (components, size)
        What it began with.
    """

    def __init__(self, inner: Integration, origin: float, state: NDArray[np.float64]) -> None:
        self._inner, self._origin = inner, origin
        self._latest = origin, state

    @property
    def counters(self) -> Counters:
        """What the inner one has cost."""
        return self._inner.counters

    @counters.setter
    def counters(self, counters: Counters) -> None:
        self._inner.counters = counters

    def advance(self, t: float, report: Report = no_report) -> NDArray[np.float64]:
        """The state at the output time t, shape (components, size); raises `IntegrationError`."""
        try:
            state = self._inner.advance(t - self._origin, lambda inner: report(self._origin + inner))
        except IntegrationError as error:
            raise IntegrationError(str(error), self._origin + error.t) from None
        self._latest = t, state
        return state

    def memory(self) -> Memory:
        """What the inner one remembers, with its origin; of one that does not, the last output time and the state there."""
        if isinstance(self._inner, RemembersItself):
            inner = self._inner.memory()
            return {
                **inner,
                "t": np.array(self._origin + float(inner["t"])),
                ORIGIN: np.array([self._origin, float(inner["t"])]),
            }
        t, state = self._latest
        return {"t": np.array(t), "state": state}

    def close(self) -> None:
        """End the inner one, where that holds what is to be let go."""
        if isinstance(self._inner, CanBeClosed):
            self._inner.close()


class Integrator(Settings):
    """A method that takes a semi-discretisation through time. A subclass is a frozen dataclass; it has to give `start`.

    Its accuracy is one number, `own_tolerance`: a relative tolerance or a step. By default that is the field ``rtol``; where
    it has another name, both `own_tolerance` and `with_tolerance` are to be given.
    """

    coarsening: ClassVar[float] = 10.0
    """By what factor a study loosens the tolerance to see what it does."""

    exact_restart: ClassVar[bool] = False
    """Whether a run that goes on from its memory equals one that was not interrupted, bit for bit."""

    fixed_step: ClassVar[bool] = False
    """Whether `own_tolerance` is a step, and the time between two frames is cut into equal ones as `steps_between` says."""

    @abstractmethod
    def start(self, system: SemiDiscretization, state: NDArray[np.float64], t_end: float) -> Integration:
        """Begin a run at t = 0 from a state of shape (components, size)."""

    def resume(self, system: SemiDiscretization, memory: Memory, t_end: float) -> Integration:
        """Go on from what an integration of the same method and system remembered.

        A method with `exact_restart` goes on as if it had not been interrupted; its integrations have to be `RemembersItself`.
        Any other starts anew from the state that is remembered, which changes the result by no more than its tolerance.
        """
        if not self.exact_restart:
            return self.restart(system, float(memory["t"]), memory["state"], t_end)
        if ORIGIN in memory:
            origin, inner = (float(value) for value in memory[ORIGIN])
            own = {name: value for name, value in memory.items() if name != ORIGIN} | {"t": np.array(inner)}
            integration = self.resume(system.from_time(origin), own, t_end - origin)
            return ShiftedIntegration(integration, origin, memory["state"])
        integration = self.start(system, memory["state"], t_end)
        cast(Any, integration).recall(memory)
        return integration

    def restart(self, system: SemiDiscretization, t: float, state: NDArray[np.float64], t_end: float) -> Integration:
        """Begin anew at a time with a state of shape (components, size)."""
        return ShiftedIntegration(self.start(system.from_time(t), state, t_end - t), t, state)

    def check_system(self, system: SemiDiscretization) -> None:
        """Raise `InputError` for a system that the method cannot take; by default it takes any."""

    @property
    def own_tolerance(self) -> float:
        """The tolerance or step that its error follows."""
        return float(cast(Any, self).rtol)

    def with_tolerance(self: Own, tolerance: float) -> Own:
        """The same method with another tolerance or step."""
        return cast(Own, replace(cast(Any, self), rtol=tolerance))

    def taken(self, interval: float) -> float:
        """The tolerance or step that a run has whose frames are an interval apart: a fixed step is cut to fit into it."""
        return interval / steps_between(0.0, interval, self.own_tolerance) if self.fixed_step else self.own_tolerance

    def alternatives(self) -> Sequence[Integrator]:
        """What takes its place, with the same tolerance, where it cannot take a system; the first that can is used."""
        return ()


def insist_on_a_band(system: SemiDiscretization, integrator: str) -> None:
    """Refuse a system that only a Krylov solver can take."""
    require(
        system.jacobian_vector is None,
        f"{integrator} needs a banded Jacobian, which this scheme has not; choose integrator=CVODE(linear_solver='krylov').",
    )
