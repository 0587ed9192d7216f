"""A formula as a tree of operations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

FUNCTIONS = {
    "abs": 1,
    "sign": 1,
    "heaviside": 1,
    "sqrt": 1,
    "exp": 1,
    "log": 1,
    "sin": 1,
    "cos": 1,
    "tan": 1,
    "sinh": 1,
    "cosh": 1,
    "tanh": 1,
    "sech": 1,
    "max": 2,
    "min": 2,
}
"""The functions that a formula may call, with the number of their arguments; sign(0) = 0 and heaviside(0) = 1/2."""

DERIVATIVES = {"d1": 1, "d2": 2, "d3": 3}
"""The derivatives in space, with their orders."""


@dataclass(frozen=True)
class Node:
    """One operation, with the operations that it is made of.

    Parameters
    ----------
    kind : str
        "number", "name", "add", "subtract", "multiply", "divide", "negative", "power" with a constant exponent, a function
        or a derivative.
    parts : tuple of Node
        What it is applied to.
    number : float
        The number, or the exponent of a power.
    name : str
        The name.
    text : str
        The piece of the formula that it was written as; two nodes are equal whatever they were written as.
    place : int
        The first character of that piece, counted from 1.
    """

    kind: str
    parts: tuple[Node, ...] = ()
    number: float = 0.0
    name: str = ""
    text: str = field(default="", compare=False)
    place: int = field(default=1, compare=False)

    def all_nodes(self) -> Iterator[Node]:
        """The node itself and all below it."""
        yield self
        for part in self.parts:
            yield from part.all_nodes()

    @property
    def names(self) -> frozenset[str]:
        """The names in it."""
        return frozenset(node.name for node in self.all_nodes() if node.kind == "name")

    @property
    def has_derivative(self) -> bool:
        """Whether there is a derivative in space in it."""
        return any(node.kind in DERIVATIVES for node in self.all_nodes())


def number(value: float) -> Node:
    """A number as a formula."""
    return Node("number", number=value, text=f"{value:g}")
