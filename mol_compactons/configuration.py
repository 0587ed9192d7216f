"""Frozen dataclasses as configuration: type checks and the JSON round trip.

Everything here is driven by the type hints of the dataclasses themselves: a class in a hint stands for every concrete subclass
of it that is loaded, see `mol_compactons.open_set`, so that no registry of names is needed.
"""

from __future__ import annotations

import dataclasses
import difflib
import functools
import math
import numbers
import types
import typing
from abc import ABC
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, cast

import numpy as np

from mol_compactons.errors import LONGEST_SHOWN, InputError, shown
from mol_compactons.notebook import html_of_settings, short_repr
from mol_compactons.open_set import find, loaded, name_of

LARGEST_NUMBER = 1e100
"""The largest size of a number in a setting: its square and its cube are still numbers."""


class Settings(ABC):  # noqa: B024 (each kind of part has abstract methods of its own)
    """Base of all that a simulation is made of: a frozen dataclass whose fields are checked against their hints.

    A subclass with a check of its own calls ``super().__post_init__()`` first.
    """

    def __init_subclass__(cls, **options: Any) -> None:
        """Its repr is short; that of a dataclass would list every number."""
        super().__init_subclass__(**options)
        if "__repr__" not in vars(cls):
            cls.__repr__ = short_repr  # type: ignore[method-assign]

    def __post_init__(self) -> None:
        check(self)

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        return html_of_settings(self)

    @classmethod
    def from_earlier(cls, fields: dict[str, Any]) -> dict[str, Any]:
        """Decoded JSON of this class, perhaps in the form of an earlier version, in that of today."""
        return fields


