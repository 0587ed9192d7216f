import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import InputError
from mol_compactons.assignment import assign, modules_named
from mol_compactons.integrators import IDA, Midpoint
from tests.systems import one_compacton
from tests.trees import Leaf, Other, Tree


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
        ("scheme", "IDA", r"must be Scheme \(.*CompactScheme, ConservativeScheme"),
        ("integrator", "IDA(rtoll=1)", "did you mean 'rtol'"),
        ("equation", "GranularCompacton(2, 3)", "has too many arguments; GranularCompacton takes n"),
        ("grid", "Grid(30, length=60)", "says length twice"),
        ("initial", "[Compacton(speed=1)]", "needs a value for center"),
        ("equation", "print(1)", r"must be Equation \(.*GranularChain, GranularCompacton"),
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


@given(st.floats(-1e100, 1e100), st.integers(-(10**9), 10**9))
def test_numbers_are_read_to_the_last_bit(number: float, count: int) -> None:
    changed = assign(Leaf(0), {"number": repr(number), "count": str(count)})
    assert (changed.number, changed.count) == (number, count)


@given(st.text(max_size=20))
def test_a_field_of_text_takes_any_text_as_it_is(text: str) -> None:
    assert assign(Other(), {"text": text}) == Other(text=text)


def test_what_is_not_named_stays_and_the_original_too() -> None:
    simulation = one_compacton()
    before = simulation.to_json()
    changed = assign(simulation, {"grid.size": "60"})
    assert (simulation.grid.size, changed.grid.size) == (150, 60)
    assert simulation.to_json() == before
    assert assign(changed, {"grid.size": "150"}) == simulation


def test_a_path_into_a_list_that_is_too_short_is_refused() -> None:
    with pytest.raises(InputError, match=r"'initial\.1\.speed' is not a field .*; did you mean 'initial\.0\.speed'"):
        assign(one_compacton(), {"initial.1.speed": "2"})


def test_the_modules_of_classes_in_a_text() -> None:
    assert modules_named("mine.waves:Pulse(speed=1)") == ["mine.waves"]
    assert modules_named("[one:A(x=2), two:B]") == ["one", "two"]
    assert modules_named("Formula('a:b') + 3") == []
