"""The error in time follows the tolerance, or the step, for what is offered together."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks import tolerances
from mol_compactons import CVODE, IDA, Midpoint, Rosenbrock, Symplectic
from mol_compactons.integrators.base import Integrator

Array = NDArray[np.float64]
FAMILIES = dict(tolerances.families())


@cache
def case(family: str, index: int) -> tuple[tolerances.Problem, Array]:
    problem = FAMILIES[family][index]
    return problem, problem.reference()


def followed(family: str, index: int, integrator: Integrator) -> bool:
    problem, reference = case(family, index)
    return problem.follows(integrator, problem.errors(integrator, reference))


@pytest.mark.parametrize(
    ("family", "integrator"),
    [
        ("conservative, order 4", IDA()),
        ("conservative, order 4", Rosenbrock()),
        ("compact, wide", IDA()),
        ("compact, wide", Rosenbrock()),
        ("conservative, order 4, damped", CVODE()),
        ("conservative, order 4, damped", Rosenbrock()),
        ("compact, nearest, damped", IDA()),
        ("K(2, 2), default", IDA()),
        ("K(2, 2), default", Rosenbrock()),
        ("chain, Hertz", CVODE(method="Adams")),
        ("chain, Hertz", IDA()),
        ("chain, Hertz", Symplectic(order=4)),
        ("chain, Hertz", Midpoint()),
    ],
    ids=lambda value: tolerances.described(value) if isinstance(value, Integrator) else value,
)
def test_a_wave_of_its_own_shape(family: str, integrator: Integrator) -> None:
    assert followed(family, 0, integrator)


@pytest.mark.parametrize(
    ("integrator", "index"), [(IDA(), 1), (IDA(), 2), (CVODE(), 1), (CVODE(), 2), (Rosenbrock(), 2), (Midpoint(), 1)]
)
def test_a_smooth_wave_and_a_collision(integrator: Integrator, index: int) -> None:
    assert followed("conservative, order 2, damped" if index == 2 else "conservative, order 2", index, integrator)


@pytest.mark.parametrize("integrator", [Symplectic(order=4), Symplectic(order=6)])
def test_waves_that_meet_show_the_formal_order_where_no_contact_opens(integrator: Integrator) -> None:
    assert followed("chain, prestressed", 1, integrator)


def test_an_opening_contact_limits_the_order_of_a_fixed_step() -> None:
    problem, reference = case("chain, Hertz", 1)
    errors = problem.errors(Symplectic(order=6), reference)
    assert problem.follows(Symplectic(order=6), errors)
    assert problem.order(Symplectic(order=6), errors) < 4
    assert not tolerances.Problem("smooth", problem.simulation).follows(Symplectic(order=6), errors)


@pytest.mark.parametrize("family", FAMILIES)
def test_every_discretisation_keeps_an_integrator_of_sundials(family: str) -> None:
    sundials = [one for one in tolerances.ADAPTIVE if isinstance(one, IDA | CVODE)]
    assert any(tolerances.refusal(one, FAMILIES[family][0]) is None for one in sundials)


def test_the_pseudo_spectral_scheme_follows_the_tolerance_of_cvode() -> None:
    assert followed("Fourier", 0, CVODE(linear_solver="krylov"))


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
def test_every_pair(family: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert tolerances.main(["--only", family]) == 0, capsys.readouterr().out
