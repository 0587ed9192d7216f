"""What the error flags of SUNDIALS mean, and what to do about them."""

from __future__ import annotations

ACCURACY = "raise integrator.rtol or integrator.atol"
SMOOTHNESS = "as where a solution loses smoothness; raise the viscosity of the scheme tenfold, or loosen the tolerances"
LINEAR = "choose the other integrator.linear_solver"
DATA = "check the initial data"
SETTINGS = "check the settings of the integrator"
MEMORY = "choose a smaller grid"

COMMON_CURES = {
    -1: "it did not reach the next output time within max_steps steps; raise integrator.max_steps, or loosen the tolerances",
    -2: f"the tolerances ask for more than double precision can give; {ACCURACY}",
    -3: f"the error test failed again and again, {SMOOTHNESS}",
    -4: f"the Newton iteration did not converge even with the smallest step, {SMOOTHNESS}",
    -5: f"the linear solver could not be set up; {LINEAR}",
    -6: f"the linear solver could not factor the Jacobian; {LINEAR}",
    -7: f"the linear solver failed; {LINEAR}",
    -8: f"the right-hand side could not be evaluated; {DATA}",
    -22: f"a setting was refused; {SETTINGS}",
}

CURES = {
    "IDA": COMMON_CURES
    | {
        -9: f"the residual failed again and again, {SMOOTHNESS}",
        -12: f"the residual could not be evaluated at the start; {DATA}",
        -13: f"the line search for consistent initial rates failed; {DATA}",
        -14: f"no consistent initial rates were found; {DATA}",
        -15: f"the Newton iteration could not be set up; {SETTINGS}",
        -16: f"the Newton iteration could not be set up for a step; {LINEAR}",
        -17: f"the Newton iteration failed; {SMOOTHNESS}",
        -21: f"there was not enough memory; {MEMORY}",
        -24: "an error weight became zero; set a positive integrator.atol",
        -28: f"a vector operation failed; {MEMORY}",
    },
    "CVODE": COMMON_CURES
    | {
        -9: f"the right-hand side could not be evaluated at the start; {DATA}",
        -10: f"the right-hand side failed again and again, {SMOOTHNESS}",
        -11: f"the right-hand side failed beyond recovery, {SMOOTHNESS}",
        -13: f"the Newton iteration could not be set up; {SETTINGS}",
        -14: f"the Newton iteration could not be set up for a step; {LINEAR}",
        -16: f"the Newton iteration failed, {SMOOTHNESS}",
        -20: f"there was not enough memory; {MEMORY}",
        -27: "the output time is too close to the initial time; choose a larger t_end or fewer frames",
    },
}
"""What each flag of SUNDIALS means, and what to do. Flags that this program cannot provoke (events, constraints, projections)
share one sentence."""
