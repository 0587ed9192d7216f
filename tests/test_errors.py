import pickle

import pytest
import xarray as xr

from mol_compactons import InputError, IntegrationError
from mol_compactons.errors import require


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


def test_bad_input_comes_back_from_another_process_as_it_is() -> None:
    again = pickle.loads(pickle.dumps(InputError("one sentence.")))
    assert (type(again), str(again)) == (InputError, "one sentence.")
