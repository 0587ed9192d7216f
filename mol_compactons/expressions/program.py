"""Formulas as a list of instructions: their values, and their exact derivatives through all differences."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from mol_compactons.errors import InputError
from mol_compactons.expressions.kernels import (
    DIFFERENCE,
    NUMBER,
    OPERATIONS,
    Array,
    Code,
    add_shifted,
    differentiate,
    execute,
)
from mol_compactons.expressions.tree import DERIVATIVES, Node

Inputs = Mapping[str, Array | float]

COMPLAINTS = {
    "divide": "divides by {operand!r}, which is 0 {where}; add a small number to it",
    "inverse": "raises {operand!r}, which is 0 {where}, to the power {exponent:g}; add a small number to it",
    "power": "raises {operand!r}, which is negative {where}, to the power {exponent:g}; write abs({operand})**{exponent:g}, "
    "or sign({operand})*abs({operand})**{exponent:g}",
    "log": "takes the logarithm of {operand!r}, which is not positive {where}; write log(abs({operand}) + 1e-9)",
}
"""What is wrong where an operation has no value, and the cure."""


@dataclass(frozen=True)
class Guard:
    """An operation that has no value for every operand.

    Parameters
    ----------
    kind : str
        Which of `COMPLAINTS`.
    row : int
        The row of the operand, or of the denominator.
    node : Node
        The operation.
    operand : str
        The operand as it was written.
    """

    kind: str
    row: int
    node: Node
    operand: str

    def trips(self, operand: Array) -> Array:
        """Where the operand has no value; nowhere where it is NaN, which stands for unknown."""
        if self.kind == "log":
            return np.asarray(operand <= 0)
        return np.asarray(operand < 0 if self.kind == "power" else operand == 0)


def _no_derivative(values: Array, order: int) -> Array:
    raise InputError(f"A formula with a derivative d{order} stands where there is no grid; write it without.")


class _Difference(NamedTuple):
    """An instruction that takes a difference: which one, of and into which rows, of which order."""

    place: int
    operand: int
    row: int
    order: int


class Program:
    """Formulas as instructions on a table of values, one row for each input and each different part of the formulas.

    Equal parts are computed once. A program never changes, so that threads may share it.

    Parameters
    ----------
    nodes : sequence of Node
        The formulas.
    """

    def __init__(self, nodes: Sequence[Node]) -> None:
        builder = _Builder()
        self.outputs = tuple(builder.row(node) for node in nodes)
        """The row of each formula."""
        self.inputs = dict(builder.inputs)
        """The row of each name that stands in them."""
        self.guards = tuple(builder.guards)
        self.rows = builder.rows
        self.code = np.array(builder.code, dtype=np.int64).reshape(-1, 4)
        self.numbers = np.array(builder.numbers, dtype=float)
        self.differences = tuple(
            _Difference(k, int(self.code[k, 1]), int(self.code[k, 3]), int(self.numbers[k]))
            for k in np.flatnonzero(self.code[:, 0] == DIFFERENCE).tolist()
        )
        self._writer = {int(row): k for k, row in enumerate(self.code[:, 3])}
        wanted = {*self.outputs, *(difference.operand for difference in self.differences)}
        self._needed = {row: self._instructions_of(row) for row in wanted}
        self._sources = {row: self._sources_of(row) for row in wanted}

    def evaluate(self, size: int, inputs: Inputs, derivative: Callable[[Array, int], Array] = _no_derivative) -> Array:
        """The table of values, shape (rows, N).

        Parameters
        ----------
        size : int
            The number N of points.
        inputs : mapping
            For each name its values, shape (N,), or one number. What is not asked for may be there.
        derivative : callable, optional
            ``derivative(values, order)`` takes a difference; needed where there is a derivative.
        """
        values = np.empty((self.rows, size))
        for name, row in self.inputs.items():
            values[row] = inputs[name]
        start = 0
        for difference in self.differences:
            if difference.place > start:
                execute(self.code, self.numbers, start, difference.place, values)
            values[difference.row] = derivative(values[difference.operand], difference.order)
            start = difference.place + 1
        if len(self.code) > start:
            execute(self.code, self.numbers, start, len(self.code), values)
        return values

    def slopes(self, values: Array, output: int = 0) -> dict[str, Array]:
        """The derivative of a formula without differences by each of its inputs, each of shape (N,)."""
        slopes = self._slopes(values, self.outputs[output])
        return {name: slopes[row] for name, row in self.inputs.items()}

    def _slopes(self, values: Array, row: int) -> Array:
        """The derivative of a row of the table by each row, shape (rows, N), where differences count as inputs."""
        slopes = np.zeros_like(values)
        slopes[row] = 1.0
        differentiate(self.code, self.numbers, self._needed[row], values, slopes)
        return slopes

    def _instructions_of(self, row: int) -> Code:
        """The instructions that a row is made of, the last one first, differences and what is behind them left out."""
        found: set[int] = set()
        waiting = [row]
        while waiting:
            k = self._writer.get(waiting.pop())
            if k is not None and k not in found and self.code[k, 0] != DIFFERENCE:
                found.add(k)
                waiting += self.code[k, 1:3].tolist() if self.code[k, 0] != NUMBER else []
        return np.array(sorted(found, reverse=True), dtype=np.int64)

    def _sources_of(self, row: int) -> frozenset[int]:
        """The rows of the inputs and differences that a row is made of."""
        needed = self.code[self._needed[row]]
        read = needed[needed[:, 0] != NUMBER, 1:3]
        return frozenset({row, *read.ravel().tolist()}) - frozenset(needed[:, 3].tolist())

    def reach(self, stencils: Mapping[int, Array], output: int = 0) -> int:
        """How many neighbours on each side the value of a formula depends on, with the stencil of each order."""
        return self._reach(self.outputs[output], self._reaches(stencils))

    def _reaches(self, stencils: Mapping[int, Array]) -> dict[int, int]:
        """The reach of each difference, by its row."""
        reaches: dict[int, int] = {}
        for one in self.differences:
            reaches[one.row] = self._reach(one.operand, reaches) + stencils[one.order].size // 2
        return reaches

    def _reach(self, row: int, reaches: Mapping[int, int]) -> int:
        return max((reaches.get(source, 0) for source in self._sources[row]), default=0)

    def diagonals(self, values: Array, stencils: Mapping[int, Array], fields: Sequence[str], output: int = 0) -> Array:
        """The exact derivative of a formula by the values of some of its inputs, through all differences.

        Parameters
        ----------
        values : array, shape (rows, N)
            What `evaluate` returned with the same stencils.
        stencils : mapping
            The stencil of each order of derivative, shape (2 r + 1,).
        fields : sequence of str
            By which inputs.
        output : int
            Which formula.

        Returns
        -------
        array, shape (fields, 2 R + 1, N)
            Cyclic diagonals: ``[f, R + d, j]`` is the derivative in cell j by input f in cell j + d; R is `reach`.
        """
        reaches = self._reaches(stencils)
        known: dict[int, Array] = {}
        for one in self.differences:
            inner = self._chain(values, one.operand, fields, known, self._reach(one.operand, reaches))
            known[one.row] = np.zeros((len(fields), 2 * reaches[one.row] + 1, values.shape[1]))
            for field in range(len(fields)):
                add_shifted(stencils[one.order], inner[field], known[one.row][field])
        row = self.outputs[output]
        return self._chain(values, row, fields, known, self._reach(row, reaches))

    def _chain(self, values: Array, row: int, fields: Sequence[str], known: Mapping[int, Array], reach: int) -> Array:
        """The chain rule for a row: through the inputs, and through the differences whose derivatives are known."""
        slopes = self._slopes(values, row)
        result = np.zeros((len(fields), 2 * reach + 1, values.shape[1]))
        for index, name in enumerate(fields):
            if name in self.inputs:
                result[index, reach] += slopes[self.inputs[name]]
        for source in self._sources[row] & known.keys():
            inner = known[source].shape[1] // 2
            result[:, reach - inner : reach + inner + 1] += slopes[source] * known[source]
        return result

    def refuse_singular(self, values: Array, role: str, where: Callable[[int], str]) -> None:
        """Refuse a table of values in which an operation has no value.

        Parameters
        ----------
        values : array, shape (rows, N)
            What `evaluate` returned; NaN stands for a value that is not known.
        role : str
            Which formula this is.
        where : callable
            Says in words where the point of an index is: "at x = 3".

        Raises
        ------
        InputError
            One sentence that points at the operation.
        """
        for guard in self.guards:
            tripped = np.flatnonzero(guard.trips(values[guard.row]))
            if tripped.size:
                node = guard.node
                complaint = COMPLAINTS[guard.kind].format(
                    operand=guard.operand, exponent=node.number, where=where(int(tripped[0]))
                )
                raise InputError(f"{role}: {node.text!r} at character {node.place} {complaint}.")


class _Builder:
    """Writes the instructions of formulas; an instruction that is there already is not written again."""

    def __init__(self) -> None:
        self.inputs: dict[str, int] = {}
        self.code: list[tuple[int, int, int, int]] = []
        self.numbers: list[float] = []
        self.guards: list[Guard] = []
        self.rows = 0
        self._known: dict[tuple[int, int, int, float], int] = {}

    def row(self, node: Node) -> int:
        """The row that holds a formula."""
        if node.kind == "name":
            if node.name not in self.inputs:
                self.inputs[node.name] = self._new_row()
            return self.inputs[node.name]
        if node.kind == "number":
            return self._constant(node.number)
        rows = [self.row(part) for part in node.parts]
        self._guard(node, rows)
        if node.kind == "power":
            return self._power(rows[0], node.number)
        if node.kind in DERIVATIVES:
            return self._write(DIFFERENCE, rows[0], rows[0], float(DERIVATIVES[node.kind]))
        return self._write(OPERATIONS.index(node.kind), rows[0], rows[-1])

    def _new_row(self) -> int:
        self.rows += 1
        return self.rows - 1

    def _write(self, operation: int, left: int, right: int, number: float = 0.0) -> int:
        key = (operation, left, right, number)
        if key not in self._known:
            self._known[key] = self._new_row()
            self.code.append((operation, left, right, self._known[key]))
            self.numbers.append(number)
        return self._known[key]

    def _constant(self, value: float) -> int:
        return self._write(NUMBER, 0, 0, value)

    def _power(self, base: int, exponent: float) -> int:
        """Whole powers by products, which keep the sign of a base exactly."""
        if exponent != int(exponent):
            return self._write(OPERATIONS.index("power"), base, base, exponent)
        product, square = None, base
        left = abs(int(exponent))
        while left:
            if left & 1:
                product = square if product is None else self._write(OPERATIONS.index("multiply"), product, square)
            left >>= 1
            square = self._write(OPERATIONS.index("multiply"), square, square) if left else square
        result = self._constant(1.0) if product is None else product
        return result if exponent >= 0 else self._write(OPERATIONS.index("divide"), self._constant(1.0), result)

    def _guard(self, node: Node, rows: list[int]) -> None:
        """Remember what to watch."""
        if node.kind == "power":
            if node.number < 0:
                self.guards.append(Guard("inverse", rows[0], node, node.parts[0].text))
            if node.number != int(node.number):
                self.guards.append(Guard("power", rows[0], node, node.parts[0].text))
        elif node.kind in ("divide", "log"):
            self.guards.append(Guard(node.kind, rows[-1], node, node.parts[-1].text))


@lru_cache(maxsize=4096)
def folded(kind: str, numbers: tuple[float, ...], exponent: float) -> float:
    """The value of an operation on numbers, NaN or infinity where there is none."""
    parts = tuple(Node("number", number=one) for one in numbers)
    program = Program((Node(kind, parts, exponent),))
    value = float(program.evaluate(1, {})[program.outputs[0], 0])
    return value if math.isfinite(value) else math.nan
