"""A run of SUNDIALS IDA or CVODE in progress."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import IntegrationError
from mol_compactons.integrators.base import REPORT_INTERVAL, Counters, Memory, Report, no_report
from mol_compactons.integrators.flags import CURES, SETTINGS
from mol_compactons.integrators.linear.newton import KRYLOV_DIMENSION, KrylovCallbacks
from mol_compactons.integrators.scales import (
    absolute_tolerances,
    damping_ratio,
    occupied_share,
    order_for_damping,
    ripple_persistence,
    steepened,
)
from mol_compactons.integrators.solver import Solver
from mol_compactons.runtime.capture import import_sundae
from mol_compactons.runtime.compiled import compiled
from mol_compactons.semidiscrete import SemiDiscretization

if TYPE_CHECKING:
    from mol_compactons.integrators.sundials import CVODE, IDA

Array = NDArray[np.float64]

SMALLEST_TOLERANCE = 1e-15
"""The smallest relative tolerance that SUNDIALS takes."""

HIGHEST_ORDER = {"BDF": 5, "Adams": 12}

RIPPLE_SHARE = 1 / 300
"""By what the tolerance of the local error is tightened where ripples of the grid last (`ripple_persistence`). A method of
second order has to resolve their periods, or its error stays at their size: 3e-4 behind the kink of n = 3 on 300 points."""


@compiled
def _all_finite(values: Array) -> bool:
    for component in range(values.shape[0]):
        for cell in range(values.shape[1]):
            if not math.isfinite(values[component, cell]):
                return False
    return True


class SundialsIntegration:
    """A run of IDA or CVODE in progress, stepped from output time to output time."""

    def __init__(
        self,
        name: Literal["IDA", "CVODE"],
        settings: IDA | CVODE,
        system: SemiDiscretization,
        state: Array,
        t_end: float,
        origin: float = 0.0,
    ) -> None:
        self.counters = Counters()
        self._settings = settings
        self._name = name
        self._method = getattr(settings, "method", None)
        self._system = system
        self._initial = state
        self._t_end = t_end
        self._t = self._attempt = origin
        self._latest = origin, state
        self._jacobians = 0
        self._state = np.empty_like(state)
        self._rate = np.empty_like(state)
        self._product = np.empty_like(state)
        self._solver: Solver | None = None
        self._final: Array | None = None
        self._ended = False

    def _begin(self) -> None:
        """Create the solver; the first advance does it, so that what is never advanced holds nothing of SUNDIALS."""
        system, state = self._system, self._initial
        rate = system.rate(self._t, state)
        self._insist_on_numbers(rate)
        try:
            self._solver = Solver(self._maker(state, rate), fragile=self._settings.linear_solver == "sparse")
            start = (state, rate) if self._name == "IDA" else (state,)
            self._solver.begin(self._t, *(system.fold(one) for one in start))
        except (RuntimeError, MemoryError) as error:
            raise IntegrationError(f"{self._name} could not start ({error}); {SETTINGS}.", self._t) from None

    def _maker(self, state: Array, rate: Array) -> Callable[[], Any]:
        """What makes a solver with all its options."""
        sundae = import_sundae()
        settings, system = self._settings, self._system
        # The norm of SUNDIALS is a mean over the grid, which would allow the more of an error the emptier the grid is.
        dilution = math.sqrt(occupied_share(state))
        order, local = self._order_and_tolerance(state, rate)
        rtol = max(dilution * local, SMALLEST_TOLERANCE)
        atol = np.broadcast_to(absolute_tolerances(system, state, rtol)[:, None], state.shape)
        options: dict[str, Any] = {
            "rtol": rtol,
            "atol": system.fold(atol) if settings.atol is None else dilution * settings.atol * local / settings.rtol,
            "linsolver": settings.linear_solver,
            "max_order": order,
            "max_step": settings.max_step or 0.0,
            "max_num_steps": settings.max_steps,
        }
        if self._method:
            options["method"] = self._method
        if settings.linear_solver == "krylov":
            options |= self._krylov_options()
        elif settings.linear_solver == "band":
            options |= {"lband": system.half_bandwidth, "uband": system.half_bandwidth}
        else:
            diagonals = np.empty_like(system.mass_diagonals)
            options["sparsity"] = system.sparsity
            options["jacfn"] = self._ida_jacobian(diagonals) if self._name == "IDA" else self._cvode_jacobian(diagonals)
        if self._name == "IDA":
            return partial(sundae.ida.IDA, self._residual, **options)
        return partial(sundae.cvode.CVODE, self._right_hand_side, **options)

    def _order_and_tolerance(self, state: Array, rate: Array) -> tuple[int, float]:
        """The largest order, and the tolerance of the local error that makes the error of the run follow rtol."""
        settings = self._settings
        if self._method == "Adams":
            return settings.max_order or HIGHEST_ORDER["Adams"], settings.rtol
        ratio = damping_ratio(self._system, state)
        order = settings.max_order or order_for_damping(ratio)
        # N steps of a method of order p have an error of N rtol, which falls like rtol^(p / (p + 1)).
        return order, steepened(settings.rtol, 1 / order) * RIPPLE_SHARE ** ripple_persistence(self._system, state, rate)

    def _krylov_options(self) -> dict[str, Any]:
        cvode, linear = import_sundae().cvode, KrylovCallbacks(self._system)
        return {
            "linsolver": "gmres",
            "krylov_dim": KRYLOV_DIMENSION,
            "precond": cvode.CVODEPrecond(linear.set_up_preconditioner, linear.precondition),
            "jactimes": cvode.CVODEJacTimes(None, linear.multiply),
        }

    def _count(self, t: float) -> None:
        self.counters.evaluations += 1
        if t < self._attempt:
            self.counters.failures += 1
        self._attempt = t

    def _residual(self, t: float, y: Array, yp: Array, residual: Array) -> None:
        self._count(t)
        system = self._system
        system.unfold(yp, out=self._state)
        system.apply_mass(self._state, self._product)
        system.unfold(y, out=self._state)
        system.rhs(t, self._state, self._rate)
        self._product -= self._rate
        self._insist_on_numbers(self._product)
        system.fold(self._product, out=residual)

    def _right_hand_side(self, t: float, y: Array, yp: Array) -> None:
        self._count(t)
        self._system.unfold(y, out=self._state)
        self._system.rhs(t, self._state, self._rate)
        self._insist_on_numbers(self._rate)
        self._system.fold(self._rate, out=yp)

    def _insist_on_numbers(self, values: Array) -> None:
        """SUNDIALS never returns from a step whose residual is NaN, so that this must be noticed here."""
        if not _all_finite(values):
            raise IntegrationError(
                f"The right-hand side was not finite after t = {self._t:.6g}, as where a solution blows up; raise the "
                "viscosity of the scheme tenfold, or choose another scheme (a finer grid alone blows up sooner).",
                self._t,
            )

    def _ida_jacobian(self, diagonals: Array) -> Any:
        system = self._system

        def jacobian(t: float, y: Array, yp: Array, residual: Array, cj: float, values: Array) -> None:
            system.jacobian(t, system.unfold(y, out=self._state), diagonals)
            values[:] = system.csc_values(cj * system.mass_diagonals - diagonals)

        return jacobian

    def _cvode_jacobian(self, diagonals: Array) -> Any:
        system = self._system

        def jacobian(t: float, y: Array, yp: Array, values: Array) -> None:
            system.jacobian(t, system.unfold(y, out=self._state), diagonals)
            values[:] = system.csc_values(diagonals)

        return jacobian

    def advance(self, t: float, report: Report = no_report) -> Array:
        """The state at the output time t, shape (components, size).

        Whatever it raises ends the integration, and so does the time at which the run ends.

        Raises
        ------
        IntegrationError
            With the cure, if SUNDIALS gives up, or the integration has ended before t.
        """
        if self._final is not None and t <= self._t_end:
            return self._final.copy()
        if self._ended:
            raise IntegrationError(f"The integration ended at t = {self._t:.6g} and cannot go to t = {t:.6g}.", self._t)
        try:
            state = self._advance(t, report)
        except BaseException:
            self.close()
            raise
        if t >= self._t_end:
            self._final = state.copy()
            self.close()
        return state

    def _advance(self, t: float, report: Report) -> Array:
        tried = 0
        if self._solver is None:
            self._begin()
        while self._t < t:
            deadline = time.monotonic() + REPORT_INTERVAL
            while self._t < t and time.monotonic() < deadline:
                if tried >= self._settings.max_steps:
                    raise self._failure(-1)
                # The first step depends on the time that is asked for; that of the end is none of its business.
                result = self._solve(t, "onestep")
                # A step below round-off leaves t where it is, and is none of those that are reported.
                tried += 1
                self.counters.steps += result.t > self._t
                self._t = result.t
                if self._t < t:
                    self._latest = self._t, result.y
            report(min(self._t, t))
        folded = self._solve(t, "normal").y
        self._latest = t, folded
        return self._system.unfold(folded)

    def memory(self) -> Memory:
        """What `IDA.resume` and `CVODE.resume` take: the last step, or the last output time where the step is beyond it."""
        t, state = self._latest
        return {"t": np.array(t), "state": state if state.ndim > 1 else self._system.unfold(state)}

    def close(self) -> None:
        """Free the solver, and count what it said; without it that is done where the integration ends."""
        self._ended = True
        if self._solver is not None:
            self._solver.free()
            lines = self._solver.messages()
            self.counters.warnings += len(lines)
            self.counters.first_warning = self.counters.first_warning or "".join(lines[:1])

    def _solve(self, t: float, method: str) -> Any:
        """One step of the solver ("onestep"), or the interpolated solution at t ("normal")."""
        assert self._solver is not None
        try:
            result = self._solver.step(t, method)
        except KeyError as unlisted_flag:
            raise self._failure(int(unlisted_flag.args[0])) from None
        except IntegrationError:
            raise
        except RuntimeError as error:
            raise IntegrationError(f"{self._name} gave up at t = {self._t:.6g} ({error}); {SETTINGS}.", self._t) from None
        self.counters.jacobians += result.njev - self._jacobians
        self._jacobians = result.njev
        if result.status < 0:
            raise self._failure(result.status)
        return result

    def _failure(self, flag: int) -> IntegrationError:
        cure = CURES[self._name].get(flag, f"SUNDIALS returned the flag {flag}; {SETTINGS}")
        return IntegrationError(f"{self._name} gave up at t = {self._t:.6g}: {cure}.", self._t)
