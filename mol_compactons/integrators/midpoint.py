"""The implicit midpoint rule with Newton's method: the paper's own integrator."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import check
from mol_compactons.errors import IntegrationError, require
from mol_compactons.integrators.progress import Counters, Report, no_report
from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]

MAX_ITERATIONS = 25
"""Iterations with one and the same matrix, and again with a fresh matrix in each, before a step is given up."""

REFRESH_AFTER = 5
"""After a step with more iterations than this the next one starts with a fresh matrix."""


@dataclass(frozen=True)
class Midpoint:
    """The implicit midpoint rule M (y1 - y0) = tau f(t + tau/2, (y0 + y1) / 2), second order, with a fixed step.

    It conserves every quadratic invariant of the semi-discretisation, up to the tolerance of its Newton iteration.

    Parameters
    ----------
    step : float
        The step tau, nondimensional time; the paper has 0.01. Where an output interval is no multiple of it, the interval is
        cut into the smallest number of equal steps that are no longer.
    tolerance : float
        The Newton iteration ends when the change of the state is below this, relative to the largest |y|.

    Raises
    ------
    InputError
        If a value is out of its range.

    Notes
    -----
    Newton's method is the modified one: the banded LU of M - tau/2 df/dy is kept as long as the iteration converges.
    Source: Vladimirov and Skurativskyi (2015), section 4; Hairer, Lubich and Wanner, "Geometric Numerical Integration" (2006),
    doi:10.1007/3-540-30666-8.
    """

    step: float = 0.01
    tolerance: float = 1e-12

    def __post_init__(self) -> None:
        check(self)
        require(self.step > 0, f"integrator.step = {self.step:g} must be positive; the paper has 0.01.")
        require(
            1e-15 <= self.tolerance <= 1e-2,
            f"integrator.tolerance = {self.tolerance:g} must lie between 1e-15 and 1e-2; 1e-12 is usual.",
        )

    def check_system(self, system: SemiDiscretization) -> None:
        """Refuse a system whose Jacobian is not banded."""
        require(
            system.jacobian_vector is None,
            "Midpoint needs a banded Jacobian, which this scheme has not; choose integrator=CVODE(linear_solver='krylov').",
        )

    def start(self, system: SemiDiscretization, state: Array, t_end: float) -> MidpointIntegration:
        """Begin a run at t = 0 from a state of shape (components, size)."""
        return MidpointIntegration(self, system, state)


class MidpointIntegration:
    """A run of the midpoint rule in progress."""

    def __init__(self, settings: Midpoint, system: SemiDiscretization, state: Array) -> None:
        from scipy.linalg import lapack

        self.counters = Counters()
        self._lapack: Any = lapack
        self._settings = settings
        self._system = system
        self._t = 0.0
        self._state = state.copy()
        self._change = np.zeros_like(state)
        self._width = system.half_bandwidth
        self._lu: Any = None
        self._lu_step = 0.0
        self._iterations = 0
        self._diagonals = np.empty_like(system.mass_diagonals)

    def advance(self, t: float, report: Report = no_report) -> Array:
        """The state at the output time t, shape (components, size).

        Raises
        ------
        IntegrationError
            If Newton's method does not converge.
        """
        start = self._t
        steps = max(1, math.ceil((t - start) / self._settings.step * (1 - 1e-9))) if t > start else 0
        for index in range(steps):
            self._step((t - start) / steps)
            self._t = start + (t - start) * (index + 1) / steps
            report(self._t)
        return self._state.copy()

    def _factor(self, middle: Array, t: float, step: float) -> None:
        system = self._system
        system.jacobian(t, middle, self._diagonals)
        band = system.banded(system.mass_diagonals - 0.5 * step * self._diagonals)
        lu, pivots, info = self._lapack.dgbtrf(band, self._width, self._width)
        if info != 0:
            raise IntegrationError(f"The matrix of the midpoint rule is singular at t = {self._t:.6g}.", self._t)
        self._lu, self._lu_step = (lu, pivots), step
        self.counters.jacobians += 1

    def _step(self, step: float) -> None:
        t = self._t + step / 2
        if self._lu is None or self._iterations > REFRESH_AFTER or abs(self._lu_step - step) > 1e-9 * step:
            self._factor(self._state + 0.5 * self._change, t, step)
        change = self._newton(self._change, t, step, fresh=False)
        if change is None:
            change = self._newton(np.zeros_like(self._state), t, step, fresh=True)
        if change is None:
            raise IntegrationError(
                f"Newton's method of the midpoint rule did not converge at t = {self._t:.6g}; choose a smaller "
                "integrator.step or add viscosity.",
                self._t,
            )
        self._state += change
        self._change = change
        self.counters.steps += 1

    def _newton(self, guess: Array, t: float, step: float, fresh: bool) -> Array | None:
        """The change of the state over one step, or None if the iteration does not converge.

        With `fresh` the matrix is computed anew in each iteration.
        """
        system = self._system
        change = guess.copy()
        rate, product = np.empty_like(change), np.empty_like(change)
        scale = max(float(np.abs(self._state).max()), 1e-300)
        last = np.inf
        for self._iterations in range(1, MAX_ITERATIONS + 1):
            middle = self._state + 0.5 * change
            if fresh:
                self._factor(middle, t, step)
            system.rhs(t, middle, rate)
            self.counters.evaluations += 1
            system.apply_mass(change, product)
            product -= step * rate
            lu, pivots = self._lu
            correction, _ = self._lapack.dgbtrs(lu, self._width, self._width, system.fold(product), pivots)
            change -= system.unfold(correction)
            size = float(np.abs(correction).max()) / scale
            if size <= self._settings.tolerance:
                return change
            if not size < 10 * last:
                return None
            last = size
        return None
