"""The docstrings of all that is public, as the reference shows them, by numpydoc's own rules."""

from __future__ import annotations

import inspect
from collections.abc import Iterator

import pytest
from numpydoc import validate as validation

import mol_compactons
from mol_compactons import figures

NOT_ASKED = {
    "EX01": "an example of each function would be longer than the function; the tutorial and the gallery are run",
    "ES01": "a summary that says all needs no second one",
    "SA01": "the reference groups what belongs together",
    "SS05": "any verb form is good if the sentence is",
    "SS02": "symbols keep their case: psi, m y' and c are no capitals",
    "PR04": "fields that say what they are share one line",
    "PR08": "the same",
    "PR03": "parameters are told in the order in which they are understood",
    "RT03": "a name or a type may say all",
    "RT04": "the same",
}
"""The rules that are not asked for, and why."""

OF_METHODS = {
    "PR01": "the parameters of a method are those of the base class, which tells them",
    "RT01": "the summary of a short method says what it returns",
    "YD01": "the same",
}
"""The rules that are not asked of methods; of functions only the first is."""


def public() -> Iterator[str]:
    """Every name that can be imported from the package, and the public methods of its classes."""
    for module in (mol_compactons, figures):
        for name in module.__all__:
            thing = getattr(module, name)
            if not callable(thing):
                continue
            yield f"{module.__name__}.{name}"
            if inspect.isclass(thing):
                yield from (f"{module.__name__}.{name}.{method}" for method in methods(thing))


def methods(thing: type) -> list[str]:
    """Not fields whose default is a function."""
    kinds, fields = (property, classmethod, staticmethod), getattr(thing, "__dataclass_fields__", ())
    return [
        name
        for name, own in vars(thing).items()
        if name[0] != "_" and name not in fields and (inspect.isfunction(own) or isinstance(own, kinds))
    ]


def faults(name: str) -> list[str]:
    """What numpydoc has against a docstring, but for what is not asked."""
    thing = validation.Validator._load_obj(name)
    leave = set(NOT_ASKED)
    if not inspect.isclass(thing):
        leave |= set(OF_METHODS) if name.split(".")[-2][0].isupper() else {"RT01", "YD01"}
    return [f"{code}: {text}" for code, text in validation.validate(name)["errors"] if code not in leave]


def test_there_are_many() -> None:
    names = list(public())
    assert len(names) == len(set(names)) > 250
    assert {"mol_compactons.run", "mol_compactons.figures.overview", "mol_compactons.Equation.local_flux"} <= set(names)


def test_every_public_docstring_keeps_the_rules() -> None:
    found = {name: wrong for name in public() if (wrong := faults(name))}
    assert found == {}


def test_a_wrong_docstring_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mol_compactons.track, "__doc__", "no full stop")
    assert any(fault.startswith("SS03") for fault in faults("mol_compactons.track"))
    assert any(fault.startswith("PR01") for fault in faults("mol_compactons.track"))
