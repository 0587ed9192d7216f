"""Collocation at Gauss points: implicit Runge-Kutta methods that keep every quadratic invariant, and their derivative."""

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

MAX_ITERATIONS = 30
"""Iterations with one and the same matrix, and again with a fresh matrix in each, before a step is given up."""

REFRESH_AFTER = 8
"""After a step with more iterations than this the next one starts with a fresh matrix."""

ROUNDING = 2e-16
"""A change of the stages below this, relative to the state, is none."""

STALLED_BELOW = 1e-10
"""A change below this, relative to the state, that no longer shrinks by half is rounding too."""

TANGENTS_AT_ONCE = 256
"""So many are pushed in one go, lest a whole monodromy matrix be held several times."""


@dataclass(frozen=True)
class GaussLegendre(Integrator):
    r"""Gauss-Legendre collocation of order 4 or 6 with a fixed step.

    With s = 2 or 3 nodes c_i, the zeros of the shifted Legendre polynomial, and their coefficients a_ij and b_i:

    .. math::  M Z_i = \tau \sum_j a_{ij} f(t + c_j \tau, y_0 + Z_j), \qquad y_1 = y_0 + \sum_i d_i Z_i, \quad d = b A^{-1}

    It is symmetric and symplectic, and keeps every quadratic invariant of the semi-discretisation to round-off, as the stages
    are solved to round-off.

    Parameters
    ----------
    step : float
        The step tau, nondimensional time. Where an output interval is no multiple of it, the interval is cut into the
        smallest number of equal steps that are no longer.
    order : {4, 6}
        The power of the step at which the error falls: 2 s.

    Raises
    ------
    InputError
        If the step is not positive, or there is no such order.

    Notes
    -----
    The stages are solved for together, by the modified Newton method: M - tau A J is a band matrix as M - tau J is, with s
    unknowns for each one of these, and is kept as long as the iteration converges. Where df/dy is not banded it is solved
    with by preconditioned GMRES. Source: Hairer, Lubich and Wanner, "Geometric Numerical Integration" (2006), II.1.3 and
    VIII.6, doi:10.1007/3-540-30666-8.
    """

    step: float = 0.01
    order: Literal[4, 6] = 4

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.step > 0, f"integrator.step = {self.step:g} must be positive; 0.01 is usual.")

    coarsening = 2.0
    fixed_step = exact_restart = True

    @property
    def own_tolerance(self) -> float:
        """The step."""
        return self.step

    def with_tolerance(self, tolerance: float) -> GaussLegendre:
        """The same method with another step."""
        return replace(self, step=tolerance)

    def start(self, system: SemiDiscretization, state: Array, t_end: float) -> GaussLegendreIntegration:
        """Begin a run at t = 0 from a state of shape (components, size)."""
        return GaussLegendreIntegration(self, system, state)


@dataclass(frozen=True)
class Tableau:
    """The coefficients of collocation at s Gauss points.

    Parameters
    ----------
    nodes : array, shape (s,)
        c.
    matrix : array, shape (s, s)
        A.
    update : array, shape (s,)
        d = b A^-1, with which the stages make up the step.
    ahead : array, shape (s, s)
        Maps the stages of a step to those that the collocation polynomial has in the next one.
    """

    nodes: Array
    matrix: Array
    update: Array
    ahead: Array


