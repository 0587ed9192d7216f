"""Frozen dataclasses as configuration: type checks, JSON round trip, and changes by dotted path.

Everything here is driven by the type hints of the dataclasses themselves: a union of dataclasses in a hint is the list of
what may stand there, so that no registry of names is needed.
"""

from __future__ import annotations

import ast
import dataclasses
import difflib
import functools
import math
import operator
import types
import typing
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Literal, TypeVar

import numpy as np

from mol_compactons.errors import InputError

T = TypeVar("T")


@functools.cache
def _hints(cls: Any) -> dict[str, Any]:
    """The type hint of each field, evaluated once: a study makes thousands of these objects."""
    hints = typing.get_type_hints(cls)
    return {field.name: hints[field.name] for field in dataclasses.fields(cls)}


def _alternatives(hint: Any) -> tuple[Any, ...]:
    """The members of a union, or the hint itself."""
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        return tuple(typing.get_args(hint))
    return (hint,)


def _dataclasses_of(hint: Any) -> dict[str, type]:
    return {cls.__name__: cls for cls in _alternatives(hint) if isinstance(cls, type) and dataclasses.is_dataclass(cls)}


def _item_hint(hint: Any) -> Any:
    """The hint of the items if `hint` is ``tuple[X, ...]`` or ``Sequence[X]``, else None."""
    return typing.get_args(hint)[0] if typing.get_origin(hint) in (tuple, Sequence) else None


def _describe(hint: Any) -> str:
    if hint is type(None):
        return "None"
    if typing.get_origin(hint) is Literal:
        return "one of " + ", ".join(repr(choice) for choice in typing.get_args(hint))
    if _item_hint(hint) is not None:
        return "a list of " + _describe(_item_hint(hint))
    names = {float: "a number", int: "a whole number below 2^63", bool: "true or false", str: "a text"}
    if hint in names:
        return names[hint]
    alternatives = _alternatives(hint)
    if len(alternatives) == 1:
        return str(hint.__name__)
    return " or ".join(_describe(alternative) for alternative in alternatives)


def _fit(hint: Any, value: Any) -> Any:
    """`value` as the type of one alternative; raises TypeError where it does not fit."""
    origin = typing.get_origin(hint)
    if origin is Literal:
        if value in typing.get_args(hint):
            return value
    elif _item_hint(hint) is not None:
        if isinstance(value, list | tuple | np.ndarray):
            return tuple(_coerce(_item_hint(hint), item) for item in value)
    elif hint is float:
        if isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool | np.bool_):
            try:
                return float(value)
            except OverflowError:
                return math.inf
    elif hint is int:
        if isinstance(value, float | np.floating) and math.isfinite(value) and value == int(value):
            return _fit(int, int(value))
        if isinstance(value, int | np.integer) and not isinstance(value, bool | np.bool_):
            number = int(value)
            if abs(number) < 2**63:
                return number
    elif hint is bool:
        if isinstance(value, bool | np.bool_):
            return bool(value)
    elif isinstance(value, hint):
        return value
    raise TypeError


def _coerce(hint: Any, value: Any) -> Any:
    for alternative in _alternatives(hint):
        try:
            return _fit(alternative, value)
        except TypeError:
            continue
    raise TypeError


def check(instance: Any) -> None:
    """Check every field of a frozen dataclass against its type hint; called first in ``__post_init__``.

    Lists become tuples, whole numbers become floats where the hint says float, and every number must be finite.

    Raises
    ------
    InputError
        One sentence that names the field, the value and what is allowed.
    """
    name = type(instance).__name__
    # Of `type(instance)` the type checker does not believe that it can be hashed.
    for field, hint in _hints(instance.__class__).items():
        value = getattr(instance, field)
        try:
            fitted = _coerce(hint, value)
        except TypeError:
            shown = repr(value) if len(repr(value)) < 80 else repr(value)[:80] + "..."
            raise InputError(f"{name}.{field} = {shown} must be {_describe(hint)}.") from None
        numbers = fitted if isinstance(fitted, tuple) else (fitted,)
        if any(isinstance(number, float) and not math.isfinite(number) for number in numbers):
            shown = value if not isinstance(fitted, tuple) else "a list with NaN or infinity in it"
            raise InputError(f"{name}.{field} = {shown} must be finite; replace the NaN or infinity by a number.")
        object.__setattr__(instance, field, fitted)


