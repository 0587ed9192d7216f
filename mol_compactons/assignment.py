"""Changing the fields of a frozen dataclass by their dotted paths and texts, as on the command line."""

from __future__ import annotations

import ast
import operator
import re
import typing
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, TypeVar

from mol_compactons.configuration import alternatives, decode, describe, did_you_mean, encode, hints_of, item_hint, value_hint
from mol_compactons.errors import LONGEST_SHOWN, InputError, require, shown
from mol_compactons.open_set import find, loaded

T = TypeVar("T")

Importer = Callable[[str], None]
"""Imports a module by its name."""


def import_nothing(module: str) -> None:
    """An `Importer` that imports nothing."""


_OUTSIDE_CLASS = re.compile(r"""("[^"]*"|'[^']*')|\b([A-Za-z_][\w.]*):([A-Za-z_]\w*)""")
"""Quoted texts, which stay as they are, and "module:Class"."""

MOST_LEVELS = 60
"""How deep a value may be nested; no part of a simulation needs ten levels."""

LARGEST_WHOLE = 2**1023
"""Whole numbers from here on are no floats."""

_OPERATORS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


def assign(instance: T, changes: Mapping[str, Any], importing: Importer = import_nothing) -> T:
    """A copy of a dataclass in which the fields at some dotted paths have new values, changed in order and checked at the end.

    Parameters
    ----------
    instance : dataclass
        For example a `Simulation`.
    changes : mapping of str
        Path and value, for example ``{"grid.size": "1200", "initial.0.speed": "1/4"}``. A text means a number, a word, a list,
        a mapping, or a class with its arguments: ``IDA(rtol=1e-8)``, ``mine:LogKdV()``. Any other value is taken as it is.
    importing : callable, optional
        Called with the module of each class that a value names as "module:Class", before the class is looked for.

    Raises
    ------
    InputError
        If a path does not exist (the nearest one is suggested) or a value does not fit.
    """
    tree = encode(instance)
    change(type(instance), tree, changes, importing)
    return typing.cast(T, decode(type(instance), tree))


def change(cls: type, tree: Any, changes: Mapping[str, Any], importing: Importer = import_nothing) -> None:
    """Change an encoded dataclass in place, without checking what comes out.

    Parameters
    ----------
    cls : type
        The dataclass.
    tree : dict
        What `encode` made of it.
    changes, importing
        As for `assign`.

    Raises
    ------
    InputError
        If a path does not exist, or a text cannot be read.
    """
    for path, value in changes.items():
        hint_at(cls, tree, path)
        _replace(cls, tree, path.split("."), value, importing)


def modules_named(text: str) -> list[str]:
    """The modules of the classes that a text names as "module:Class"."""
    return [module for _, module, _ in _OUTSIDE_CLASS.findall(text) if module]


def _branches(hint: Any, branch: Any) -> dict[str, Any]:
    """The parts of an encoded tree below a branch, by name, each with its hint."""
    if isinstance(branch, list):
        inner = [item_hint(item) for item in alternatives(hint) if item_hint(item) is not None]
        return {str(index): inner[0] for index in range(len(branch))} if inner else {}
    if not isinstance(branch, dict):
        return {}
    if "type" not in branch:
        values = [value_hint(item) for item in alternatives(hint) if value_hint(item) is not None]
        return dict.fromkeys(branch, values[0]) if values else {}
    return hints_of(find(alternatives(hint), str(branch["type"]), partial(describe, hint)))


def _below(branch: Any, part: str) -> Any:
    """One part of an encoded branch; None where the field has its default."""
    return branch[int(part)] if isinstance(branch, list) else branch.get(part)


def hint_at(cls: type, tree: Any, path: str) -> Any:
    """The type hint of a field of an encoded dataclass, by its path.

    Raises
    ------
    InputError
        If there is no such field; the nearest one is suggested.
    """
    hint, branch = cls, tree
    for part in path.split("."):
        branches = _branches(hint, branch)
        if part not in branches:
            raise InputError(f"{shown(path)} is not a field of {cls.__name__}; {did_you_mean(path, list(_paths(cls, tree)))}")
        hint, branch = branches[part], _below(branch, part)
    return hint


def _paths(hint: Any, branch: Any, prefix: str = "") -> Iterator[str]:
    """Every dotted path in an encoded tree, depth first: ``grid.size``, ``initial.0.speed``, ..."""
    for part, inner in _branches(hint, branch).items():
        yield prefix + part
        yield from _paths(inner, _below(branch, part), f"{prefix}{part}.")


def _replace(hint: Any, branch: Any, parts: list[str], value: Any, importing: Importer) -> None:
    """Put a value, or what a text means, into an encoded tree, in place."""
    part, *rest = parts
    inner = _branches(hint, branch)[part]
    if rest:
        _replace(inner, _below(branch, part), rest, value, importing)
        return
    if isinstance(value, str) and inner is not str:
        for module in modules_named(value):
            importing(module)
    branch[int(part) if isinstance(branch, list) else part] = _parse(inner, value) if isinstance(value, str) else encode(value)


