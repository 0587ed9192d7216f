"""What a study varies: a plan makes many simulations of one, along axes of its own."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, cast

import numpy as np

from mol_compactons.assignment import Importer, change, import_nothing
from mol_compactons.configuration import Settings, decode, encode
from mol_compactons.errors import require, shown
from mol_compactons.simulation import Simulation, brief

MOST_MEMBERS = 10**6
"""The largest number of members of a plan."""

TOGETHER = "member"
"""The name of an axis along which several fields change at once."""

NAME_DIGITS = 16
"""How many hexadecimal digits of its digest name a member."""


@dataclass(frozen=True)
class Axis:
    """One direction in which a study varies: fields that change together.

    Parameters
    ----------
    changes : mapping of str to sequence
        For each field, by its path as in ``--set``, its values; all have one length.

    Raises
    ------
    InputError
        If there is no value, or the lengths differ.
    """

    changes: Mapping[str, Sequence[Any]]

    def __post_init__(self) -> None:
        require(bool(self.changes), "An axis of a study changes no field; name one, as grid.size.")
        lengths = {path: len(values) for path, values in self.changes.items()}
        for path, length in lengths.items():
            require(length > 0, f"{shown(path)} has no value to vary over; give some, as {path}=1,2.")
        require(
            len(set(lengths.values())) == 1,
            f"Fields that vary together need as many values each; these have {', '.join(map(str, lengths.values()))}.",
        )

    def __len__(self) -> int:
        return len(next(iter(self.changes.values())))

    def at(self, index: int) -> dict[str, Any]:
        """The changes at one place of the axis."""
        return {path: values[index] for path, values in self.changes.items()}


@dataclass(frozen=True)
class Variant:
    """One member of a plan.

    Parameters
    ----------
    index : tuple of int
        Its place along the axes.
    changes : mapping
        What differs from the simulation of the plan.
    tree : dict
        Its simulation as JSON-ready data, not yet checked.
    """

    index: tuple[int, ...]
    changes: Mapping[str, Any]
    tree: dict[str, Any] = field(repr=False)

    @cached_property
    def name(self) -> str:
        """A digest of its settings: the same for the same simulation, and for no other."""
        return digest(self.tree)

    @property
    def label(self) -> str:
        """One line that tells it from the others."""
        return " ".join(f"{path}={told(value)}" for path, value in self.changes.items())

    def simulation(self) -> Simulation:
        """Its simulation; raises `InputError` where the settings do not fit together."""
        return cast(Simulation, decode(Simulation, self.tree))


@dataclass(frozen=True)
class Plan:
    """Named variations of a simulation: the product of some axes.

    Parameters
    ----------
    simulation : Simulation
        What is varied.
    axes : sequence of Axis
        In each direction one or more fields.
    importing : callable
        Called with the module of each class that a value names as "module:Class".

    Raises
    ------
    InputError
        If a field does not exist or stands on two axes, a value cannot be read, or there are too many members. Settings that
        do not fit together are found when a member runs, and are no reason not to run the others.
    """

    simulation: Simulation
    axes: Sequence[Axis]
    importing: Importer = field(default=import_nothing, repr=False, compare=False)
    _read: dict[tuple[int, int], list[tuple[str, str]]] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require(bool(self.axes), "A study varies nothing; name a field and its values, as grid.size=300,600.")
        paths = [path for axis in self.axes for path in axis.changes]
        for path in paths:
            require(paths.count(path) == 1, f"{shown(path)} is varied twice; vary it once.")
        require(
            self.size <= MOST_MEMBERS,
            f"This study would have {float(self.size):.3g} members, and {MOST_MEMBERS} are allowed; give fewer values.",
        )
        object.__setattr__(self, "_read", self._read_values())

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of members along each axis."""
        return tuple(len(axis) for axis in self.axes)

    @property
    def size(self) -> int:
        """The number of members."""
        return math.prod(self.shape)

    @cached_property
    def dimensions(self) -> tuple[str, ...]:
        """A name for each axis: the last part of the path of its field, or as much of it as no other has."""
        return tuple(
            self.short(next(iter(axis.changes)))
            if len(axis.changes) == 1
            else TOGETHER
            if number == 0
            else f"{TOGETHER}_{number}"
            for number, axis in enumerate(self.axes)
        )

    def short(self, path: str) -> str:
        """A name for a field that no other field of the plan has."""
        lasts = [other.rpartition(".")[2] for axis in self.axes for other in axis.changes]
        last = path.rpartition(".")[2]
        return last if lasts.count(last) == 1 and not last.isdigit() else path.replace(".", "_")

    def __iter__(self) -> Iterator[Variant]:
        """The members, the last axis fastest."""
        for index in itertools.product(*(range(length) for length in self.shape)):
            changes, tree = self._put_together(index) if self._independent else self._tree(index)
            yield Variant(index, changes, tree)

    def _tree(self, index: Sequence[int]) -> tuple[dict[str, Any], dict[str, Any]]:
        """What a member changes, and its simulation as JSON-ready data."""
        changes: dict[str, Any] = {}
        for axis, place in zip(self.axes, index, strict=True):
            changes |= axis.at(place)
        tree = json.loads(self._encoded)
        change(Simulation, tree, changes, self.importing)
        return changes, tree

    def _put_together(self, index: Sequence[int]) -> tuple[dict[str, Any], dict[str, Any]]:
        """The same from what has been read before, for fields that are no parts of each other."""
        changes: dict[str, Any] = {}
        tree = json.loads(self._encoded)
        for number, (axis, place) in enumerate(zip(self.axes, index, strict=True)):
            changes |= axis.at(place)
            for path, text in self._read[number, place]:
                *branches, last = path.split(".")
                branch = tree
                for part in branches:
                    branch = branch[int(part)] if isinstance(branch, list) else branch[part]
                branch[int(last) if isinstance(branch, list) else last] = json.loads(text)
        return changes, tree

    def _read_values(self) -> dict[tuple[int, int], list[tuple[str, str]]]:
        """For each place of an axis its fields and, as JSON, what their values mean."""
        read = {}
        for number, axis in enumerate(self.axes):
            for place in range(len(axis)):
                _, tree = self._tree([place if other == number else 0 for other in range(len(self.axes))])
                read[number, place] = [(path, json.dumps(_at(tree, path))) for path in axis.changes]
        return read

    @cached_property
    def _independent(self) -> bool:
        """Whether no varied field is a part of another."""
        paths = [f"{path}." for axis in self.axes for path in axis.changes]
        return not any(one != other and other.startswith(one) for one in paths for other in paths)

    @cached_property
    def _encoded(self) -> str:
        return self.simulation.to_json()

    def described(self) -> dict[str, Any]:
        """The plan as JSON-ready data, by which a study is known again, and from which its table is made."""
        axes = [
            {
                "dimension": dimension,
                "fields": {
                    path: {
                        "name": self.short(path),
                        "values": [encoded(value) for value in values],
                        "told": [*map(told, values)],
                    }
                    for path, values in axis.changes.items()
                },
            }
            for dimension, axis in zip(self.dimensions, self.axes, strict=True)
        ]
        return {"simulation": json.loads(self._encoded), "axes": axes}


