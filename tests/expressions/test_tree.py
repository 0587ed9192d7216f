from mol_compactons.expressions import DERIVATIVES, FUNCTIONS, Node, number, parse
from mol_compactons.expressions.kernels import OPERATIONS


def test_a_tree_knows_its_names_and_its_derivatives() -> None:
    tree = parse("u*v + sin(d2(u) + 3)", "f", ("u", "v", "w"), derivatives=True)
    assert tree.names == {"u", "v"}
    assert tree.has_derivative
    assert not tree.parts[0].has_derivative
    assert [node.kind for node in tree.all_nodes()] == [
        "add",
        "multiply",
        "name",
        "name",
        "sin",
        "add",
        "d2",
        "name",
        "number",
    ]


def test_trees_are_equal_whatever_they_were_written_as() -> None:
    one, other = (parse(text, "f", ("u",)) for text in ("u + 2", "( u )+2.0"))
    assert one == other
    assert hash(one) == hash(other)
    assert one.text != other.text
    assert one != parse("2 + u", "f", ("u",))


def test_a_number_is_a_tree_of_its_own() -> None:
    assert number(2.5) == Node("number", number=2.5)
    assert (number(2.5).text, number(2.5).names) == ("2.5", frozenset())


def test_every_function_can_be_computed() -> None:
    """sqrt is a power of one half."""
    assert set(FUNCTIONS) - {"sqrt"} <= set(OPERATIONS)
    assert DERIVATIVES == {"d1": 1, "d2": 2, "d3": 3}