class FrozenMapping(Mapping[str, Any]):
    """A mapping that cannot change, and can therefore be hashed; what a field of the type ``Mapping`` holds."""

    def __init__(self, items: Mapping[str, Any]) -> None:
        self._items = dict(items)

    def __getitem__(self, key: str) -> Any:
        return self._items[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __hash__(self) -> int:
        return hash(frozenset(self._items.items()))

    def __repr__(self) -> str:
        return repr(self._items)


@functools.cache
def hints_of(cls: Any) -> dict[str, Any]:
    """The type hint of each field, evaluated once: a study makes thousands of these objects."""
    hints = typing.get_type_hints(cls)
    return {field.name: hints[field.name] for field in dataclasses.fields(cls)}


def alternatives(hint: Any) -> tuple[Any, ...]:
    """The members of a union, or the hint itself."""
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        return tuple(typing.get_args(hint))
    return (hint,)


def item_hint(hint: Any) -> Any:
    """The hint of the items if `hint` is ``tuple[X, ...]`` or ``Sequence[X]``, else None."""
    return typing.get_args(hint)[0] if typing.get_origin(hint) in (tuple, Sequence) else None


def value_hint(hint: Any) -> Any:
    """The hint of the values if `hint` is ``Mapping[str, X]``, else None."""
    return typing.get_args(hint)[1] if typing.get_origin(hint) is Mapping else None


def describe(hint: Any) -> str:
    """What a hint allows, in words."""
    if hint is type(None):
        return "None"
    if typing.get_origin(hint) is Literal:
        return "one of " + ", ".join(repr(choice) for choice in typing.get_args(hint))
    if item_hint(hint) is not None:
        return "a list of " + describe(item_hint(hint))
    if value_hint(hint) is not None:
        return f"names, each with {describe(value_hint(hint))}"
    names = {float: "a number", int: "a whole number below 2^63", bool: "true or false", str: "a text"}
    if hint in names:
        return names[hint]
    allowed = alternatives(hint)
    if len(allowed) > 1:
        return " or ".join(describe(one) for one in allowed)
    classes = [name for name, cls in loaded(hint).items() if cls is not hint]
    return f"{hint.__name__} ({', '.join(sorted(classes))})" if classes else str(hint.__name__)


def _number(value: Any) -> Any:
    """An array without dimensions, of numpy, xarray and others, as the number in it."""
    return value.item() if getattr(value, "ndim", None) == 0 and hasattr(value, "item") else value


def _fit(hint: Any, value: Any) -> Any:
    """`value` as the type of one alternative; raises TypeError where it does not fit."""
    origin = typing.get_origin(hint)
    if origin is Literal:
        if value in typing.get_args(hint):
            return value
    elif item_hint(hint) is not None:
        if isinstance(value, list | tuple) or getattr(value, "ndim", 0) > 0:
            return tuple(_coerce(item_hint(hint), item) for item in (np.asarray(value) if hasattr(value, "ndim") else value))
    elif value_hint(hint) is not None:
        if isinstance(value, Mapping) and all(isinstance(key, str) for key in value):
            return FrozenMapping({key: _coerce(value_hint(hint), item) for key, item in value.items()})
    elif hint is float:
        number: Any = _number(value)
        if isinstance(number, numbers.Real) and not isinstance(number, bool):
            try:
                return float(number)
            except OverflowError:
                return math.inf
    elif hint is int:
        number = _number(value)
        if isinstance(number, numbers.Real) and not isinstance(number, bool) and abs(cast(Any, number)) < 2**63:
            whole = math.floor(cast(Any, number))
            if whole == number:
                return whole
    elif hint is bool:
        if isinstance(value, bool | np.bool_):
            return bool(value)
    elif isinstance(value, hint):
        return value
    raise TypeError


@functools.cache
def _is_storable(hint: Any) -> bool:
    """Whether what a hint allows can be written as JSON and read again."""
    if hint in (float, int, bool, str, type(None)) or typing.get_origin(hint) is Literal:
        return True
    inner = item_hint(hint) or value_hint(hint)
    if inner is not None:
        return _is_storable(inner)
    members = alternatives(hint)
    if len(members) > 1:
        return all(_is_storable(member) for member in members)
    return isinstance(hint, type) and (dataclasses.is_dataclass(hint) or issubclass(hint, Settings))


def _is_frozen(instance: Any) -> bool:
    parameters = vars(type(instance)).get("__dataclass_params__")
    return bool(parameters is not None and parameters.frozen)


@functools.cache
def _checked_fields(cls: Any) -> dict[str, tuple[Any, frozenset[type]]]:
    """The hint of each field, and the types of values that stand as they are where they are in range."""
    return {field: (hint, _plain_types(hint)) for field, hint in hints_of(cls).items()}


def _plain_types(hint: Any) -> frozenset[type]:
    """Of a hint all of whose alternatives are plain: those, less a number that another kind of number takes first."""
    allowed = alternatives(hint)
    if not set(allowed) <= {float, int, bool, str, type(None)}:
        return frozenset()
    first = next((one for one in allowed if one in (float, int)), None)
    return frozenset(one for one in allowed if one not in (float, int) or one is first)


def _is_part(hint: Any, value: Any) -> bool:
    """Whether a value is one of the parts that a hint of a single class allows."""
    return isinstance(value, Settings) and isinstance(hint, type) and isinstance(value, hint) and _is_frozen(value)


def _is_in_range(value: Any) -> bool:
    """Whether a plain value needs no closer look."""
    if isinstance(value, float):
        return abs(value) <= LARGEST_NUMBER
    return not isinstance(value, int) or abs(value) < 2**63


def _coerce(hint: Any, value: Any) -> Any:
    for alternative in alternatives(hint):
        try:
            return _fit(alternative, value)
        except TypeError:
            continue
    raise TypeError


def check(instance: Any) -> None:
    """Check every field of a frozen dataclass against its type hint; called first in ``__post_init__``.

    Lists become tuples, whole numbers become floats where the hint says float, arrays without dimensions and fractions are
    numbers, and every number must be finite.

    Raises
    ------
    InputError
        One sentence that names the field, the value and what is allowed.
    """
    name = type(instance).__name__
    # Of `type(instance)` the type checker does not believe that it can be hashed.
    for field, (hint, plain) in _checked_fields(instance.__class__).items():
        value = getattr(instance, field)
        if (type(value) in plain and _is_in_range(value)) or _is_part(hint, value):
            continue
        if not _is_storable(hint):
            raise InputError(
                f"{name}.{field} has the type {hint}, which cannot be stored; use numbers, words, parts, tuple[float, ...] or "
                "Mapping[str, float]."
            )
        try:
            fitted = _coerce(hint, value)
        except TypeError:
            raise InputError(f"{name}.{field} = {shown(value)} must be {describe(hint)}.") from None
        several = isinstance(fitted, tuple | FrozenMapping)
        members = tuple(fitted.values() if isinstance(fitted, FrozenMapping) else fitted if several else (fitted,))
        for member in members:
            if isinstance(member, Settings) and not _is_frozen(member):
                raise InputError(
                    f"{type(member).__name__} is no frozen dataclass and cannot be stored; write @dataclass(frozen=True) "
                    "above it."
                )
        _check_numbers(f"{name}.{field}", members, several)
        object.__setattr__(instance, field, fitted)


def _check_numbers(field: str, members: tuple[Any, ...], several: bool) -> None:
    numbers_in_it = [member for member in members if isinstance(member, float)]
    if not all(math.isfinite(number) for number in numbers_in_it):
        told = "a list with NaN or infinity in it" if several else members[0]
        raise InputError(f"{field} = {told} must be finite; replace the NaN or infinity by a number.")
    largest = max(map(abs, numbers_in_it), default=0.0)
    if largest > LARGEST_NUMBER:
        told = f"a list with the size {largest:g} in it" if several else f"{members[0]:g}"
        raise InputError(f"{field} = {told} must lie between -{LARGEST_NUMBER:g} and {LARGEST_NUMBER:g}; choose other units.")


def encode(value: Any) -> Any:
    """A dataclass as JSON-ready data; each dataclass carries its class name under "type"."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {field: encode(getattr(value, field)) for field in hints_of(type(value))}
        return {"type": name_of(type(value)), **fields}
    if isinstance(value, FrozenMapping):
        return {key: encode(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return [encode(item) for item in value]
    return value


def decode(hint: Any, data: Any) -> Any:
    """The inverse of `encode`; `hint` says which dataclasses may stand there.

    Raises
    ------
    InputError
        If the data names a class that is not loaded or not allowed, or an unknown field.
    """
    if isinstance(data, dict):
        mapping = [value_hint(one) for one in alternatives(hint) if value_hint(one) is not None]
        if mapping and "type" not in data:
            return {key: decode(mapping[0], item) for key, item in data.items()}
        fields = dict(data)
        name = str(fields.pop("type", None))
        cls: Any = find(alternatives(hint), name, functools.partial(describe, hint))
        fields = cls.from_earlier(fields) if issubclass(cls, Settings) else fields
        hints = hints_of(cls)
        for field in fields:
            if field not in hints:
                raise InputError(f"{name} has no field {shown(field)}; {did_you_mean(field, list(hints))}")
        return _construct(cls, {field: decode(hints[field], item) for field, item in fields.items()})
    if isinstance(data, list):
        for alternative in alternatives(hint):
            if item_hint(alternative) is not None:
                return tuple(decode(item_hint(alternative), item) for item in data)
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
    close = difflib.get_close_matches(word[:LONGEST_SHOWN], choices, n=1, cutoff=0.4)
    return f"did you mean {close[0]!r}?" if close else f"it may be {', '.join(choices)}."