def digest(tree: Any) -> str:
    """The name of JSON-ready data: the same for the same data, and for no other."""
    return hashlib.sha256(json.dumps(tree, sort_keys=True).encode()).hexdigest()[:NAME_DIGITS]


def product(simulation: Simulation, varied: Mapping[str, Sequence[Any]], importing: Importer = import_nothing) -> Plan:
    """All combinations of the values of some fields.

    Parameters
    ----------
    simulation : Simulation
        What is varied.
    varied : mapping of str to sequence
        For each field its values: numbers, texts as in ``--set``, or parts as `Rosenbrock()`.
    importing : callable, optional
        As for `Plan`.
    """
    return Plan(simulation, [Axis({path: tuple(values)}) for path, values in varied.items()], importing)


def together(simulation: Simulation, varied: Mapping[str, Sequence[Any]], importing: Importer = import_nothing) -> Plan:
    """The first values of all fields, the second ones, and so on; parameters as for `product`."""
    return Plan(simulation, [Axis({path: tuple(values) for path, values in varied.items()})], importing)


def listed(simulation: Simulation, members: Sequence[Mapping[str, Any]], importing: Importer = import_nothing) -> Plan:
    """Members one by one, each by its changes; a field that one does not change has the value of the simulation there."""
    require(len(members) > 0, "The list of members is empty; give at least one.")
    own = encode(simulation)
    paths = list(dict.fromkeys(path for member in members for path in member))
    columns = {path: tuple(member[path] if path in member else _at(own, path) for member in members) for path in paths}
    return Plan(simulation, [Axis(columns)], importing)


def drawn(
    simulation: Simulation,
    ranges: Mapping[str, tuple[float, float]],
    count: int,
    seed: int = 0,
    logarithmic: Sequence[str] = (),
) -> Plan:
    """Random values, evenly distributed between two, or their logarithms; the same for the same seed.

    Parameters
    ----------
    simulation : Simulation
        What is varied.
    ranges : mapping of str to (float, float)
        The smallest and the largest value of each field.
    count : int
        How many members.
    seed : int
        Of numpy's default generator.
    logarithmic : sequence of str
        The fields whose logarithms are evenly distributed.
    """
    require(count > 0, f"count = {count} must be at least 1.")
    random = np.random.default_rng(seed)
    columns = {}
    for path, (low, high) in ranges.items():
        require(
            math.isfinite(low) and low < high and math.isfinite(high),
            f"{shown(path)} is drawn between {low:g} and {high:g}; give a smaller and a larger number.",
        )
        require(
            path not in logarithmic or low > 0,
            f"{shown(path)} is drawn by its logarithm from {low:g} on; give positive numbers.",
        )
        even = random.random(count)
        columns[path] = tuple((low * (high / low) ** even if path in logarithmic else low + (high - low) * even).tolist())
    return Plan(simulation, [Axis(columns)])


def _at(tree: Any, path: str) -> Any:
    """What stands at a path in an encoded simulation; None where nothing does."""
    for part in path.split("."):
        if isinstance(tree, list):
            tree = tree[int(part)] if part.isdigit() and int(part) < len(tree) else None
        else:
            tree = tree.get(part) if isinstance(tree, dict) else None
    return tree


def encoded(value: Any) -> Any:
    """A value of a plan as JSON-ready data."""
    return encode(value.item() if isinstance(value, np.generic) else value)


def told(value: Any) -> str:
    """A value of a plan in a few characters."""
    if isinstance(value, float | np.floating):
        return f"{value:.12g}"
    return brief(value) if isinstance(value, Settings) else str(value)
