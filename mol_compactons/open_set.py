"""The open set of parts: the concrete subclasses of a base class that are loaded now, and the names that JSON gives them.

A class of this package has its bare name, any other is "module:Class". What is not loaded is looked for among the entry points
(group `mol_compactons`) of the installed packages, and nowhere else: no module is imported because a file names it.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable
from typing import Any, TypeVar, cast

from mol_compactons.errors import InputError

Part = TypeVar("Part")

PACKAGE = __name__.partition(".")[0]

ENTRY_POINTS = "mol_compactons"
"""The group of entry points by which an installed package announces its parts."""


def name_of(cls: type) -> str:
    """The name of a class in JSON and in ``--set``."""
    own = cls.__module__.partition(".")[0] == PACKAGE
    return cls.__name__ if own else f"{cls.__module__}:{cls.__qualname__}"


def loaded(base: Callable[..., Part]) -> dict[str, type[Part]]:
    """The concrete dataclasses among a class and its subclasses, by name; of two with one name the younger."""
    found: dict[str, type[Part]] = {}
    if not isinstance(base, type):
        return found
    if dataclasses.is_dataclass(base) and not inspect.isabstract(base):
        found[name_of(base)] = cast("type[Part]", base)
    subclasses: list[type[Any]] = base.__subclasses__()
    for cls in subclasses:
        found |= loaded(cls)
    return found


def find(bases: tuple[Any, ...], name: str, allowed: str) -> type:
    """The class of a name below one of some bases.

    Parameters
    ----------
    bases : tuple of classes
        What may stand there.
    name : str
        "Class" or "module:Class".
    allowed : str
        The same in words.

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
    module, colon, _ = name.partition(":")
    if not colon:
        raise InputError(f"{name} is not allowed here; it must be {allowed}.")
    raise InputError(
        f"{name} is not loaded, or not {allowed}; import {module} first (on the command line: --import {module}). No module "
        "is imported because a file names it."
    )


def _load_announced(name: str) -> bool:
    """Import what an installed package announces under a name, or as a class of the same module."""
    from importlib.metadata import entry_points

    module = name.partition(":")[0]
    found = [
        entry for entry in entry_points(group=ENTRY_POINTS) if name in (entry.name, entry.value) or entry.module == module
    ]
    for entry in found:
        entry.load()
    return bool(found)
