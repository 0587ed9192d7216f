"""A solver of scikit-sundae is freed when it is to be, whoever still holds it."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from mol_compactons.integrators.solver import Solver
from mol_compactons.runtime.capture import import_sundae


def test_freeing_completes_its_messages_though_the_frames_of_an_error_hold_it() -> None:
    rng, calls = np.random.default_rng(0), []

    def wall(t: float, y: Any, rate: Any) -> None:
        calls.append(t)
        if len(calls) > 2000:
            raise ValueError("often enough")
        rate[:] = -y if t < 0.5 else 1e100 * rng.random(y.size)

    solver = Solver(lambda: import_sundae().cvode.CVODE(wall, rtol=1e-2, atol=1e-4), fragile=False)
    solver.begin(0.0, np.ones(1))

    def go() -> None:
        while True:
            solver.step(2.0, "onestep")

    with pytest.raises(ValueError, match="often enough") as failure:
        go()
    assert solver.messages() == []
    solver.free()
    assert [line.partition("]")[0] for line in solver.messages()] == ["[WARNING"] * 11
    assert failure.value.__traceback__ is not None


class Fragile:
    """Stands for a solver with SuperLU_MT, which must live until it has taken a step."""

    alive = True

    def __init__(self) -> None:
        self.inner = object()

    def init_step(self, t: float, *start: Any) -> None:
        """Begin."""

    def step(self, t: float, method: str) -> Any:
        return SimpleNamespace(status=int(t))


@pytest.mark.parametrize(("status", "freed"), [(-4, False), (0, True)])
def test_what_crashes_when_freed_too_early_is_kept_until_a_step_was_taken(status: int, freed: bool) -> None:
    made = Fragile()
    solver = Solver(lambda: made, fragile=True)
    solver.begin(0.0)
    solver.step(float(status), "onestep")
    solver.free()
    assert hasattr(made, "inner") != freed
