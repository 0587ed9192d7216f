"""The implicit midpoint rule: the paper's own integrator, composed to higher orders, and its energy-preserving relative."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import IntegrationError, require
from mol_compactons.integrators.base import Counters, Integrator, Memory, Report, no_report, rounded, steps_between
from mol_compactons.integrators.linear.newton import NewtonMatrix, newton_matrix
from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]

MAX_ITERATIONS = 25
"""Iterations with one and the same matrix, and again with a fresh matrix in each, before a step is given up."""

REFRESH_AFTER = 5
"""After a step with more iterations than this the next one starts with a fresh matrix."""

MOST_POINTS = 8
"""The largest number of Gauss points along a step."""

_SUZUKI = 1 / (4 - 4 ** (1 / 3))
_KAHAN_LI = (0.39216144400731413928, 0.33259913678935943860, -0.70624617255763935981, 0.08221359629355080023)

COMPOSITIONS = {
    2: (1.0,),
    4: (_SUZUKI, _SUZUKI, 1 - 4 * _SUZUKI, _SUZUKI, _SUZUKI),
    6: (*_KAHAN_LI, 1 - 2 * sum(_KAHAN_LI), *reversed(_KAHAN_LI)),
}
"""The parts of a step, of which each is one of the basic rule, for each order. Suzuki, Phys. Lett. A 146 (1990) 319,
doi:10.1016/0375-9601(90)90962-N; Kahan and Li, Math. Comp. 66 (1997) 1089, doi:10.1090/S0025-5718-97-00873-9."""


@dataclass(frozen=True)
class Midpoint(Integrator):
    r"""The implicit midpoint rule M (y1 - y0) = tau f(t + tau/2, (y0 + y1) / 2) with a fixed step, and two extensions.

    The rule conserves every quadratic invariant of the semi-discretisation, up to the tolerance of its Newton iteration, and
    so does its composition to order 4 or 6. With more `points` than one, f at the middle gives way to its Gauss average along
    the step,

    .. math::  M (y_1 - y_0) = \tau \sum_i w_i f(t + c_i \tau, y_0 + c_i (y_1 - y_0)),

    the averaged-vector-field rule, which conserves the Hamiltonian of a Hamiltonian semi-discretisation instead: to round-off
    where f is a polynomial of a degree below 2 points, as that of the compact scheme for n = 3 with 2 points.

    Parameters
    ----------
    step : float
        The step tau, nondimensional time; the paper has 0.01. Where an output interval is no multiple of it, the interval is
        cut into the smallest number of equal steps that are no longer.
    tolerance : float
        The Newton iteration ends when the change of the state is below this, relative to the largest |y|.
    order : {2, 4, 6}
        2 is the rule itself; 4 and 6 compose 5 and 9 of it, some of them backwards in time.
    points : int
        The number of Gauss points along a step, 1 to 8.

    Raises
    ------
    InputError
        If a value is out of its range.

    Notes
    -----
    Newton's method is the modified one: the matrix M - tau/2 df/dy is kept as long as the iteration converges. Where df/dy is
    not banded it is solved with by preconditioned GMRES.
    Source: Vladimirov and Skurativskyi (2015), section 4; Hairer, Lubich and Wanner, "Geometric Numerical Integration" (2006),
    doi:10.1007/3-540-30666-8; Quispel and McLaren, J. Phys. A 41 (2008) 045206, doi:10.1088/1751-8113/41/4/045206.
    """

    step: float = 0.01
    tolerance: float = 1e-12
    order: Literal[2, 4, 6] = 2
    points: int = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.step > 0, f"integrator.step = {self.step:g} must be positive; the paper has 0.01.")
        require(
            1e-15 <= self.tolerance <= 1e-2,
            f"integrator.tolerance = {self.tolerance:g} must lie between 1e-15 and 1e-2; 1e-12 is usual.",
        )
        require(
            1 <= self.points <= MOST_POINTS,
            f"integrator.points = {self.points} must lie between 1, the midpoint, and {MOST_POINTS}.",
        )

    coarsening = 2.0
    fixed_step = exact_restart = True

    @property
    def own_tolerance(self) -> float:
        """The step."""
        return self.step

    def with_tolerance(self, tolerance: float) -> Midpoint:
        """The same method with another step."""
        return replace(self, step=tolerance)

    def start(self, system: SemiDiscretization, state: Array, t_end: float) -> MidpointIntegration:
        """Begin a run at t = 0 from a state of shape (components, size)."""
        return MidpointIntegration(self, system, state)


class MidpointIntegration:
    """A run of the midpoint rule in progress."""

    def __init__(self, settings: Midpoint, system: SemiDiscretization, state: Array) -> None:
        self.counters = Counters()
        self._settings = settings
        self._system = system
        self._t = self._start = 0.0
        self._done = 0
        self._state = state.copy()
        self._slope = np.zeros_like(state)
        self._matrices: dict[float, NewtonMatrix] = {}
        self._factored: dict[float, tuple[float, Array, float]] = {}
        self._iterations = 0
        nodes, weights = np.polynomial.legendre.leggauss(settings.points)
        self._nodes, self._weights = (1 + nodes) / 2, weights / 2

    def memory(self) -> Memory:
        """What `recall` takes: the state and its slope, where in the interval it is, and where matrices were made."""
        lengths, made = list(self._factored), list(self._factored.values())
        return {
            "t": np.array(self._t),
            "state": self._state.copy(),
            "slope": self._slope.copy(),
            "place": np.array([self._start, self._done, self._iterations]),
            "lengths": np.array(lengths),
            "matrix_times": np.array([[t, gamma] for t, _, gamma in made]).reshape(-1, 2),
            "matrix_states": np.array([middle for _, middle, _ in made]).reshape(-1, *self._state.shape),
        }

    def recall(self, memory: Memory) -> None:
        """Be where another integration was when it gave its `memory`."""
        self._t, self._slope = float(memory["t"]), memory["slope"].copy()
        self._start = float(memory["place"][0])
        self._done, self._iterations = (int(number) for number in memory["place"][1:])
        for length, (t, gamma), middle in zip(memory["lengths"], memory["matrix_times"], memory["matrix_states"], strict=True):
            matrix = self._matrices[float(length)] = newton_matrix(self._system)
            matrix.factor(float(t), middle, float(gamma))
            self._factored[float(length)] = float(t), middle, float(gamma)

    def advance(self, t: float, report: Report = no_report) -> Array:
        """The state at the output time t, shape (components, size).

        Raises
        ------
        IntegrationError
            If Newton's method does not converge.
        """
        start = self._start
        steps = steps_between(start, t, self._settings.step)
        while self._done < steps:
            for part in COMPOSITIONS[self._settings.order]:
                self._part(part * (t - start) / steps)
            self._done += 1
            self._t = start + (t - start) * self._done / steps
            self.counters.steps += 1
            report(self._t)
        self._start, self._done = self._t, 0
        return self._state.copy()

    def _part(self, step: float) -> None:
        """One step of the basic rule."""
        if self._iterations > REFRESH_AFTER:
            self._matrices.clear()
            self._factored.clear()
        length = rounded(step)
        change = self._newton(self._matrices[length], step, fresh=False) if length in self._matrices else None
        if change is None:
            matrix = self._matrices[length] = newton_matrix(self._system)
            self._factor(matrix, self._state + 0.5 * step * self._slope, step)
            change = self._newton(matrix, step, fresh=False)
            change = self._newton(matrix, step, fresh=True) if change is None else change
        if change is None:
            raise IntegrationError(
                f"Newton's method of the midpoint rule did not converge at t = {self._t:.6g}; choose a smaller "
                "integrator.step or add viscosity.",
                self._t,
            )
        self._t += step
        self._state += change
        self._slope = change / step

    def _factor(self, matrix: NewtonMatrix, middle: Array, step: float) -> None:
        if not matrix.factor(self._t + 0.5 * step, middle, 0.5 * step):
            raise IntegrationError(f"The matrix of the midpoint rule is singular at t = {self._t:.6g}.", self._t)
        self._factored[rounded(step)] = self._t + 0.5 * step, middle.copy(), 0.5 * step
        self.counters.jacobians += 1

    def _newton(self, matrix: NewtonMatrix, step: float, fresh: bool) -> Array | None:
        """The change of the state over one step, or None if the iteration does not converge.

        With `fresh` the matrix is computed anew in each iteration, and the first guess is no change.
        """
        change = np.zeros_like(self._state) if fresh else step * self._slope
        rate, average, product = np.empty((3, *change.shape))
        scale = max(float(np.abs(self._state).max()), 1e-300)
        last = np.inf
        for self._iterations in range(1, MAX_ITERATIONS + 1):
            middle = self._state + 0.5 * change
            if fresh:
                self._factor(matrix, middle, step)
            average[:] = 0
            for node, weight in zip(self._nodes, self._weights, strict=True):
                self._system.rhs(self._t + node * step, self._state + node * change, rate)
                average += weight * rate
                self.counters.evaluations += 1
            self._system.apply_mass(change, product)
            correction = matrix.solve(self._t + 0.5 * step, middle, product - step * average)
            change -= correction
            size = float(np.abs(correction).max()) / scale
            if size <= self._settings.tolerance:
                return change
            if not size < 10 * last:
                return None
            last = size
        return None
