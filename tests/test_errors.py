import copy
import inspect
import multiprocessing
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mol_compactons import GaussLegendre, InputError, IntegrationError, errors, run
from mol_compactons.errors import require
from tests.systems import one_compacton


class OwnError(IntegrationError):
    """One of the user's own, made in another way."""

    def __init__(self, reason: str, *, step: int) -> None:
        super().__init__(f"{reason}.", 0.1 * step)
        self.step = step


def test_bad_input_can_be_caught_as_any_wrong_value() -> None:
    with pytest.raises(ValueError, match="n = 0 must be larger than 1"):
        raise InputError("n = 0 must be larger than 1.")
    assert not issubclass(IntegrationError, ValueError)


def test_require_raises_exactly_where_the_condition_fails() -> None:
    require(1 < 2, "never said")
    with pytest.raises(InputError) as refusal:
        require(2 < 1, "2 must be below 1; choose 0.")
    assert str(refusal.value) == "2 must be below 1; choose 0."


def test_an_integrator_that_gives_up_brings_its_time_and_its_frames() -> None:
    frames = xr.Dataset({"W": ("t", [1.0, 2.0])})
    failure = IntegrationError("It gave up at t = 0.5.", 0.5, frames)
    assert (str(failure), failure.t) == ("It gave up at t = 0.5.", 0.5)
    assert failure.dataset is frames
    assert IntegrationError("Nothing.", 0.0).dataset is None


EVERY_ERROR: list[Exception] = [
    InputError("one sentence."),
    IntegrationError("It gave up at t = 0.5.", 0.5, xr.Dataset({"W": ("t", [1.0, 2.0])})),
    OwnError("It gave up", step=3),
]


def test_no_error_of_the_package_is_left_out_here() -> None:
    kinds = {kind for _, kind in inspect.getmembers(errors, inspect.isclass) if kind.__module__ == errors.__name__}
    assert kinds <= {type(error) for error in EVERY_ERROR}


@pytest.mark.parametrize("way", [copy.copy, copy.deepcopy, *range(2, pickle.HIGHEST_PROTOCOL + 1)])
@pytest.mark.parametrize("error", EVERY_ERROR, ids=lambda error: type(error).__name__)
def test_an_error_comes_back_from_another_process_as_it_is(error: Exception, way: Callable[[Any], Any] | int) -> None:
    error.__notes__ = ["member 3"]
    came = way(error) if callable(way) else pickle.loads(pickle.dumps(error, way))
    assert (type(came), str(came), came.args) == (type(error), str(error), error.args)
    assert came.__dict__.keys() == error.__dict__.keys()
    for name, value in error.__dict__.items():
        assert (
            came.__dict__[name].identical(value) if name == "dataset" and value is not None else came.__dict__[name] == value
        )


def member(step: float, path: Path) -> float:
    """The height of a wave at the end of a run; the run gives up where the step is too long for Newton's method."""
    simulation = one_compacton(size=60, length=10, t_end=10, integrator=GaussLegendre(step=step))
    return float(np.abs(run(simulation, path).W[-1]).max())


def insist_that_a_pool_works_on(submit: Callable[..., Callable[[], float]], folder: Path) -> None:
    """Members that fail among others that do not: each failure arrives whole, and the others have their values."""
    steps = [0.5, 10.0, 0.5, 10.0, 0.5]
    waiting = [submit(member, step, folder / f"{index}.nc") for index, step in enumerate(steps)]
    heights = set()
    for step, wait in zip(steps, waiting, strict=True):
        if step == 0.5:
            heights.add(wait())
            continue
        with pytest.raises(IntegrationError, match="did not converge") as failure:
            wait()
        assert failure.value.t == 0.0
        assert failure.value.dataset is not None
        assert failure.value.dataset.W.shape == (1, 60)
        failure.value.dataset.close()
    assert len(heights) == 1


@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_failing_members_leave_a_process_pool_at_work(method: str, tmp_path: Path) -> None:
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context(method)) as pool:
        insist_that_a_pool_works_on(lambda *call: pool.submit(*call).result, tmp_path)


def test_failing_members_leave_a_pool_of_multiprocessing_at_work(tmp_path: Path) -> None:
    with multiprocessing.get_context("fork").Pool(2) as pool:
        insist_that_a_pool_works_on(lambda function, *call: lambda: pool.apply_async(function, call).get(timeout=30), tmp_path)
