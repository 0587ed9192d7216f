from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import InputError
from mol_compactons.studies.criterion import Criterion

COMPLETE = {"status": "complete", "quantities": {"drift": 0.5, "height": [1.0, 2.0], "lost": math.nan}}


@given(st.sampled_from(["drift", "height_after"]), st.integers(0, 3), st.sampled_from("<>"), st.floats(-1e3, 1e3))
def test_a_criterion_is_read_from_what_it_tells(quantity: str, wave: int, comparison: str, threshold: float) -> None:
    criterion = Criterion(quantity, wave, comparison, threshold)
    again = Criterion.from_text(criterion.told)
    assert (again.quantity, again.wave, again.comparison) == (quantity, wave, comparison)
    assert again.threshold == threshold


@pytest.mark.parametrize(
    ("text", "outcome"),
    [
        ("status", "complete"),
        ("drift > 0.4", "yes"),
        ("drift<0.4", "no"),
        ("height[1] > 1.5", "yes"),
        ("height > 1.5", "no"),
        ("height[5] > 1.5", "unknown"),
        ("lost > 0", "unknown"),
        ("nothing > 0", "unknown"),
    ],
)
def test_a_member_comes_out_as_its_quantity_says(text: str, outcome: str) -> None:
    assert Criterion.from_text(text).of(COMPLETE) == outcome


def test_what_did_not_run_to_its_end_comes_out_as_that() -> None:
    for criterion in (Criterion(), Criterion.from_text("drift > 0")):
        assert criterion.of({"status": "failed", "quantities": {}}) == "failed"
        assert criterion.of({"status": "stopped at t = 1: as asked", "quantities": {}}) == "stopped"


@pytest.mark.parametrize(
    "text", ["", "drift", "drift > ", "drift > a", "drift > 1 < 2", "drift = 1", "2 > drift", "drift > 1e"]
)
def test_what_is_no_criterion_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"is not understood; write status, or as momentum_drift > 0\.01"):
        Criterion.from_text(text)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        (("drift", 0, ">=", 1.0), "comparison = '>=' must be < or >"),
        (("drift", -1, ">", 1.0), "wave = -1 must not be negative"),
        (("drift",), "drift is compared with None; give a number"),
        (("drift", 0, ">", math.nan), "drift is compared with nan"),
    ],
)
def test_a_criterion_that_compares_nothing_is_refused(fields: tuple[Any, ...], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Criterion(*fields)
