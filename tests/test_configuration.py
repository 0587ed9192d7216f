from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import FrozenInstanceError, dataclass, field, is_dataclass, replace
from fractions import Fraction
from inspect import isabstract
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    ChainCompacton,
    Compacton,
    CustomEquation,
    Formula,
    GranularChain,
    GranularCompacton,
    Grid,
    Impact,
    InputError,
    Lattice,
    Nesterenko,
    PeriodicWave,
    PowerContact,
    PowerLaw,
    PowerLawEquation,
    Ripple,
    RosenauHyman,
    Samples,
    ScalingMap,
    Simulation,
    SolitaryWave,
    Uniform,
    WallClock,
    Wave,
)
from mol_compactons.analysis.orbits import Period
from mol_compactons.configuration import FrozenMapping, Settings, decode, describe, did_you_mean, encode, hints_of
from mol_compactons.equations.flux import Flux
from tests.systems import one_compacton
from tests.trees import Leaf, Other, Tree

leaves = st.builds(
    Leaf,
    number=st.floats(-1e100, 1e100),
    count=st.integers(-(10**9), 10**9),
    mode=st.sampled_from(["fast", "slow"]),
) | st.builds(Other, flag=st.booleans(), text=st.text(max_size=5))
trees = st.builds(
    Tree,
    leaves=st.lists(leaves, max_size=3),
    best=st.none() | leaves,
    numbers=st.lists(st.floats(-1e100, 1e100), max_size=3),
)


@given(trees)
def test_encode_and_decode_are_inverse(tree: Tree) -> None:
    assert decode(Tree, encode(tree)) == tree


