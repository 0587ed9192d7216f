"""Formulas in given names, without derivatives in space: initial data in x, driven ends in t."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mol_compactons.errors import InputError
from mol_compactons.expressions.kernels import Array
from mol_compactons.expressions.program import Program
from mol_compactons.expressions.syntax import parse
from mol_compactons.expressions.tree import Node


@dataclass(frozen=True)
class Pointwise:
    """A formula as a function of some names; see `pointwise`, which makes it.

    Parameters
    ----------
    tree : Node
        The formula.
    names : tuple of str
        What it is a function of, in this order.
    role : str
        What it is, for sentences.
    """

    tree: Node
    names: tuple[str, ...]
    role: str

    def __call__(self, *values: ArrayLike) -> Any:
        """The value of the formula for a value of each name.

        Parameters
        ----------
        *values : array or float
            One for each name, of shapes that fit together.

        Returns
        -------
        array of the common shape, or float

        Raises
        ------
        InputError
            If the formula has no value there.
        """
        table, shape = self._table(values)
        return self._shaped(table[_program(self.tree).outputs[0]], shape)

    def slope(self, name: str, *values: ArrayLike) -> Any:
        """The derivative by one of the names, exact, in the shape of the values; where it is infinite it is regularised."""
        table, shape = self._table(values)
        program = _program(self.tree)
        slope = program.slopes(table).get(name, np.zeros(table.shape[1]))
        return self._shaped(slope, shape)

    def _table(self, values: Sequence[ArrayLike]) -> tuple[Array, tuple[int, ...]]:
        arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in values))
        if len(arrays) != len(self.names):
            raise InputError(f"{self.role} is a function of {', '.join(self.names)}; give {len(self.names)} values.")
        inputs = {name: array.ravel() for name, array in zip(self.names, arrays, strict=True)}
        program = _program(self.tree)
        table = program.evaluate(arrays[0].size, inputs)

        def where(index: int) -> str:
            return "at " + ", ".join(f"{name} = {inputs[name][index]:g}" for name in program.inputs)

        program.refuse_singular(table, self.role, where)
        return table, arrays[0].shape

    @staticmethod
    def _shaped(values: Array, shape: tuple[int, ...]) -> Any:
        return values.reshape(shape) if shape else float(values[0])


@lru_cache(maxsize=256)
def _program(tree: Node) -> Program:
    return Program((tree,))


def pointwise(
    text: str, names: Sequence[str] = ("x",), parameters: Mapping[str, float] | None = None, role: str = "formula"
) -> Pointwise:
    """A formula as a function of numbers or arrays.

    Parameters
    ----------
    text : str
        The formula, such as "exp(-(x - 20)**2 / 4)".
    names : sequence of str
        What it is a function of, in the order of the arguments.
    parameters : mapping, optional
        Names that stand for numbers.
    role : str
        What it is, for sentences.

    Raises
    ------
    InputError
        If it is no formula in these names; see `mol_compactons.expressions.parse`.

    Examples
    --------
    >>> pointwise("4/3 * sin(k*x)**2", parameters={"k": 0.5})(np.pi / 2)
    0.6666666666666665
    >>> pointwise("t**2", names=("t",)).slope("t", [1.0, 3.0])
    array([2., 6.])
    """
    return Pointwise(parse(text, role, names, parameters), tuple(names), role)
