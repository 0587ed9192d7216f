from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import InputError, run
from mol_compactons.results.form import check_form, reading, settings_of, understanding
from tests.systems import one_compacton


@cache
def sound() -> xr.Dataset:
    return run(one_compacton(frames=3)).load()


def forged(**grid: object) -> str:
    settings = json.loads(sound().attrs["simulation"])
    settings["grid"] |= grid
    return json.dumps(settings)


def test_a_sound_result_passes_whatever_its_order() -> None:
    check_form(sound(), "a.nc")
    check_form(sound().transpose(), "a.nc")
    check_form(sound().isel(x=slice(None, None, 3)), "a.nc")
    check_form(sound().isel(t=[0]).assign_attrs(status="running"), "a.nc")


DAMAGE: dict[str, Callable[[xr.Dataset], xr.Dataset]] = {
    "its attribute history is no text": lambda d: d.assign_attrs(history=3),
    "its attribute solver_failures is no number": lambda d: d.assign_attrs(solver_failures="many"),
    "its attribute solver_first_warning is no text": lambda d: d.assign_attrs(solver_first_warning=3),
    "its coordinate x holds what is no finite number": lambda d: d.assign_coords(x=d.x.where(d.x > 1)),
    "its coordinate t holds what is no finite number": lambda d: d.assign_coords(t=["a", "b", "c"]),
    "two of its frames have the same t": lambda d: d.assign_coords(t=[0.0, 1.0, 1.0]),
    "it holds no field": lambda d: d.drop_vars("W"),
    "W has not the dimensions": lambda d: d.assign(W=d.W.expand_dims(y=2).assign_attrs(d.W.attrs)),
    "W holds what are no numbers": lambda d: d.assign(W=d.W.astype(str).assign_attrs(d.W.attrs)),
    "the magnitude of mass is no number": lambda d: d.assign(mass=d.mass.assign_attrs(magnitude="large")),
    "the period of x is no number": lambda d: d.assign_coords(x=d.x.assign_attrs(period="long")),
    "its simulation has 100000000 points, and its fields have 150": lambda d: d.assign_attrs(simulation=forged(size=10**8)),
    "its attribute waves does not list the waves": lambda d: d.assign_attrs(waves='[{"sign": 1}]'),
    "is not JSON that can be read": lambda d: d.assign_attrs(simulation="{"),
    "is not that of a result": lambda d: d.assign_attrs(simulation="[1]"),
}


@pytest.mark.parametrize("words", DAMAGE)
def test_damage_is_one_sentence(words: str) -> None:
    with pytest.raises(InputError, match=words) as refused:
        check_form(DAMAGE[words](sound().copy()), "a.nc")
    assert len(str(refused.value)) < 400


@given(st.sampled_from(sorted(run(one_compacton(frames=3)).attrs)), st.sampled_from([None, 7, "", "x" * 50, np.nan, [1, 2]]))
def test_whatever_stands_in_an_attribute_it_passes_or_is_refused(name: str, value: object) -> None:
    attributes = {other: kept for other, kept in sound().attrs.items() if other != name}
    dataset = sound().drop_attrs(deep=False).assign_attrs(attributes if value is None else attributes | {name: value})
    said = "restore nothing"
    try:
        check_form(dataset, "a.nc")
    except InputError as refused:
        said = str(refused)
    assert "restore" in said or "install a newer one" in said


def test_deep_and_long_json_is_refused() -> None:
    for text in ("[" * 10_000, "1" * 5000, "null", '{"grid": 3}'):
        with pytest.raises(InputError):
            settings_of(text)
    assert settings_of(sound().attrs["simulation"])["grid"]["size"] == 150


def test_what_a_library_says_of_damage_becomes_a_sentence() -> None:
    for error in (OSError("bad block"), RuntimeError("NetCDF: HDF error"), UnicodeDecodeError("utf-8", b"\xff", 0, 1, "bad")):
        with pytest.raises(InputError, match=r"a\.nc is damaged: a part of it cannot be read"), reading("a.nc"):
            raise error
    for other in (KeyError("summary"), ValueError("no"), IndexError("x" * 5000)):
        with pytest.raises(InputError, match=r"a\.nc is damaged or no study") as refused, understanding("a.nc", "study"):
            raise other
        assert len(str(refused.value)) < 400
