from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from mol_compactons import InputError, IntegrationError, Midpoint, run
from mol_compactons.semidiscrete import SemiDiscretization
from tests.systems import Array, one_compacton


def test_second_order_in_the_step() -> None:
    frames = [run(one_compacton(t_end=1, integrator=Midpoint(step=step))).W.values[-1] for step in (0.02, 0.01, 0.005, 0.0025)]
    differences = [np.abs(a - b).max() for a, b in pairwise(frames)]
    assert differences[0] / differences[1] == pytest.approx(4, rel=0.15)
    assert differences[1] / differences[2] == pytest.approx(4, rel=0.05)


@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_runs_for_every_exponent(n: float) -> None:
    simulation = one_compacton(n=n, length=40, size=300, t_end=2, integrator=Midpoint())
    dataset = run(simulation)
    exact = simulation.initial[0].values(simulation.equation, simulation.grid, 2)[0]
    assert np.linalg.norm(dataset.W.values[-1] - exact) < 0.02 * np.linalg.norm(exact)
    assert dataset.attrs["solver_steps"] == 200


def rotation() -> SemiDiscretization:
    """y' = K y with K the skew central difference on a ring: it conserves sum y^2."""
    base = one_compacton(size=20).discretize()

    def rhs(t: float, state: Array, out: Array) -> None:
        out[:] = np.roll(state, -1, axis=1) - np.roll(state, 1, axis=1)

    def jacobian(t: float, state: Array, out: Array) -> None:
        out[:] = 0
        out[0, 0, base.reach + 1], out[0, 0, base.reach - 1] = 1, -1

    return replace(base, rhs=rhs, jacobian=jacobian, mass=None)


def test_a_quadratic_invariant_is_kept_to_round_off() -> None:
    state = np.random.default_rng(5).normal(size=(1, 20))
    integration = Midpoint(step=0.3).start(rotation(), state, 30.0)
    moved = integration.advance(30.0)
    assert float((moved**2).sum()) == pytest.approx(float((state**2).sum()), rel=1e-13)
    assert np.abs(moved - state).max() > 0.1
    assert integration.counters.steps == 100


def test_an_interval_that_is_no_multiple_is_cut_into_equal_steps() -> None:
    integration = Midpoint(step=0.3).start(rotation(), np.ones((1, 20)), 1.0)
    integration.advance(1.0)
    assert integration.counters.steps == 4


def test_a_step_that_does_not_converge_says_so() -> None:
    with pytest.raises(IntegrationError, match=r"choose a smaller integrator\.step") as failure:
        run(one_compacton(n=2, size=300, second_difference="nearest", viscosity=0, t_end=50, integrator=Midpoint(step=10)))
    assert failure.value.dataset is not None


@pytest.mark.parametrize(
    ("step", "tolerance", "words"), [(0, 1e-12, "step = 0"), (-1, 1e-12, "step = -1"), (0.1, 1, "tolerance = 1")]
)
def test_bad_settings_are_named(step: float, tolerance: float, words: str) -> None:
    with pytest.raises(InputError, match=words):
        Midpoint(step=step, tolerance=tolerance)
