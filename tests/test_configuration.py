import dataclasses
from collections.abc import Sequence
from typing import Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import InputError, Simulation
from mol_compactons.assignment import assign
from mol_compactons.configuration import check, decode, encode
from mol_compactons.integrators import IDA, Midpoint
from tests.systems import one_compacton


@dataclasses.dataclass(frozen=True)
class Leaf:
    number: float
    count: int = 1
    mode: Literal["fast", "slow"] = "fast"

    def __post_init__(self) -> None:
        check(self)


@dataclasses.dataclass(frozen=True)
class Other:
    flag: bool = False
    text: str = ""

    def __post_init__(self) -> None:
        check(self)


@dataclasses.dataclass(frozen=True)
class Tree:
    leaves: Sequence[Leaf | Other]
    best: Leaf | Other | None = None
    numbers: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        check(self)


leaves = st.builds(
    Leaf,
    number=st.floats(allow_nan=False, allow_infinity=False),
    count=st.integers(-(10**9), 10**9),
    mode=st.sampled_from(["fast", "slow"]),
) | st.builds(Other, flag=st.booleans(), text=st.text(max_size=5))
trees = st.builds(
    Tree,
    leaves=st.lists(leaves, max_size=3),
    best=st.none() | leaves,
    numbers=st.lists(st.floats(allow_nan=False, allow_infinity=False), max_size=3),
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


def test_changes_are_made_in_order_and_each_sees_the_one_before() -> None:
    changed = assign(Tree(leaves=[], best=Other()), {"best": "Leaf(number=1)", "best.mode": "slow", "leaves": "[Other]"})
    assert changed == Tree(leaves=[Other()], best=Leaf(1, mode="slow"))
    assert assign(changed, {"leaves.0.text": "2015"}).leaves[0] == Other(text="2015")


def test_assign_understands_numbers_words_lists_and_classes() -> None:
    tree = Tree(leaves=[Leaf(1), Other()], best=Leaf(2))
    changed = assign(
        tree,
        {
            "leaves.0.number": "1/4",
            "leaves.1.text": "two words",
            "best": "Leaf(number=-2e-3, mode='slow')",
            "numbers": "[1, 2*3]",
        },
    )
    assert changed == Tree(leaves=[Leaf(0.25), Other(text="two words")], best=Leaf(-2e-3, mode="slow"), numbers=(1.0, 6.0))
    assert assign(tree, {"best": "none"}).best is None
    assert assign(tree, {"best": "Other"}).best == Other()


def test_changes_are_checked_together() -> None:
    """With n = 3/2 the compacton is too wide for the box unless the box grows in the same command."""
    simulation = one_compacton(length=10)
    with pytest.raises(InputError, match="does not fit in the box"):
        assign(simulation, {"equation.n": "1.5"})
    assert assign(simulation, {"equation.n": "1.5", "grid.length": "40"}).grid.length == 40


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("grid.sise", "3", "did you mean 'grid.size'"),
        ("grid.size", "abc", "must be a whole number"),
        ("grid.size", "1/0", "is not a finite number"),
        ("scheme.viscosity", "-1", "must not be negative"),
        ("scheme", "IDA", r"must be Scheme \(CompactScheme, ConservativeScheme"),
        ("integrator", "IDA(rtoll=1)", "did you mean 'rtol'"),
        ("equation", "GranularCompacton(2, 3)", "has too many arguments; GranularCompacton takes n"),
        ("grid", "Grid(30, length=60)", "says length twice"),
        ("initial", "[Compacton(speed=1)]", "needs a value for center"),
        ("equation", "print(1)", r"must be Equation \(GranularChain, GranularCompacton"),
    ],
)
def test_assign_refuses_in_one_sentence(path: str, value: str, words: str) -> None:
    with pytest.raises(InputError, match=words) as refusal:
        assign(one_compacton(), {path: value})
    assert "\n" not in str(refusal.value)


def test_assign_replaces_the_integrator_and_its_fields() -> None:
    simulation = assign(one_compacton(), {"integrator": "Midpoint(step=0.02)"})
    assert simulation.integrator == Midpoint(step=0.02)
    assert assign(one_compacton(), {"integrator": "Midpoint(0.02, order=4)"}).integrator == Midpoint(step=0.02, order=4)
    assert assign(one_compacton(), {"integrator.rtol": "1e-8"}).integrator == IDA(rtol=1e-8)


def test_decode_names_an_unknown_class() -> None:
    data = encode(one_compacton())
    data["grid"]["type"] = "Banana"
    with pytest.raises(InputError, match="Banana is not allowed here; it must be Grid or Lattice"):
        decode(Simulation, data)
