"""The open set of parts: the concrete subclasses of a base class that are loaded now, and the names that JSON gives them.

A class of this package is always loaded and has its bare name, any other is "module:Class". What is not loaded is looked for
among the entry points (group `mol_compactons`) of the installed packages, and nowhere else: no module is imported because a
file names it.
"""

from __future__ import annotations

import dataclasses
import inspect
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar, cast

from mol_compactons.errors import LONGEST_SHOWN, InputError

Part = TypeVar("Part")

PACKAGE = __name__.partition(".")[0]

ENTRY_POINTS = "mol_compactons"
"""The group of entry points by which an installed package announces its parts."""

OWN = ("equations", "waves", "schemes", "chain", "integrators", "stop_rules", "analysis")
"""The rooms of this package that hold parts; a part is loaded though nobody has asked for its room yet."""


def name_of(cls: type) -> str:
    """The name of a class in JSON and in ``--set``."""
    own = cls.__module__.partition(".")[0] == PACKAGE
    return cls.__name__ if own else f"{module_of(cls)}:{cls.__qualname__}"


def module_of(cls: type) -> str:
    """The module of a class under the name by which it can be imported again: a script that is run is that of its file."""
    if cls.__module__ != "__main__":
        return cls.__module__
    script = sys.modules["__main__"]
    specification = getattr(script, "__spec__", None)
    if specification is not None:
        return str(specification.name)
    file = getattr(script, "__file__", None)
    return Path(file).stem if file else "__main__"


def loaded(base: Callable[..., Part]) -> dict[str, type[Part]]:
    """The concrete dataclasses among a class and its subclasses, by name; of two with one name that which its module holds."""
    found: dict[str, type[Part]] = {}
    if not isinstance(base, type):
        return found
    load_own()
    if dataclasses.is_dataclass(base) and not inspect.isabstract(base):
        found[name_of(base)] = cast("type[Part]", base)
    subclasses: list[type[Any]] = base.__subclasses__()
    for subclass in subclasses:
        for name, cls in loaded(subclass).items():
            if name not in found or _is_current(cls):
                found[name] = cls
    return found


@cache
def load_own() -> None:
    """Load all parts of this package."""
    for room in OWN:
        import_module(f"{PACKAGE}.{room}")


def _is_current(cls: type) -> bool:
    """Whether a class was not defined anew, as in a notebook: its module holds it, or nothing, under its name."""
    return getattr(sys.modules.get(cls.__module__), cls.__name__, cls) is cls


def find(bases: tuple[Any, ...], name: str, allowed: Callable[[], str]) -> type:
    """The class of a name below one of some bases.

    Parameters
    ----------
    bases : tuple of classes
        What may stand there.
    name : str
        "Class" or "module:Class".
    allowed : callable
        Returns the same in words.

    Raises
    ------
    InputError
        If no such class is loaded or announced by an installed package; the sentence says which import is missing.
    """
    for attempt in range(2):
        for base in bases:
            if cls := loaded(base).get(name):
                return cls
        if attempt or not _load_announced(name):
            break
    name = name if len(name) < LONGEST_SHOWN else f"{name[:LONGEST_SHOWN]}..."
    module, colon, _ = name.partition(":")
    if not colon:
        raise InputError(f"{name} is not allowed here; it must be {allowed()}.")
    if module in sys.modules:
        raise InputError(f"{name} is not allowed here: {module} is loaded, and holds no such class; it must be {allowed()}.")
    raise InputError(
        f"{name} is not loaded, or not {allowed()}; import {module} first (on the command line: --import {module}). No module "
        "is imported because a file names it."
    )


def _load_announced(name: str) -> bool:
    """Import what an installed package announces under a name, or as a class of the same module."""
    from importlib.metadata import entry_points

    module = name.partition(":")[0]
    found = [
        entry
        for entry in entry_points(group=ENTRY_POINTS)
        if name == entry.value or f"{module}.".startswith(f"{entry.module}.")
    ]
    for entry in found:
        try:
            entry.load()
        except Exception as error:
            raise InputError(
                f"An installed package announces {entry.value} for mol_compactons, which cannot be imported "
                f"({type(error).__name__}: {error}); repair or remove it."
            ) from error
    return bool(found)