def test_numbers_are_coerced_where_nothing_is_lost() -> None:
    leaf = Leaf(number=2, count=3.0)  # type: ignore[arg-type]
    assert (leaf.number, leaf.count) == (2.0, 3)
    assert isinstance(leaf.number, float)
    assert isinstance(leaf.count, int)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"number": "x"}, "Leaf.number = 'x' must be a number"),
        ({"number": True}, "must be a number"),
        ({"number": float("inf")}, "must be finite"),
        ({"number": 1, "count": 1.5}, "must be a whole number"),
        ({"number": 1, "mode": "medium"}, "one of 'fast', 'slow'"),
    ],
)
def test_a_wrong_value_is_named_with_what_is_allowed(fields: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Leaf(**fields)


def test_decode_names_an_unknown_class() -> None:
    data = encode(one_compacton())
    data["grid"]["type"] = "Banana"
    with pytest.raises(InputError, match="Banana is not allowed here; it must be Grid or Lattice"):
        decode(Simulation, data)


def test_arrays_without_dimensions_and_fractions_are_numbers() -> None:
    leaf = Leaf(number=Fraction(1, 4), count=np.array(3.0))  # type: ignore[arg-type]
    assert leaf == Leaf(0.25, 3)
    assert Tree(leaves=[], numbers=np.linspace(0, 1, 3)).numbers == (0.0, 0.5, 1.0)  # type: ignore[arg-type]


def test_a_list_with_one_bad_number_is_refused_whole() -> None:
    with pytest.raises(InputError, match=r"Tree\.numbers = a list with NaN or infinity in it must be finite"):
        Tree(leaves=[], numbers=(1.0, np.nan))
    with pytest.raises(InputError, match=r"Tree\.numbers = .* must be a list of a number"):
        Tree(leaves=[], numbers=(1.0, "two"))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Named(Settings):
    weights: Mapping[str, float] = field(default_factory=dict)


def test_a_mapping_is_frozen_and_survives_json() -> None:
    given_to_it = {"a": 1, "b": 2}
    named = Named(given_to_it)
    given_to_it["a"] = 7
    assert dict(named.weights) == {"a": 1.0, "b": 2.0}
    assert decode(Named, encode(named)) == named
    assert hash(named) == hash(Named({"b": 2, "a": 1}))
    with pytest.raises(TypeError):
        named.weights["a"] = 2.0  # type: ignore[index]
    assert len(FrozenMapping({"a": 1})) == 1
    with pytest.raises(InputError, match=r"Named\.weights = .* must be names, each with a number"):
        Named({"a": "much"})  # type: ignore[dict-item]


def test_what_is_frozen_stays() -> None:
    leaf = Leaf(1)
    with pytest.raises(FrozenInstanceError):
        leaf.number = 2.0  # type: ignore[misc]
    assert leaf.number == 1.0


def test_a_part_that_is_no_dataclass_cannot_be_stored() -> None:
    class Bare(Wave):
        def values(self, equation: Any, grid: Any, t: float = 0.0) -> Any:
            return np.zeros((1, grid.size))

    with pytest.raises(
        InputError, match=r"Bare is no frozen dataclass and cannot be stored; write @dataclass\(frozen=True\) above it"
    ):
        replace(one_compacton(), initial=[Bare()])
    assert replace(one_compacton(), initial=[Uniform(0.0)]).initial == (Uniform(0.0),)


@pytest.mark.parametrize(
    ("hint", "words"),
    [
        (int, "a whole number below 2^63"),
        (float | None, "a number or None"),
        (tuple[float, ...], "a list of a number"),
        (Mapping[str, int], "names, each with a whole number below 2^63"),
        (Leaf, "Leaf"),
    ],
)
def test_what_is_allowed_is_said_in_words(hint: Any, words: str) -> None:
    assert describe(hint) == words


def test_the_nearest_name_is_suggested_and_else_all() -> None:
    assert did_you_mean("sise", ["size", "length"]) == "did you mean 'size'?"
    assert did_you_mean("zzz", ["size", "length"]) == "it may be size, length."


def test_hints_are_those_of_the_fields_alone() -> None:
    assert list(hints_of(Leaf)) == ["number", "count", "mode"]
    assert hints_of(Leaf)["number"] is float


EXAMPLES: list[Settings] = [
    WallClock(60),
    Period(1.0),
    Grid(30, 100),
    Lattice(40),
    PowerLaw(1, 2),
    Flux((PowerLaw(1, 2),), PowerLaw(1, 0), PowerLaw(1, 1)),
    GranularCompacton(3),
    Nesterenko(3),
    RosenauHyman(2, 2),
    PowerLawEquation(PowerLaw(1, 2), PowerLaw(1, 0), PowerLaw(1, 1)),
    ScalingMap(1.5),
    CustomEquation("u**2"),
    GranularChain(PowerContact(1.5)),
    PowerContact(1.5),
    Uniform(1),
    Ripple(1, 2),
    Compacton(1, 2),
    ChainCompacton(1, 2),
    SolitaryWave(1, 2),
    Impact(1),
    Samples((1, 2, 3)),
    Formula("x"),
    PeriodicWave(1, 1.2),
    one_compacton(),
]
"""Of the classes that have no default for all of their fields."""


def kinds(base: type[Any] = Settings) -> Iterator[type[Any]]:
    """Every class of the package that holds settings and can be made."""
    for cls in base.__subclasses__():
        if (
            cls.__module__.startswith("mol_compactons.")
            and is_dataclass(cls)
            and not isabstract(cls)
            and cls.__name__[0] != "_"
        ):
            yield cls
        yield from kinds(cls)


@pytest.mark.parametrize("cls", dict.fromkeys(kinds()))
def test_every_field_of_every_class_refuses_what_it_cannot_hold(cls: Any) -> None:
    """What is of no type that it knows, and a number that is none."""
    part: Any = next((example for example in EXAMPLES if type(example) is cls), None) or cls()
    for name, hint in hints_of(cls).items():
        with pytest.raises(InputError, match=rf"^{cls.__name__}\.{name} = .* must be "):
            replace(part, **{name: object()})
        if hint is float:
            with pytest.raises(InputError, match=rf"^{cls.__name__}\.{name} = nan must be finite"):
                replace(part, **{name: float("nan")})
            assert isinstance(getattr(part, name), float)
