"""The modules of the user's own that a simulation needs: which they are, and loading them in another process."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mol_compactons.errors import InputError

Modules = dict[str, str]
"""The file of each module by the name of the module; empty where it has none."""


def modules_of(*trees: Any) -> Modules:
    """The modules of the classes from outside this package that some JSON-ready data name."""
    found = {}
    for tree in trees:
        for name in _types(tree):
            module, colon, _ = name.partition(":")
            if colon:
                file = getattr(sys.modules.get(module), "__file__", None) or getattr(sys.modules["__main__"], "__file__", None)
                found[module] = str(Path(file).resolve()) if file else ""
    return found


def load(modules: Modules) -> None:
    """Load modules in this process, by their names or, where Python does not find them, from their files.

    Raises
    ------
    InputError
        If one cannot be loaded, as where its classes were defined in a notebook.
    """
    for name, file in modules.items():
        if name in sys.modules:
            continue
        try:
            try:
                importlib.import_module(name)
            except ModuleNotFoundError:
                specification = importlib.util.spec_from_file_location(name, file)
                if specification is None or specification.loader is None:
                    raise
                sys.modules[name] = module = importlib.util.module_from_spec(specification)
                specification.loader.exec_module(module)
        except (Exception, SystemExit) as error:
            sys.modules.pop(name, None)
            raise InputError(
                f"The process that runs a member cannot load the module {name} ({type(error).__name__}: {error}); put the "
                "classes into a module that it finds."
            ) from None


def _types(tree: Any) -> Iterator[str]:
    """The names of classes in JSON-ready data."""
    if isinstance(tree, dict):
        if isinstance(tree.get("type"), str):
            yield tree["type"]
        for branch in tree.values():
            yield from _types(branch)
    elif isinstance(tree, list | tuple):
        for branch in tree:
            yield from _types(branch)