def tableau(order: int) -> Tableau:
    """The coefficients of an even order 2 s."""
    points, weights = np.polynomial.legendre.leggauss(order // 2)
    nodes, powers = (1 + points) / 2, np.arange(1, order // 2 + 1)
    moments = nodes[:, None] ** (powers - 1)
    matrix = np.linalg.solve(moments.T, (nodes[:, None] ** powers / powers).T).T
    update = np.linalg.solve(matrix.T, weights / 2)
    monomials = nodes[:, None] ** powers
    ahead = np.linalg.solve(monomials.T, ((1 + nodes[:, None]) ** powers - 1).T).T
    return Tableau(nodes, np.asarray(matrix), update, np.asarray(ahead))


class Stages:
    """The equations of the stages on the ring of a system: M Z - step (A x 1) f(y + Z) = 0.

    A Z has shape (s components, size), stage after stage. `at` says from which t and y and with which step.
    """

    def __init__(self, system: SemiDiscretization, coefficients: Tableau) -> None:
        self._system, self._coefficients = system, coefficients
        self._shape = (coefficients.nodes.size, system.components, system.size)
        self._t, self._step, self._state = 0.0, 0.0, np.zeros(self._shape[1:])
        self._companion = None if system.companion is None else Stages(system.companion, coefficients)
        self.ring: SemiDiscretization = SemiDiscretization(
            size=system.size,
            components=self._shape[0] * self._shape[1],
            reach=system.reach,
            rhs=self._rates,
            jacobian=self._jacobian,
            invariants=lambda state: {},
            mass=system.mass,
            jacobian_vector=None if system.jacobian_vector is None else self._product,
            companion=self._companion.ring if self._companion else None,
        )

    def at(self, t: float, state: Array, step: float) -> None:
        """Take a step from t and a state of shape (components, size)."""
        self._t, self._state, self._step = t, state, step
        if self._companion:
            self._companion.at(t, state, step)

    def _mixed(self, rates: Array) -> Array:
        """A times what each stage has, shape (s, components, size)."""
        return np.asarray(np.einsum("ij,j...->i...", self._coefficients.matrix, rates)).reshape(-1, self._shape[2])

    def _places(self, stages: Array) -> list[tuple[float, Array]]:
        """The time and the state of each stage."""
        times = self._t + self._coefficients.nodes * self._step
        return list(zip(times.tolist(), self._state + stages.reshape(self._shape), strict=True))

    def _rates(self, t: float, stages: Array, out: Array) -> None:
        rates = np.empty(self._shape)
        for (time, state), rate in zip(self._places(stages), rates, strict=True):
            self._system.rhs(time, state, rate)
        out[:] = self._mixed(rates)

    def slopes(self, stages: Array) -> Array:
        """The cyclic diagonals of df/dy at each stage, shape (s, components, components, 2 reach + 1, size)."""
        count, components, size = self._shape
        slopes = np.empty((count, components, components, 2 * self._system.reach + 1, size))
        for (time, state), slope in zip(self._places(stages), slopes, strict=True):
            self._system.jacobian(time, state, slope)
        return slopes

    def _jacobian(self, t: float, stages: Array, out: Array) -> None:
        blocks = np.einsum("ij,jrcdk->irjcdk", self._coefficients.matrix, self.slopes(stages))
        out[:] = blocks.reshape(out.shape)

    def _product(self, t: float, stages: Array, vector: Array, out: Array) -> None:
        products = np.empty(self._shape)
        moved = vector.reshape(self._shape)
        assert self._system.jacobian_vector is not None
        for (time, state), one, product in zip(self._places(stages), moved, products, strict=True):
            self._system.jacobian_vector(time, state, np.ascontiguousarray(one), product)
        out[:] = self._mixed(products)

    def pushes(self, slopes: Array, tangent: Array) -> Array:
        """The derivative of A f by y along tangents of shape (K, components, size), shape (K, s components, size)."""
        reach = self._system.reach
        pushed = np.zeros((self._shape[0], tangent.shape[0], *self._shape[1:]))
        for place in range(2 * reach + 1):
            shifted = np.roll(tangent, reach - place, axis=-1)
            pushed += np.einsum("srcj,kcj->skrj", slopes[:, :, :, place], shifted)
        mixed = np.einsum("ij,jkrn->kirn", self._coefficients.matrix, pushed)
        return np.ascontiguousarray(mixed.reshape(tangent.shape[0], -1, self._shape[2]))


class GaussLegendreIntegration:
    """A run of Gauss-Legendre collocation in progress."""

    def __init__(self, settings: GaussLegendre, system: SemiDiscretization, state: Array) -> None:
        self.counters = Counters()
        self._settings, self._system = settings, system
        self._coefficients = tableau(settings.order)
        self._stages = Stages(system, self._coefficients)
        self._t = self._start = 0.0
        self._done = 0
        self._state = state.astype(np.float64)
        self._guess = np.zeros((self._stages.ring.components, system.size))
        self._length = 0.0
        self._matrices: dict[float, NewtonMatrix] = {}
        self._factored: dict[float, tuple[float, float, Array, Array]] = {}
        self._iterations = 0

    def memory(self) -> Memory:
        """What `recall` takes: the state, the guess of the stages, the place, and where matrices were made."""
        made = list(self._factored.values())
        return {
            "t": np.array(self._t),
            "state": self._state.copy(),
            "guess": self._guess.copy(),
            "place": np.array([self._start, self._done, self._iterations, self._length]),
            "lengths": np.array(list(self._factored)),
            "matrix_times": np.array([[t, step] for t, step, _, _ in made]).reshape(-1, 2),
            "matrix_states": np.array([state for _, _, state, _ in made]).reshape(-1, *self._state.shape),
            "matrix_stages": np.array([stages for _, _, _, stages in made]).reshape(-1, *self._guess.shape),
        }

    def recall(self, memory: Memory) -> None:
        """Be where another integration was when it gave its `memory`."""
        self._t, self._guess = float(memory["t"]), memory["guess"].copy()
        start, done, iterations, length = (float(number) for number in memory["place"])
        self._start, self._done, self._iterations, self._length = start, int(done), int(iterations), length
        entries = (memory[name] for name in ("lengths", "matrix_times", "matrix_states", "matrix_stages"))
        for rounded_step, (t, step), state, stages in zip(*entries, strict=True):
            matrix = self._matrices[float(rounded_step)] = newton_matrix(self._stages.ring)
            self._stages.at(float(t), state, float(step))
            matrix.factor(float(t), stages, float(step))
            self._factored[float(rounded_step)] = float(t), float(step), state, stages

    def advance(self, t: float, report: Report = no_report) -> Array:
        """The state at the output time t, shape (components, size).

        Raises
        ------
        IntegrationError
            If Newton's method does not converge.
        """
        return self.advance_with_tangents(t, np.empty((0, *self._state.shape)), report)[0]

    def advance_with_tangents(self, t: float, tangents: Array, report: Report = no_report) -> tuple[Array, Array]:
        """The state at the output time t, and what the derivative of the map to it makes of tangents.

        Parameters
        ----------
        t : float
            The time to reach.
        tangents : array, shape (K, components, size)
            Small changes of the state now; the derivative is that of the method itself, exact to round-off.

        Returns
        -------
        state, tangents
            Of the same shapes.

        Raises
        ------
        IntegrationError
            If Newton's method does not converge.
        """
        start = self._start
        steps = steps_between(start, t, self._settings.step)
        while self._done < steps:
            tangents = self._step((t - start) / steps, tangents)
            self._done += 1
            self._t = start + (t - start) * self._done / steps
            self.counters.steps += 1
            report(self._t)
        self._start, self._done = self._t, 0
        return self._state.copy(), tangents

    def _step(self, step: float, tangents: Array) -> Array:
        """One step of the state; the tangents after it are returned."""
        if self._iterations > REFRESH_AFTER:
            self._matrices.clear()
            self._factored.clear()
        length = rounded(step)
        if length != self._length:
            self._guess[:] = 0.0
        self._length = length
        self._stages.at(self._t, self._state, step)
        stages = self._newton(self._matrices[length], step, fresh=False) if length in self._matrices else None
        if stages is None:
            matrix = self._matrices[length] = newton_matrix(self._stages.ring)
            self._factor(matrix, self._guess, step)
            stages = self._newton(matrix, step, fresh=False)
            stages = self._newton(matrix, step, fresh=True) if stages is None else stages
        if stages is None:
            raise IntegrationError(
                f"Newton's method of Gauss-Legendre collocation did not converge at t = {self._t:.6g}; choose a smaller "
                "integrator.step or add viscosity.",
                self._t,
            )
        tangents = self._changed(tangents, stages, step) if tangents.size else tangents
        self._state += self._made_up(stages)
        parts = stages.reshape(self._coefficients.nodes.size, -1)
        self._guess = np.asarray(self._coefficients.ahead @ parts).reshape(self._guess.shape)
        return tangents

    def _made_up(self, stages: Array) -> Array:
        """The change over a step, shape (components, size)."""
        parts = stages.reshape(self._coefficients.nodes.size, *self._state.shape)
        return np.asarray(np.einsum("i,i...->...", self._coefficients.update, parts))

    def _changed(self, tangents: Array, stages: Array, step: float) -> Array:
        """The tangents after a step: M zeta = step A J (v + zeta), with J at the stages."""
        matrix = newton_matrix(self._stages.ring)
        self._factor(matrix, stages, step, kept=False)
        slopes, changed = self._stages.slopes(stages), tangents.copy()
        for first in range(0, len(changed), TANGENTS_AT_ONCE):
            block = changed[first : first + TANGENTS_AT_ONCE]
            for tangent, push in zip(block, self._stages.pushes(slopes, block), strict=True):
                tangent += self._made_up(matrix.solve(self._t, stages, step * push))
        return changed

    def _factor(self, matrix: NewtonMatrix, stages: Array, step: float, kept: bool = True) -> None:
        if not matrix.factor(self._t, stages, step):
            raise IntegrationError(f"The matrix of Gauss-Legendre collocation is singular at t = {self._t:.6g}.", self._t)
        if kept:
            self._factored[rounded(step)] = self._t, step, self._state.copy(), stages.copy()
        self.counters.jacobians += 1

    def _newton(self, matrix: NewtonMatrix, step: float, fresh: bool) -> Array | None:
        """The stages of one step, or None if the iteration does not converge.

        With `fresh` the matrix is computed anew in each iteration, and the first guess is no change.
        """
        ring = self._stages.ring
        stages = np.zeros_like(self._guess) if fresh else self._guess.copy()
        rates, product = np.empty((2, *stages.shape))
        last = np.inf
        for self._iterations in range(1, MAX_ITERATIONS + 1):
            if fresh:
                self._factor(matrix, stages, step)
            ring.rhs(self._t, stages, rates)
            self.counters.evaluations += self._coefficients.nodes.size
            ring.apply_mass(stages, product)
            correction = matrix.solve(self._t, stages, product - step * rates)
            stages -= correction
            size = self._size_of(correction, stages)
            if size <= ROUNDING or (size <= STALLED_BELOW and size > last / 2):
                return stages
            if not size < 10 * last:
                return None
            last = size
        return None

    def _size_of(self, correction: Array, stages: Array) -> float:
        """The largest correction of a component, relative to the largest value of that component."""
        shape = (-1, *self._state.shape)
        reached = np.abs(self._state + stages.reshape(shape)).max(axis=(0, 2))
        return float((np.abs(correction.reshape(shape)).max(axis=(0, 2)) / np.maximum(reached, 1e-300)).max())
