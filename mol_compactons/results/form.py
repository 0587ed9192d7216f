"""Whether a file has the form of a result, so that whatever reads it finds what it looks for, and how damage is told."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mol_compactons.errors import LONGEST_SHOWN, InputError, require, shown
from mol_compactons.integrators.base import Counters
from mol_compactons.results.reading import conserved_names, field_names, space_of

if TYPE_CHECKING:
    import xarray as xr

PARTS = ("equation", "grid", "scheme", "integrator")
"""The parts of a simulation that are written as a class with its fields."""

WORDS = ("title", "status", "history", "source")
"""The attributes of a result that are texts."""

COARSEST = 1000
"""The most points of the grid for each that a result holds; more would cost memory that the file does not need."""


def settings_of(text: str) -> dict[str, Any]:
    """The simulation that a result carries, as plain data, whose classes need not be loaded.

    Raises
    ------
    InputError
        If it is not the JSON of a simulation.
    """
    try:
        settings = json.loads(text)
    except (ValueError, RecursionError):
        raise InputError(f"The attribute simulation, {shown(text)}, is not JSON that can be read; restore the file.") from None
    whole = (
        isinstance(settings, dict)
        and all(isinstance(settings.get(part), dict) and "type" in settings[part] for part in PARTS)
        and isinstance(settings.get("initial"), list)
        and _is_number(settings.get("t_end"))
        and _is_number(settings["grid"].get("size"))
    )
    require(whole, f"The attribute simulation, {shown(text)}, is not that of a result; restore the file.")
    return dict(settings)


def check_form(dataset: xr.Dataset, path: str | Path) -> None:
    """Refuse a file that lacks what a result of a run has, or holds something else in its place.

    Raises
    ------
    InputError
        One sentence about the first thing that is not as it should be.
    """
    for name in WORDS:
        _insist(path, isinstance(dataset.attrs.get(name, ""), str), f"its attribute {name} is no text")
    _insist(path, _is_number(dataset.attrs.get("format", 1)), "its attribute format is no number")
    space = space_of(dataset)
    for name in ("t", space):
        _insist(path, name in dataset.coords and dataset[name].ndim == 1, f"it has no coordinate {name}")
        values = dataset[name].values
        usable = values.dtype.kind in "fiu" and bool(np.isfinite(values).all())
        _insist(path, usable, f"its coordinate {name} holds what is no finite number")
    _insist(path, len(np.unique(dataset["t"].values)) == dataset.sizes["t"], "two of its frames have the same t")
    fields = field_names(dataset)
    _insist(path, len(fields) > 0, "it holds no field")
    for names, dimensions in ((fields, ["t", space]), (conserved_names(dataset), ["t"])):
        for name in names:
            variable = dataset[name]
            _insist(path, name.isidentifier(), f"{shown(name)} is no name of a variable")
            _insist(path, sorted(map(str, variable.dims)) == sorted(dimensions), f"{name} has not the dimensions {dimensions}")
            _insist(path, variable.dtype.kind in "fiu", f"{name} holds what are no numbers")
            _insist(path, _is_number(variable.attrs.get("magnitude", 0.0)), f"the magnitude of {name} is no number")
    _insist(path, _is_number(dataset[space].attrs.get("period", 1.0)), f"the period of {space} is no number")
    _check_cost(dataset, path)
    settings = settings_of(str(dataset.attrs.get("simulation", "")))
    size, points = settings["grid"]["size"], dataset.sizes[space]
    _insist(path, 0 < size <= COARSEST * points, f"its simulation has {shown(size)} points, and its fields have {points}")
    _check_waves(dataset, path)


def _check_cost(dataset: xr.Dataset, path: str | Path) -> None:
    if "solver_steps" not in dataset.attrs:
        return
    counts = [f"solver_{name}" for name in Counters.__dataclass_fields__ if name != "first_warning"]
    for name in (*counts, "cpu_seconds"):
        _insist(path, _is_number(dataset.attrs.get(name)), f"its attribute {name} is no number")
    _insist(path, isinstance(dataset.attrs.get("solver_first_warning"), str), "its attribute solver_first_warning is no text")


def _check_waves(dataset: xr.Dataset, path: str | Path) -> None:
    if int(dataset.attrs.get("format", 1)) < 2:
        return
    try:
        waves = json.loads(str(dataset.attrs.get("waves")))
    except (ValueError, RecursionError):
        waves = None
    wanted = {"sign", "center", "speed", "height", "width"}
    whole = isinstance(waves, list) and all(
        isinstance(wave, dict) and set(wave) == wanted and all(map(_is_number, wave.values())) for wave in waves
    )
    _insist(path, whole, "its attribute waves does not list the waves")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool) and _is_moderate(value)


def _is_moderate(value: Any) -> bool:
    """Whether a number is finite and within the range of floats."""
    return bool(abs(value) <= np.finfo(float).max)


def _insist(path: str | Path, condition: bool, fault: str) -> None:
    require(condition, f"{path} is damaged or no result of a run: {fault}; restore it, or run it again.")


@contextmanager
def reading(path: str | Path) -> Iterator[None]:
    """Tell in one sentence what is met inside where a part of a file cannot be read.

    Raises
    ------
    InputError
        If the library of the format gives up.
    """
    try:
        yield
    except (OSError, RuntimeError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is damaged: a part of it cannot be read ({error}); restore it, or run it again.") from None


@contextmanager
def understanding(path: str | Path, kind: str) -> Iterator[None]:
    """Tell in one sentence that a study or an orbit lacks inside what one of its kind has.

    Raises
    ------
    InputError
        If a variable, an attribute or a part of one is missing, or is something else.
    """
    try:
        yield
    except InputError:
        raise
    except (LookupError, TypeError, AttributeError, ValueError) as error:
        told = f"{type(error).__name__}: {error}"
        raise InputError(f"{path} is damaged or no {kind} ({told[:LONGEST_SHOWN]}); restore it, or make it again.") from None
