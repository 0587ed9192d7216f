from __future__ import annotations

import re
from dataclasses import fields
from types import SimpleNamespace
from typing import Any, Literal

import numpy as np
import pytest

from mol_compactons import ConservativeScheme, FourierScheme, GranularCompacton, Grid, IntegrationError
from mol_compactons.integrators import CVODE, IDA, flags
from mol_compactons.integrators.flags import CURES
from mol_compactons.integrators.solver import Solver
from mol_compactons.integrators.sundials_integration import SundialsIntegration
from tests.systems import Array, one_compacton


@pytest.mark.parametrize("name", ["IDA", "CVODE"])
def test_every_flag_has_a_sentence(name: Literal["IDA", "CVODE"]) -> None:
    simulation = one_compacton()
    integration = SundialsIntegration(name, IDA(), simulation.discretize(), simulation.initial_state(), 1.0)
    for flag in range(-99, 0):
        sentence = str(integration._failure(flag))
        assert sentence.startswith(f"{name} gave up at t = 0: ")
        assert sentence.endswith(".")
        assert "; " in sentence
    assert set(range(-8, 0)) <= set(flags.CURES[name])


@pytest.mark.parametrize("name", list(CURES))
def test_every_setting_that_a_cure_names_exists(name: str) -> None:
    settings = {field.name for cls in (IDA, CVODE) for field in fields(cls)}
    named = {setting for cure in CURES[name].values() for setting in re.findall(r"integrator\.(\w+)", cure)}
    assert named <= settings
    assert {"rtol", "atol", "max_steps", "linear_solver"} <= named


@pytest.mark.parametrize("name", list(CURES))
def test_every_cure_says_what_happened_and_then_what_to_do(name: str) -> None:
    for flag, cure in CURES[name].items():
        assert flag < 0
        happened, separator, cure_itself = cure.rpartition("; ")
        assert separator, cure
        assert happened[0].islower()
        assert len(cure_itself.split()) >= 3, cure
        assert not cure.endswith(".")


def conservative() -> tuple[Any, Array]:
    simulation = one_compacton()
    return ConservativeScheme().discretize(simulation.equation, simulation.grid), simulation.initial_state()


@pytest.mark.parametrize("integrator", [IDA(max_steps=3), CVODE(max_steps=3)])
def test_too_few_steps_are_the_flag_minus_1(integrator: IDA | CVODE) -> None:
    system, state = conservative()
    with pytest.raises(IntegrationError) as failure:
        integrator.start(system, state, 5.0).advance(5.0)
    cure = CURES[type(integrator).__name__][-1]
    assert str(failure.value) == f"{type(integrator).__name__} gave up at t = {failure.value.t:.6g}: {cure}."
    assert 0 < failure.value.t < 5


class Refusing:
    """Stands for SUNDIALS: it returns a flag, or, as scikit-sundae does for one that it does not know, raises it."""

    def __init__(self, flag: int, listed: bool) -> None:
        self._flag, self._listed = flag, listed

    def step(self, t: float, method: str) -> SimpleNamespace:
        if not self._listed:
            raise KeyError(self._flag)
        return SimpleNamespace(status=self._flag, njev=7, t=0.0)


@pytest.mark.parametrize("listed", [True, False])
@pytest.mark.parametrize(("name", "flag"), [(name, flag) for name, cures in CURES.items() for flag in cures])
def test_a_flag_that_comes_back_is_an_error_with_its_cure(name: Any, flag: int, listed: bool) -> None:
    system, state = conservative()
    integration = SundialsIntegration(name, IDA(), system, state, 1.0)
    integration._solver = Solver(lambda: Refusing(flag, listed), fragile=False)
    with pytest.raises(IntegrationError) as failure:
        integration.advance(1.0)
    assert str(failure.value) == f"{name} gave up at t = 0: {CURES[name][flag]}."
    assert failure.value.t == 0
    assert integration.counters.jacobians == (7 if listed else 0)


def test_a_krylov_run_ends_with_a_sentence_too() -> None:
    grid = Grid(30, 50)
    system, state = FourierScheme().discretize(GranularCompacton(2), grid), 1 + 0.3 * np.cos(2 * np.pi * grid.x / 30)[None]
    with pytest.raises(IntegrationError, match=r"CVODE gave up at t = .*; raise integrator\.max_steps"):
        CVODE(linear_solver="krylov", max_steps=2).start(system, state, 50.0).advance(50.0)
    assert CVODE(linear_solver="krylov").start(system, state, 1.0).advance(1.0).sum() == pytest.approx(50, rel=1e-4)
