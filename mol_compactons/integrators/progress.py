"""What every integrator shares: the counters of a run, and the form of a run in progress."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

REPORT_INTERVAL = 0.2
"""Seconds between two reports of progress within an output interval."""

Report = Callable[[float], None]
"""Called now and then with the time reached."""


def no_report(t: float) -> None:
    """A `Report` that says nothing."""


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
