"""The compiled kernels that run the instructions of a formula, forwards for its values and backwards for its derivatives.

An instruction is a row (operation, left, right, result) of whole numbers, the last three rows of a table of values. A kernel
takes one instruction after the other over all grid points, so that no formula has to be compiled by itself.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mol_compactons.runtime.compiled import compiled

Array = NDArray[np.float64]
Code = NDArray[np.int64]

OPERATIONS = (
    "number",
    "difference",
    "add",
    "subtract",
    "multiply",
    "divide",
    "negative",
    "power",
    "max",
    "min",
    "abs",
    "sign",
    "heaviside",
    "exp",
    "log",
    "sin",
    "cos",
    "tan",
    "sinh",
    "cosh",
    "tanh",
    "sech",
)
"""What an instruction can be; its place in this list is its number."""

(
    NUMBER,
    DIFFERENCE,
    ADD,
    SUBTRACT,
    MULTIPLY,
    DIVIDE,
    NEGATIVE,
    POWER,
    MAX,
    MIN,
    ABS,
    SIGN,
    HEAVISIDE,
    EXP,
    LOG,
    SIN,
    COS,
    TAN,
    SINH,
    COSH,
    TANH,
    SECH,
) = range(len(OPERATIONS))

DERIVATIVE_FLOOR = 1e-6
"""Where the slope of a power is infinite, at zero, the base counts as at least this times its largest value on the grid."""


@compiled
def execute(code: Code, numbers: Array, start: int, stop: int, values: Array) -> None:
    """Run the instructions from `start` to before `stop`.

    Parameters
    ----------
    code : array, shape (instructions, 4)
        Operation, left, right and result of each.
    numbers : array, shape (instructions,)
        The number in it: a constant, or an exponent.
    start, stop : int
        Which instructions; no difference is among them.
    values : array, shape (rows, N)
        The table, in place.
    """
    for k in range(start, stop):
        operation, number = code[k, 0], numbers[k]
        left, right, result = values[code[k, 1]], values[code[k, 2]], values[code[k, 3]]
        if operation == NUMBER:
            result[:] = number
        elif operation == POWER:
            _power(left, number, result)
        elif operation <= MIN:
            _combine(operation, left, right, result)
        else:
            for j in range(result.size):
                result[j] = _function(operation, left[j])


@compiled
def _combine(operation: int, left: Array, right: Array, result: Array) -> None:
    """One of the operations on two values; each has a loop of its own, which the compiler vectorises."""
    if operation == ADD:
        for j in range(result.size):
            result[j] = left[j] + right[j]
    elif operation == SUBTRACT:
        for j in range(result.size):
            result[j] = left[j] - right[j]
    elif operation == MULTIPLY:
        for j in range(result.size):
            result[j] = left[j] * right[j]
    elif operation == DIVIDE:
        for j in range(result.size):
            result[j] = left[j] / right[j]
    elif operation == NEGATIVE:
        for j in range(result.size):
            result[j] = -left[j]
    elif operation == MAX:
        for j in range(result.size):
            result[j] = max(left[j], right[j])
    else:
        for j in range(result.size):
            result[j] = min(left[j], right[j])


@compiled
def _function(operation: int, value: float) -> float:
    """One of the functions of one value."""
    if operation == ABS:
        return abs(value)
    if operation == SIGN:
        return float(np.sign(value))
    if operation == HEAVISIDE:
        return 0.5 * (1.0 + float(np.sign(value)))
    if operation == EXP:
        return math.exp(value)
    if operation == LOG:
        return math.log(value)
    if operation == SIN:
        return math.sin(value)
    if operation == COS:
        return math.cos(value)
    if operation == TAN:
        return math.tan(value)
    if operation == SINH:
        return math.sinh(value)
    if operation == COSH:
        return math.cosh(value)
    if operation == TANH:
        return math.tanh(value)
    return 1.0 / math.cosh(value)


@compiled
def _slope(operation: int, value: float, result: float) -> float:
    """The derivative of a function at a value where it has a result."""
    if operation == ABS:
        return float(np.sign(value))
    if operation == EXP:
        return result
    if operation == LOG:
        return 1.0 / value
    if operation == SIN:
        return math.cos(value)
    if operation == COS:
        return -math.sin(value)
    if operation == TAN:
        return 1.0 + result * result
    if operation == SINH:
        return math.cosh(value)
    if operation == COSH:
        return math.sinh(value)
    if operation == TANH:
        return 1.0 - result * result
    if operation == SECH:
        return -result * math.tanh(value)
    return 0.0


@compiled
def _power(base: Array, exponent: float, result: Array) -> None:
    """base^exponent for an exponent that is no whole number; quarters by square roots, which are faster than powers."""
    quarters = round(4 * exponent)
    if 4 * exponent == quarters and 0 < quarters <= 32:
        for j in range(result.size):
            value = 1.0
            for _ in range(quarters >> 2):
                value *= base[j]
            root = math.sqrt(base[j])
            if quarters & 2:
                value *= root
            if quarters & 1:
                value *= math.sqrt(root)
            result[j] = value
    else:
        for j in range(result.size):
            result[j] = base[j] ** exponent


@compiled
def _power_slope(base: Array, exponent: float, result: Array) -> None:
    """Exponent base^(exponent - 1), regularised where it is infinite, see `DERIVATIVE_FLOOR`; zero where all is zero."""
    floor = DERIVATIVE_FLOOR * np.abs(base).max() if 0 < exponent < 1 else 0.0
    for j in range(result.size):
        size = max(base[j], floor)
        result[j] = exponent * size ** (exponent - 1.0) if size > 0.0 else 0.0


@compiled
def differentiate(code: Code, numbers: Array, needed: Code, values: Array, slopes: Array) -> None:
    """The derivative of one row of the table by each row that it is made of, by reverse accumulation.

    Parameters
    ----------
    code, numbers
        As in `execute`.
    needed : array of int
        The instructions that the row is made of, the last one first. Rows that others write are left alone.
    values : array, shape (rows, N)
        The table after all instructions.
    slopes : array, shape (rows, N)
        One for the row itself, zero for the others on entry; on return the derivative by each row.
    """
    scratch = np.empty(values.shape[1])
    for k in needed:
        operation, left, right, row = code[k, 0], code[k, 1], code[k, 2], code[k, 3]
        if operation == POWER:
            _power_slope(values[left], numbers[k], scratch)
            for j in range(scratch.size):
                slopes[left, j] += slopes[row, j] * scratch[j]
        elif operation > MIN:
            for j in range(scratch.size):
                slopes[left, j] += slopes[row, j] * _slope(operation, values[left, j], values[row, j])
        elif operation != NUMBER:
            _distribute(operation, values[left], values[right], slopes[row], slopes[left], slopes[right])


@compiled
def _distribute(operation: int, left: Array, right: Array, slope: Array, by_left: Array, by_right: Array) -> None:
    """Add to the derivatives by two values what an operation on them passes on; the two may be one row."""
    for j in range(slope.size):
        if operation == ADD:
            by_left[j] += slope[j]
            by_right[j] += slope[j]
        elif operation == SUBTRACT:
            by_left[j] += slope[j]
            by_right[j] -= slope[j]
        elif operation == MULTIPLY:
            by_left[j] += slope[j] * right[j]
            by_right[j] += slope[j] * left[j]
        elif operation == DIVIDE:
            by_left[j] += slope[j] / right[j]
            by_right[j] -= slope[j] * left[j] / (right[j] * right[j])
        elif operation == NEGATIVE:
            by_left[j] -= slope[j]
        elif (left[j] >= right[j]) == (operation == MAX):
            by_left[j] += slope[j]
        else:
            by_right[j] += slope[j]


@compiled
def add_shifted(stencil: Array, diagonals: Array, out: Array) -> None:
    """Add the cyclic diagonals of a difference of something to `out`.

    Parameters
    ----------
    stencil : array, shape (2 r + 1,)
        The difference.
    diagonals : array, shape (2 R + 1, N)
        ``diagonals[R + d, j]`` is the derivative of the thing in cell j by the unknown in cell j + d.
    out : array, shape (2 (R + r) + 1, N)
        The same for its difference.
    """
    reach, size = stencil.size // 2, diagonals.shape[1]
    for place in range(stencil.size):
        offset = place - reach
        # Cell j takes from cell j + offset on the ring: first the cells that stay below N, then those that wrap.
        shift = offset % size
        for d in range(diagonals.shape[0]):
            for j in range(size - shift):
                out[place + d, j] += stencil[place] * diagonals[d, j + shift]
            for j in range(size - shift, size):
                out[place + d, j] += stencil[place] * diagonals[d, j + shift - size]
