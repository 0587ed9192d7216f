"""SUNDIALS IDA and CVODE, through scikit-sundae."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import require
from mol_compactons.integrators.base import Integrator, Memory, insist_on_a_band
from mol_compactons.integrators.linear.newton import KrylovCallbacks
from mol_compactons.integrators.sundials_integration import HIGHEST_ORDER, SundialsIntegration
from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]

Own = TypeVar("Own", bound="_BackwardDifferences")


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

    def resume(self, system: SemiDiscretization, memory: Memory, t_end: float) -> SundialsIntegration:
        """Begin anew from the state that an integration remembered: the history of the steps is lost."""
        return SundialsIntegration("IDA", self, system, memory["state"], t_end, float(memory["t"]))


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

    def resume(self, system: SemiDiscretization, memory: Memory, t_end: float) -> SundialsIntegration:
        """Begin anew from the state that an integration remembered: the history of the steps is lost."""
        return SundialsIntegration("CVODE", self, system, memory["state"], t_end, float(memory["t"]))
