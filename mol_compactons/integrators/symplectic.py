"""Explicit symplectic splitting methods for oscillators q' = p / m, p' = F(q): the chain's own integrator."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import IntegrationError, require
from mol_compactons.integrators.base import Counters, Integrator, Memory, Report, no_report, steps_between
from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]

WORK_BETWEEN_REPORTS = 2 * 10**7
"""How many forces are computed between two reports of progress, about a fifth of a second."""


def _symmetric(kicks: tuple[float, ...], drifts: tuple[float, ...], odd_kicks: bool) -> tuple[Array, Array]:
    """Kicks and drifts of a symmetric method from the first half of each; the middle one makes the sums 1."""
    if odd_kicks:
        middle = 1 - 2 * sum(kicks)
        last = 0.5 - sum(drifts)
        return np.array([*kicks, middle, *reversed(kicks)]), np.array([*drifts, last, last, *reversed(drifts)])
    last, middle = 0.5 - sum(kicks), 1 - 2 * sum(drifts)
    return np.array([*kicks, last, last, *reversed(kicks)]), np.array([*drifts, middle, *reversed(drifts)])


METHODS = {
    2: (np.array([0.5, 0.5]), np.array([1.0])),
    4: _symmetric(
        (0.0829844064174052, 0.396309801498368, -0.0390563049223486), (0.245298957184271, 0.604872665711080), odd_kicks=True
    ),
    6: _symmetric(
        (0.0414649985182624, 0.198128671918067, -0.0400061921041533, 0.0752539843015807, -0.0115113874206879),
        (0.123229775946271, 0.290553797799558, -0.127049212625417, -0.246331761062075, 0.357208872795928),
        odd_kicks=False,
    ),
}
"""Kicks and drifts for each order: Verlet's method, and the methods of Nystroem type with 6 and 11 stages of Blanes and Moan,
J. Comput. Appl. Math. 142 (2002) 313, doi:10.1016/S0377-0427(01)00492-7."""


@dataclass(frozen=True)
class Symplectic(Integrator):
    """A symplectic splitting method with a fixed step for the granular chain; the energy error stays bounded for all times.

    Parameters
    ----------
    step : float
        The step, nondimensional time. Where an output interval is no multiple of it, the interval is cut into the smallest
        number of equal steps that are no longer. A step is stable up to about 1 / sqrt(largest stiffness).
    order : {2, 4, 6}
        2 is Verlet's method with one force for each step, 4 and 6 are those of Blanes and Moan with 6 and 11. Where contacts
        open, the force of an exponent below 2 is not smooth: there the orders 4 and 6 fall to 5/2, while 2 stays 2.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    step: float = 0.05
    order: Literal[2, 4, 6] = 4

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.step > 0, f"integrator.step = {self.step:g} must be positive; 0.05 is usual.")

    coarsening = 2.0
    fixed_step = exact_restart = True

    @property
    def own_tolerance(self) -> float:
        """The step."""
        return self.step

    def with_tolerance(self, tolerance: float) -> Symplectic:
        """The same method with another step."""
        return replace(self, step=tolerance)

    def check_system(self, system: SemiDiscretization) -> None:
        """Refuse a system that does not split."""
        require(
            system.split_steps is not None,
            "integrator = Symplectic is for a GranularChain; choose IDA, CVODE, Rosenbrock or Midpoint for an equation.",
        )

    def start(self, system: SemiDiscretization, state: Array, t_end: float) -> SymplecticIntegration:
        """Begin a run at t = 0 from a state of shape (2, size)."""
        self.check_system(system)
        return SymplecticIntegration(self, system, state)


class SymplecticIntegration:
    """A run of a splitting method in progress."""

    def __init__(self, settings: Symplectic, system: SemiDiscretization, state: Array) -> None:
        self.counters = Counters()
        self._settings = settings
        self._system = system
        self._state = state.copy()
        self._t = self._start = 0.0
        self._done = 0

    def memory(self) -> Memory:
        """What `recall` takes: the state, the last output time, and how many steps were taken since."""
        place = {"t": np.array(self._t), "start": np.array(self._start), "done": np.array(self._done)}
        return place | {"state": self._state.copy()}

    def recall(self, memory: Memory) -> None:
        """Be where another integration was when it gave its `memory`."""
        self._t, self._start, self._done = float(memory["t"]), float(memory["start"]), int(memory["done"])

    def advance(self, t: float, report: Report = no_report) -> Array:
        """The state at the output time t, shape (2, size).

        Raises
        ------
        IntegrationError
            If the state is no longer finite.
        """
        start = self._start
        steps = steps_between(start, t, self._settings.step)
        kicks, drifts = METHODS[self._settings.order]
        chunk = max(1, WORK_BETWEEN_REPORTS // (self._system.size * drifts.size))
        while self._done < steps:
            count = min(chunk, steps - self._done)
            assert self._system.split_steps is not None
            self._system.split_steps(self._state, (t - start) / steps, count, drifts, kicks)
            self._done += count
            self._t = start + (t - start) * self._done / steps
            self.counters.steps += count
            self.counters.evaluations += count * drifts.size + 1
            report(self._t)
        if not np.isfinite(self._state).all():
            raise IntegrationError(
                f"The state was not finite before t = {t:.6g}: integrator.step = {self._settings.step:g} is too long for the "
                "stiffness of the contacts; choose a shorter one.",
                start,
            )
        self._start, self._done = self._t, 0
        return self._state.copy()
