"""An adaptive, L-stable Rosenbrock method of fifth order, Rodas5P, with a mass matrix and banded LU."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import IntegrationError, require
from mol_compactons.integrators.base import (
    REPORT_INTERVAL,
    Counters,
    Integrator,
    Memory,
    Report,
    insist_on_a_band,
    no_report,
)
from mol_compactons.integrators.linear.newton import BandedMatrix
from mol_compactons.integrators.scales import absolute_tolerances, ripple_persistence, steepened, time_scale
from mol_compactons.integrators.sundials import CVODE
from mol_compactons.runtime.compiled import compiled
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.stencils import convolve

Array = NDArray[np.float64]

STAGES = 8
ORDER = 5


def _lower(rows: tuple[tuple[float, ...], ...]) -> Array:
    """A strictly lower triangular matrix from its rows, of which the first is empty."""
    matrix = np.zeros((STAGES, STAGES))
    for index, row in enumerate(rows, start=1):
        matrix[index, : len(row)] = row
    return matrix


GAMMA = 0.21193756319429014

_SIXTH = (-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946)

STATES = _lower(
    (
        (3.0,),
        (2.849394379747939, 0.45842242204463923),
        (-6.954028509809101, 2.489845061869568, -10.358996098473584),
        (2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641),
        _SIXTH,
        (*_SIXTH, 1.0),
        (*_SIXTH, 1.0, 1.0),
    )
)

SLOPES = _lower(
    (
        (-14.155112264123755,),
        (-17.97296035885952, -2.859693295451294),
        (147.12150275711716, -1.41221402718213, 71.68940251302358),
        (165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306),
        (24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471),
        (
            30.91273214028599,
            -3.1208243349937974,
            77.79954646070892,
            34.28646028294783,
            -19.097331116725623,
            -28.087943162872662,
        ),
        (
            37.80277123390563,
            -3.2571969029072276,
            112.26918849496327,
            66.9347231244047,
            -40.06618937091002,
            -54.66780262877968,
            -9.48861652309627,
        ),
    )
)

INTERPOLATION = np.array(
    [
        [
            25.948786856663858,
            -2.5579724845846235,
            10.433815404888879,
            -2.3679251022685204,
            0.524948541321073,
            1.1241088310450404,
            0.4272876194431874,
            -0.17202221070155493,
        ],
        [
            -9.91568850695171,
            -0.9689944594115154,
            3.0438037242978453,
            -24.495224566215796,
            20.176138334709044,
            15.98066361424651,
            -6.789040303419874,
            -6.710236069923372,
        ],
        [
            11.419903575922262,
            2.8879645146136994,
            72.92137995996029,
            80.12511834622643,
            -52.072871366152654,
            -59.78993625266729,
            -0.15582684282751913,
            4.883087185713722,
        ],
    ]
)
"""The coefficients of Rodas5P: Steinebach, BIT Numer. Math. 63 (2023) 27, doi:10.1007/s10543-023-00967-x, in the form that
needs no products with the Jacobian, as tabulated in OrdinaryDiffEq.jl."""

_TRANSFORMATION = np.linalg.inv(np.eye(STAGES) / GAMMA - SLOPES)

TIMES = STATES @ _TRANSFORMATION @ np.ones(STAGES)
"""The times of the stages, in steps: the sums of the coefficients that a method with products has."""

TIME_SLOPES = _TRANSFORMATION @ np.ones(STAGES)
"""The factors of h df/dt in the stages."""

TIME_DIFFERENCE = 1e-6
"""Over what part of a step df/dt is taken."""

STEP_POWER = 1 / (ORDER - 1)
"""By which power of rtol the local error falls faster: the steps add up, and there are more of them."""

RIPPLE_SHARE, RIPPLE_POWER = 1 / 10, 1 / 6
"""By what the tolerance of the local error is tightened where ripples of the grid last (`ripple_persistence`), at rtol = 1e-3
and, as a power of rtol, below. ``python -m benchmarks.tolerances`` shows what it does."""

FIRST_STEP = 1e-3
"""The step to begin with, in the time in which the state changes."""

SMALLEST_STEP = 1e-12
"""The shortest step, relative to that time and to the time that has been reached."""

LARGEST_GROWTH, SMALLEST_GROWTH, CAUTION = 5.0, 0.2, 0.9


@dataclass(frozen=True)
class Rosenbrock(Integrator):
    r"""Rodas5P, a Rosenbrock method of order 5 with eight stages, L-stable.

        (M / (gamma h) - J) k_i = f(y + sum a_ij k_j) + M sum c_ij k_j / h

    One Jacobian, one banded LU and eight solves for each step, and no Newton iteration; the frames come from its interpolant
    of fourth order. For systems with a banded Jacobian. Where f depends on t as such, each stage has its own time and a share
    of df/dt, which is taken by a difference.

    Parameters
    ----------
    rtol : float
        Relative tolerance of the error of a run, in the root mean square over the part of the grid that the state occupies.
        That of the local error is made from it: it falls like rtol^(5/4), and is ten times smaller where ripples of the grid
        last (`integrators.scales.ripple_persistence`).
    atol : float or None
        Absolute tolerance; None for rtol / 100 times the largest value of each component.
    max_step : float or None
        Largest step, nondimensional time.
    max_steps : int
        Largest number of steps between two output times.

    Raises
    ------
    InputError
        If a value is out of its range, or the Jacobian is not banded.

    Notes
    -----
    Source: Steinebach, BIT Numer. Math. 63 (2023) 27, doi:10.1007/s10543-023-00967-x.
    """

    rtol: float = 1e-4
    atol: float | None = None
    max_step: float | None = None
    max_steps: int = 100_000

    def __post_init__(self) -> None:
        super().__post_init__()
        require(1e-13 <= self.rtol <= 0.1, f"integrator.rtol = {self.rtol:g} must lie between 1e-13 and 0.1; 1e-4 is usual.")
        for name in ("atol", "max_step"):
            value = getattr(self, name)
            require(value is None or value > 0, f"integrator.{name} = {value} must be positive, or none for the default.")
        require(self.max_steps >= 1, f"integrator.max_steps = {self.max_steps} must be at least 1.")

    exact_restart = True

    def with_tolerance(self, tolerance: float) -> Rosenbrock:
        """The same with another relative tolerance; an absolute one goes along."""
        atol = None if self.atol is None else self.atol * tolerance / self.rtol
        return replace(self, rtol=tolerance, atol=atol)

    def alternatives(self) -> Sequence[Integrator]:
        """CVODE with a Krylov solver, for schemes without a banded Jacobian."""
        return (CVODE(rtol=self.rtol, atol=self.atol, linear_solver="krylov"),)

    def check_system(self, system: SemiDiscretization) -> None:
        """Refuse a system whose Jacobian is not banded."""
        insist_on_a_band(system, "Rosenbrock")

    def start(self, system: SemiDiscretization, state: Array, t_end: float) -> RosenbrockIntegration:
        """Begin a run at t = 0 from a state of shape (components, size)."""
        self.check_system(system)
        return RosenbrockIntegration(self, system, state)


class RosenbrockIntegration:
    """A run of the Rosenbrock method in progress, which steps on its own and interpolates the frames."""

    def __init__(self, settings: Rosenbrock, system: SemiDiscretization, state: Array) -> None:
        self.counters = Counters()
        self._settings = settings
        self._system = system
        self._matrix = BandedMatrix(system)
        self._t = self._t_before = 0.0
        self._last_step = 0.0
        self._state = state.copy()
        self._before = state.copy()
        rate = system.rate(0.0, state)
        changes_in = time_scale(state, rate)
        changes_in = changes_in if np.isfinite(changes_in) else 1.0
        self._shortest = SMALLEST_STEP * changes_in
        self._step = min(FIRST_STEP * changes_in, settings.max_step or np.inf)
        weight = ripple_persistence(system, state, rate)
        self._rtol = steepened(settings.rtol, STEP_POWER + RIPPLE_POWER * weight) * RIPPLE_SHARE**weight
        default = absolute_tolerances(system, state, self._rtol)
        self._atol = default if settings.atol is None else np.full(len(state), settings.atol * self._rtol / settings.rtol)
        self._stages = np.zeros((STAGES, *state.shape))
        self._argument, self._slope, self._rate, self._product = np.empty((4, *state.shape))

    def memory(self) -> Memory:
        """What `recall` takes: where the last step began and ended, with its stages, and how it is controlled."""
        control = self._t, self._t_before, self._step, self._last_step, self._rtol, self._shortest
        return {
            "t": np.array(self._t),
            "state": self._state.copy(),
            "before": self._before.copy(),
            "stages": self._stages.copy(),
            "control": np.array(control),
            "atol": self._atol.copy(),
        }

    def recall(self, memory: Memory) -> None:
        """Be where another integration was when it gave its `memory`."""
        self._state, self._before = memory["state"].copy(), memory["before"].copy()
        self._stages[:] = memory["stages"]
        control = [float(value) for value in memory["control"]]
        self._t, self._t_before, self._step, self._last_step, self._rtol, self._shortest = control
        self._atol = memory["atol"].copy()

    def advance(self, t: float, report: Report = no_report) -> Array:
        """The state at the output time t, shape (components, size).

        Raises
        ------
        IntegrationError
            If the step becomes too small, or too many are needed.
        """
        first, reported = self.counters.steps, time.monotonic()
        while self._t < t:
            if self.counters.steps - first >= self._settings.max_steps:
                raise IntegrationError(
                    f"Rosenbrock gave up at t = {self._t:.6g}: it did not reach the next output time within max_steps steps; "
                    "raise integrator.max_steps, or loosen the tolerances.",
                    self._t,
                )
            self._take_step()
            if time.monotonic() - reported > REPORT_INTERVAL:
                reported = time.monotonic()
                report(min(self._t, t))
        report(t)
        return self._interpolated(t)

    def _take_step(self) -> None:
        """One step, repeated with shorter ones until its error is accepted."""
        settings = self._settings
        self._matrix.linearize(self._t, self._state)
        self.counters.jacobians += 1
        while True:
            step = self._step
            if step < max(self._shortest, SMALLEST_STEP * self._t):
                raise IntegrationError(
                    f"Rosenbrock gave up at t = {self._t:.6g}: its step became too small, as where a solution loses "
                    "smoothness; raise the viscosity of the scheme tenfold, or tighten integrator.rtol.",
                    self._t,
                )
            error = np.inf
            if self._matrix.factor_linearized(GAMMA * step):
                self._compute_stages(step)
                np.add(self._argument, self._stages[-1], out=self._argument)
                error = _error(self._stages[-1], self._state, self._argument, self._rtol, self._atol)
            growth = CAUTION * max(error, 1e-10) ** (-1 / ORDER) if np.isfinite(error) else SMALLEST_GROWTH
            self._step = min(step * min(max(growth, SMALLEST_GROWTH), LARGEST_GROWTH), settings.max_step or np.inf)
            if error <= 1:
                break
            self.counters.failures += 1
        self._before, self._state, self._argument = self._state, self._argument, self._before
        self._t_before, self._t, self._last_step = self._t, self._t + step, step
        self.counters.steps += 1

    def _compute_stages(self, step: float) -> None:
        """Write the stages, and the argument of the last, with the factors of M - gamma step J."""
        system = self._system
        time_slope = self._time_slope(step) if system.explicit_time else None
        for stage in range(STAGES):
            _combine(self._state, self._stages, STATES, SLOPES, stage, 1 / step, self._argument, self._slope)
            system.rhs(self._t + TIMES[stage] * step, self._argument, self._rate)
            if time_slope is not None:
                self._rate += TIME_SLOPES[stage] * step * time_slope
            if system.mass is None:
                _complete(self._rate, self._slope, GAMMA * step)
            else:
                _complete_with_mass(self._rate, system.mass, self._slope, self._product, GAMMA * step)
            self._matrix.solve_into(self._rate, self._stages[stage])
        self.counters.evaluations += STAGES

    def _time_slope(self, step: float) -> Array:
        """df/dt at the beginning of a step."""
        ahead, here = np.empty((2, *self._state.shape))
        self._system.rhs(self._t + TIME_DIFFERENCE * step, self._state, ahead)
        self._system.rhs(self._t, self._state, here)
        self.counters.evaluations += 2
        return np.asarray((ahead - here) / (TIME_DIFFERENCE * step))

    def _interpolated(self, t: float) -> Array:
        """The state at a time within the last step."""
        if t >= self._t or not self._last_step:
            return self._state.copy()
        theta = (t - self._t_before) / self._last_step
        first, second, third = INTERPOLATION
        weights = theta * (1 - theta) * (first + theta * (second + theta * third))
        return np.asarray((1 - theta) * self._before + theta * self._state + np.tensordot(weights, self._stages, 1))


@compiled
def _combine(
    state: Array, stages: Array, states: Array, slopes: Array, stage: int, rate: float, argument: Array, slope: Array
) -> None:
    """Write y + sum a_ij k_j and sum c_ij k_j / h for a stage i."""
    argument[:] = state
    slope[:] = 0.0
    for other in range(stage):
        a, c = states[stage, other], rate * slopes[stage, other]
        for row in range(state.shape[0]):
            for j in range(state.shape[1]):
                argument[row, j] += a * stages[other, row, j]
                slope[row, j] += c * stages[other, row, j]


@compiled
def _complete(rate: Array, slope: Array, factor: float) -> None:
    """Write (f + s) times a factor into f."""
    for row in range(rate.shape[0]):
        for j in range(rate.shape[1]):
            rate[row, j] = factor * (rate[row, j] + slope[row, j])


@compiled
def _complete_with_mass(rate: Array, mass: Array, slope: Array, product: Array, factor: float) -> None:
    """Write (f + M s) times a factor into f."""
    for row in range(rate.shape[0]):
        convolve(mass, slope[row], product[row])
    _complete(rate, product, factor)


@compiled
def _error(difference: Array, old: Array, new: Array, rtol: float, atol: Array) -> float:
    """The root mean square of the error relative to the tolerances, over as many cells as the new state occupies.

    These are, for each component, the sum of its squares divided by the largest of them; the larger of two components counts.
    """
    worst = 0.0
    for row in range(old.shape[0]):
        total, squares, largest = 0.0, 0.0, 0.0
        for j in range(old.shape[1]):
            scale = atol[row] + rtol * max(abs(old[row, j]), abs(new[row, j]))
            total += (difference[row, j] / scale) ** 2
            square = new[row, j] * new[row, j]
            squares += square
            largest = max(largest, square)
        occupied = squares / largest if largest > 0.0 and squares < np.inf else 1.0
        worst = max(worst, total / occupied) if total == total else np.inf
    return float(np.sqrt(worst))