def _parse(hint: Any, text: str) -> Any:
    """What a text means where `hint` is expected, encoded; a text that is no expression stays a text."""
    if hint is str:
        return text
    dotted = _OUTSIDE_CLASS.sub(lambda found: found.group(1) or f"{found.group(2)}.{found.group(3)}", text.strip())
    try:
        with warnings.catch_warnings(action="ignore"):
            tree: ast.expr | None = ast.parse(dotted, mode="eval").body
    except (SyntaxError, ValueError):
        return text
    except (RecursionError, MemoryError):
        tree = None
    require(
        tree is not None and not _is_deeper(tree, MOST_LEVELS),
        f"The value {shown(text)} is nested more than {MOST_LEVELS} levels deep; write it with fewer signs and brackets.",
    )
    return _value(hint, typing.cast(ast.expr, tree), text)


def _is_deeper(tree: ast.AST, levels: int) -> bool:
    """Whether a tree has more than a number of levels of expressions; without recursion, which has a limit too."""
    level: list[ast.AST] = [tree]
    for _ in range(levels):
        level = [child for node in level for child in ast.iter_child_nodes(node)]
        if not level:
            return False
    return True


def _class_named(hint: Any, node: ast.expr) -> tuple[str, type] | None:
    """The class that a node names where `hint` is expected, with its name in JSON."""
    hints = [hint, *(item_hint(item) for item in alternatives(hint))]
    bases: tuple[Any, ...] = tuple(base for item in hints for base in alternatives(item) if isinstance(base, type))
    if isinstance(node, ast.Attribute):
        module, _, cls = ast.unparse(node).rpartition(".")
        return f"{module}:{cls}", find(bases, f"{module}:{cls}", partial(describe, hint))
    if isinstance(node, ast.Name):
        known: dict[str, type] = {name: cls for base in bases for name, cls in loaded(base).items()}
        named = {name: cls for name, cls in known.items() if node.id in (name, cls.__name__)}
        if len(named) > 1 and node.id not in named:
            raise InputError(f"{node.id} may be {' or '.join(named)}; write which.")
        for name, found in named.items():
            if name == node.id or node.id not in named:
                return name, found
    return None


def _value(hint: Any, node: ast.expr, text: str) -> Any:
    match node:
        case ast.Constant(value=value):
            return value
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            value = _value(hint, operand, text)
            return -value if isinstance(value, int | float) and not isinstance(value, bool) else text
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            pair = (_value(hint, left, text), _value(hint, right, text))
            if not all(isinstance(item, int | float) for item in pair):
                return text
            try:
                result = _OPERATORS[type(op)](*pair)
            except (ZeroDivisionError, OverflowError):
                result = LARGEST_WHOLE
            require(abs(result) < LARGEST_WHOLE, f"{shown(text)} is not a finite number; give one.")
            return result
        case ast.List(elts=items) | ast.Tuple(elts=items):
            return [_value(hint, item, ast.unparse(item)) for item in items]
        case ast.Dict(keys=keys, values=values) if all(isinstance(key, ast.Constant) for key in keys):
            inner = next((value_hint(item) for item in alternatives(hint) if value_hint(item) is not None), None)
            pairs = zip(keys, values, strict=True)
            return {str(getattr(key, "value", "")): _value(inner, value, ast.unparse(value)) for key, value in pairs}
        case ast.Call(func=func, args=positional, keywords=keywords) if named := _class_named(hint, func):
            return {"type": named[0]} | _arguments(named[1], positional, keywords, text)
        case ast.Name() | ast.Attribute() if named := _class_named(hint, node):
            return {"type": named[0]}
        case ast.Name(id=name) if name.lower() in ("true", "false", "none"):
            return {"true": True, "false": False, "none": None}[name.lower()]
    return text


def _arguments(cls: type, positional: list[ast.expr], keywords: list[ast.keyword], text: str) -> dict[str, Any]:
    """The fields that the arguments of a class in a text give, encoded."""
    fields = hints_of(cls)
    if len(positional) > len(fields):
        raise InputError(f"{shown(text)} has too many arguments; {cls.__name__} takes {', '.join(fields)}.")
    given = [*zip(fields, positional, strict=False), *((str(keyword.arg), keyword.value) for keyword in keywords)]
    if twice := [field for field, _ in given if [other for other, _ in given].count(field) > 1]:
        raise InputError(f"{shown(text)} says {twice[0][:LONGEST_SHOWN]} twice; say it once.")
    return {field: _value(fields.get(field), item, ast.unparse(item)) for field, item in given}