def encode(value: Any) -> Any:
    """A dataclass as JSON-ready data; each dataclass carries its class name under "type"."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {field: encode(getattr(value, field)) for field in _hints(type(value))}
        return {"type": type(value).__name__, **fields}
    if isinstance(value, tuple):
        return [encode(item) for item in value]
    return value


def decode(hint: Any, data: Any) -> Any:
    """The inverse of `encode`; `hint` says which dataclasses may stand there.

    Raises
    ------
    InputError
        If the data names an unknown class or field.
    """
    if isinstance(data, dict):
        classes = _dataclasses_of(hint)
        fields = dict(data)
        name = fields.pop("type", None)
        cls = classes.get(str(name))
        if cls is None:
            raise InputError(f"{name} is not allowed here; it must be {_describe(hint)}.")
        hints = _hints(cls)
        for field in fields:
            if field not in hints:
                raise InputError(f"{name} has no field {field!r}; {did_you_mean(field, list(hints))}")
        return _construct(cls, {field: decode(hints[field], item) for field, item in fields.items()})
    if isinstance(data, list):
        for alternative in _alternatives(hint):
            if _item_hint(alternative) is not None:
                return tuple(decode(_item_hint(alternative), item) for item in data)
    return data


def _construct(cls: type, fields: dict[str, Any]) -> Any:
    missing = [
        field.name
        for field in dataclasses.fields(cls)
        if field.name not in fields and field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
    ]
    if missing:
        raise InputError(f"{cls.__name__} needs a value for {', '.join(missing)}.")
    return cls(**fields)


def did_you_mean(word: str, choices: Sequence[str]) -> str:
    """The end of a sentence that suggests the nearest of some choices, or lists them."""
    close = difflib.get_close_matches(word, choices, n=1, cutoff=0.4)
    return f"did you mean {close[0]!r}?" if close else f"it may be {', '.join(choices)}."


def assign(instance: T, changes: dict[str, str]) -> T:
    """A copy of a dataclass in which the fields at some dotted paths have new values, changed in order and checked at the end.

    Parameters
    ----------
    instance : dataclass
        For example a `Simulation`.
    changes : dict of str to str
        Path and value, for example ``{"grid.size": "1200", "initial.0.speed": "1/4"}``. A value is a number, a word, a list,
        or a class with its arguments: ``IDA(rtol=1e-8)``.

    Raises
    ------
    InputError
        If a path does not exist (the nearest one is suggested) or a value does not fit.
    """
    tree = encode(instance)
    for path, text in changes.items():
        known = list(_paths(type(instance), tree))
        if path not in known:
            raise InputError(f"{path!r} is not a field of {type(instance).__name__}; {did_you_mean(path, known)}")
        _replace(type(instance), tree, path.split("."), text)
    return typing.cast(T, decode(type(instance), tree))


def _branches(hint: Any, branch: Any) -> dict[str, Any]:
    """The parts of an encoded tree below a branch, by name, each with its hint."""
    if isinstance(branch, list):
        inner = [_item_hint(item) for item in _alternatives(hint) if _item_hint(item) is not None]
        return {str(index): inner[0] for index in range(len(branch))} if inner else {}
    cls = _dataclasses_of(hint).get(str(branch.get("type"))) if isinstance(branch, dict) else None
    return _hints(cls) if cls else {}


def _below(branch: Any, part: str) -> Any:
    """One part of an encoded branch; None where the field has its default."""
    return branch[int(part)] if isinstance(branch, list) else branch.get(part)


def _paths(hint: Any, branch: Any, prefix: str = "") -> Iterator[str]:
    """Every dotted path in an encoded tree, depth first: ``grid.size``, ``initial.0.speed``, ..."""
    for part, inner in _branches(hint, branch).items():
        yield prefix + part
        yield from _paths(inner, _below(branch, part), f"{prefix}{part}.")


def _replace(hint: Any, branch: Any, parts: list[str], text: str) -> None:
    """Put the value of `text` into an encoded tree, in place."""
    part, *rest = parts
    inner = _branches(hint, branch)[part]
    if rest:
        _replace(inner, _below(branch, part), rest, text)
    else:
        branch[int(part) if isinstance(branch, list) else part] = _parse(inner, text)


_OPERATORS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


def _parse(hint: Any, text: str) -> Any:
    """What a text means where `hint` is expected, encoded; a text that is no expression stays a text."""
    if hint is str:
        return text
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError):
        return text
    return _value(hint, tree, text)


def _value(hint: Any, node: ast.expr, text: str) -> Any:
    hints = [hint, *(_item_hint(item) for item in _alternatives(hint))]
    classes = {name: cls for item in hints for name, cls in _dataclasses_of(item).items()}
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
                return _OPERATORS[type(op)](*pair)
            except (ZeroDivisionError, OverflowError):
                raise InputError(f"{text} is not a finite number; give one.") from None
        case ast.List(elts=items) | ast.Tuple(elts=items):
            return [_value(hint, item, ast.unparse(item)) for item in items]
        case ast.Name(id=name) if name in classes:
            return {"type": name}
        case ast.Name(id=name) if name.lower() in ("true", "false", "none"):
            return {"true": True, "false": False, "none": None}[name.lower()]
        case ast.Call(func=ast.Name(id=name), args=positional, keywords=keywords) if name in classes:
            fields = _hints(classes[name])
            if len(positional) > len(fields):
                raise InputError(f"{text} has too many arguments; {name} takes {', '.join(fields)}.")
            given = [*zip(fields, positional, strict=False), *((str(keyword.arg), keyword.value) for keyword in keywords)]
            if twice := [field for field, _ in given if [other for other, _ in given].count(field) > 1]:
                raise InputError(f"{text} says {twice[0]} twice; say it once.")
            return {"type": name} | {field: _value(fields.get(field), item, ast.unparse(item)) for field, item in given}
    return text
