"""SUNDIALS IDA and CVODE, through scikit-sundae."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import IntegrationError, require
from mol_compactons.integrators.base import REPORT_INTERVAL, Counters, Integrator, Report, insist_on_a_band, no_report
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

Array = NDArray[np.float64]

Own = TypeVar("Own", bound="_BackwardDifferences")

SMALLEST_TOLERANCE = 1e-15
"""The smallest relative tolerance that SUNDIALS takes."""

HIGHEST_ORDER = {"BDF": 5, "Adams": 12}

RIPPLE_SHARE = 1 / 300
"""By what the tolerance of the local error is tightened where ripples of the grid last (`ripple_persistence`). A method of
second order has to resolve their periods, or its error stays at their size: 3e-4 behind the kink of n = 3 on 300 points."""


@dataclass(frozen=True)
class _BackwardDifferences(Integrator):
    """The settings that IDA and CVODE share; see `IDA`."""

    rtol: float = 1e-5
    atol: float | None = None
    linear_solver: Literal["band", "sparse", "krylov"] = "band"
    max_order: int | None = None
    max_step: float | None = None
    max_steps: int = 100_000

    def __post_init__(self) -> None:
        super().__post_init__()
        require(
            1e-15 <= self.rtol <= 0.1,
            f"integrator.rtol = {self.rtol:g} must lie between 1e-15 and 0.1; 1e-5 is usual.",
        )
        for name, least in (("atol", 1e-100), ("max_step", 0.0)):
            value = getattr(self, name)
            require(
                value is None or value > least,
                f"integrator.{name} = {value} must be {f'above {least:g}' if least else 'positive'}, or none for the default.",
            )
        order, highest = self.max_order, HIGHEST_ORDER[getattr(self, "method", "BDF")]
        require(
            order is None or 1 <= order <= highest,
            f"integrator.max_order = {order} must lie between 1 and {highest}, or be none.",
        )
        require(1 <= self.max_steps < 2**31, f"integrator.max_steps = {self.max_steps} must lie between 1 and 2147483647.")

    def with_tolerance(self: Own, tolerance: float) -> Own:
        """The same with another relative tolerance; an absolute one goes along."""
        atol = None if self.atol is None else self.atol * tolerance / self.rtol
        return replace(self, rtol=tolerance, atol=atol)

    def alternatives(self) -> Sequence[Integrator]:
        """CVODE, that with a Krylov solver, and IDA."""
        common = {"rtol": self.rtol, "atol": self.atol, "max_step": self.max_step, "max_steps": self.max_steps}
        return CVODE(**common), CVODE(**common, linear_solver="krylov"), IDA(**common)  # type: ignore[arg-type]


@dataclass(frozen=True)
class IDA(_BackwardDifferences):
    """SUNDIALS IDA, variable-order BDF for M y' - f(t, y) = 0.

    Parameters
    ----------
    rtol : float
        Relative tolerance of the error of a run, in the root mean square over the part of the grid that the initial state
        occupies, so that it means the same in a longer box. SUNDIALS controls the local error; its tolerance is made from
        this one (Notes).
    atol : float or None
        Absolute tolerance; None for rtol / 100 times the largest value of each component, so that it means the same for small
        waves.
    linear_solver : {"band", "sparse", "krylov"}
        "band": folded band LU with SUNDIALS' own difference quotients; "sparse": SuperLU_MT with the analytic Jacobian, which
        keeps linear invariants to round-off; "krylov" (CVODE only): preconditioned GMRES, for schemes without a banded
        Jacobian.
    max_order : int or None
        Largest BDF order, 1 to 5. None chooses it from the damping: orders 3 to 5 are unstable for the nearly imaginary
        spectrum of an undamped system.
    max_step : float or None
        Largest step, nondimensional time.
    max_steps : int
        Largest number of steps between two output times.

    Raises
    ------
    InputError
        If a value is out of its range.

    Notes
    -----
    The tolerance of the local error is rtol where rtol is 1e-3, and falls like rtol^(1 + 1/p) for the order p, since tighter
    steps are more and add up. Where ripples of the grid last (`integrators.scales.ripple_persistence`) it is up to 300 times
    smaller: a step that does not resolve a ripple loses it, and local control does not see the sum of such losses. An
    undamped system therefore takes up to 7 times the steps of a damped one, and below rtol = 1e-7 round-off is near.
    Source: Hindmarsh et al., ACM TOMS 31 (2005) 363, doi:10.1145/1089014.1089020.
    """

    def check_system(self, system: SemiDiscretization) -> None:
        """Refuse a system whose Jacobian is not banded."""
        insist_on_a_band(system, "IDA")
        require(self.linear_solver != "krylov", "integrator.linear_solver = 'krylov' is for CVODE; choose 'band' for IDA.")

    def start(self, system: SemiDiscretization, state: Array, t_end: float) -> SundialsIntegration:
        """Begin a run at t = 0 from a state of shape (components, size)."""
        return SundialsIntegration("IDA", self, system, state, t_end)


@dataclass(frozen=True)
class CVODE(_BackwardDifferences):
    """SUNDIALS CVODE, variable-order BDF or Adams for y' = f(t, y), where there is no mass matrix.

    Parameters
    ----------
    rtol, atol, linear_solver, max_order, max_step, max_steps
        As for `IDA`; the Adams method has orders up to 12.
    method : {"BDF", "Adams"}
        "Adams" for the chain alone: it is unstable for the fast ripples of a grid, whose growth passes its control of the
        local error.

    Raises
    ------
    InputError
        If a value is out of its range, the system has a mass matrix, or the Adams method is chosen for an equation on a grid.

    Notes
    -----
    Source: Hindmarsh et al., ACM TOMS 31 (2005) 363, doi:10.1145/1089014.1089020.
    """

    method: Literal["BDF", "Adams"] = "BDF"

    def check_system(self, system: SemiDiscretization) -> None:
        """Refuse a system with a mass matrix, or one that does not suit the linear solver."""
        if self.linear_solver == "krylov":
            KrylovCallbacks(system)
        else:
            insist_on_a_band(system, f"CVODE with linear_solver = {self.linear_solver!r}")
        require(
            self.method == "BDF" or system.split_steps is not None,
            "integrator = CVODE(method='Adams') is unstable for the fast ripples of a grid and is for a GranularChain only; "
            "choose CVODE(method='BDF'), IDA or Rosenbrock for an equation.",
        )
        require(
            system.mass is None,
            "integrator = CVODE cannot take a scheme with a mass matrix; choose IDA, Rosenbrock, Midpoint, or another scheme.",
        )

    def start(self, system: SemiDiscretization, state: Array, t_end: float) -> SundialsIntegration:
        """Begin a run at t = 0 from a state of shape (components, size)."""
        self.check_system(system)
        return SundialsIntegration("CVODE", self, system, state, t_end)


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
    ) -> None:
        self.counters = Counters()
        self._settings = settings
        self._name = name
        self._system = system
        self._initial = state
        self._t_end = t_end
        self._t = 0.0
        self._attempt = 0.0
        self._state = np.empty_like(state)
        self._rate = np.empty_like(state)
        self._product = np.empty_like(state)
        self._solver: Solver | None = None
        self._final: Array | None = None
        self._ended = False

    def _begin(self) -> None:
        """Create the solver; the first advance does it, so that what is never advanced holds nothing of SUNDIALS."""
        system, state = self._system, self._initial
        rate = system.rate(0.0, state)
        self._insist_on_numbers(rate)
        try:
            self._solver = Solver(self._maker(state, rate), fragile=self._settings.linear_solver == "sparse")
            start = (state, rate) if self._name == "IDA" else (state,)
            self._solver.begin(*(system.fold(one) for one in start))
        except (RuntimeError, MemoryError) as error:
            raise IntegrationError(f"{self._name} could not start ({error}); {SETTINGS}.", 0.0) from None

    def _maker(self, state: Array, rate: Array) -> Callable[[], Any]:
        """What makes a solver with all its options."""
        sundae = import_sundae()
        settings, system = self._settings, self._system
        # The norm of SUNDIALS is a mean over the grid, which would allow the more of an error the emptier the grid is.
        dilution = math.sqrt(occupied_share(state))
        order, local = self._order_and_tolerance(state, rate)
        rtol = max(dilution * local, SMALLEST_TOLERANCE)
        atol = np.broadcast_to(absolute_tolerances(system, state, self._t_end, rtol)[:, None], state.shape)
        options: dict[str, Any] = {
            "rtol": rtol,
            "atol": system.fold(atol) if settings.atol is None else dilution * settings.atol * local / settings.rtol,
            "linsolver": settings.linear_solver,
            "max_order": order,
            "max_step": settings.max_step or 0.0,
            "max_num_steps": settings.max_steps,
        }
        if isinstance(settings, CVODE):
            options["method"] = settings.method
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
        if isinstance(settings, CVODE) and settings.method == "Adams":
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
                result = self._solve(self._t_end, "onestep")
                # A step below round-off leaves t where it is, and is none of those that are reported.
                tried += 1
                self.counters.steps += result.t > self._t
                self._t = result.t
            report(min(self._t, t))
        return self._system.unfold(self._solve(t, "normal").y)

    def close(self) -> None:
        """Free the solver, and count what it said; without it that is done where the integration ends."""
        self._ended = True
        if self._solver is not None:
            self._solver.free()
            lines = self._solver.messages()
            self.counters.warnings, self.counters.first_warning = len(lines), "".join(lines[:1])

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
        self.counters.jacobians = result.njev
        if result.status < 0:
            raise self._failure(result.status)
        return result

    def _failure(self, flag: int) -> IntegrationError:
        cure = CURES[self._name].get(flag, f"SUNDIALS returned the flag {flag}; {SETTINGS}")
        return IntegrationError(f"{self._name} gave up at t = {self._t:.6g}: {cure}.", self._t)
