"""A flux that was given as a formula, in the form a(u) + b(u) g(u)_xx."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mol_compactons.equations.flux import DispersiveFlux
from mol_compactons.expressions import Node, Program, number

Array = NDArray[np.float64]

ZERO, ONE = number(0.0), number(1.0)

POINTS = 32
"""The points of the quadrature for antiderivatives."""


class FormulaFlux(DispersiveFlux):
    """The flux F[u] = a(u) + b(u) g(u)_xx of three formulas in u.

    Parameters
    ----------
    a, b, g : Node
        The formulas.
    variable : str
        What they call u.
    background : float
        The value of u about which a is regular; antiderivatives vanish there.
    """

    def __init__(self, a: Node, b: Node, g: Node, variable: str, background: float) -> None:
        self.a, self.b, self.g = a, b, g
        self._variable, self._background = variable, background
        self._program = Program((b, g, a))
        self._convective = Program((a,))
        self.variational_constant = self._variational_constant()
        """The kappa for which b = kappa g', or None."""

    def evaluate(self, u: Array, b: Array, g: Array, a: Array) -> None:
        """Write b(u), g(u) and a(u)."""
        values = self._program.evaluate(u.size, {self._variable: u})
        for out, row in zip((b, g, a), self._program.outputs, strict=True):
            out[:] = values[row]

    def slopes(self, u: Array, b: Array, g: Array, a: Array) -> None:
        """Write b'(u), g'(u) and a'(u); regularised where they are infinite."""
        values = self._program.evaluate(u.size, {self._variable: u})
        for index, out in enumerate((b, g, a)):
            out[:] = self._program.slopes(values, index).get(self._variable, 0.0)

    def energy_parts(self, u: Array, g_second: Array) -> Array:
        """A(u) and (kappa / 2) g g_xx, shape (2, N), with A' = a; the density whose variation is F is their sum.

        A is an integral over 32 Gauss points in the fourth root of the distance from the background, exact to round-off for
        polynomials and for powers by quarters.

        Parameters
        ----------
        u : array, shape (N,)
            The state.
        g_second : array, shape (N,)
            The second difference of g(u).
        """
        points, weights = np.polynomial.legendre.leggauss(POINTS)
        roots = 0.5 * (points + 1)
        distance = u - self._background
        along = self._background + roots[:, None] ** 4 * distance
        values = self._convective.evaluate(along.size, {self._variable: along.ravel()})
        a = values[self._convective.outputs[0]].reshape(along.shape)
        potential = distance * ((2 * weights * roots**3) @ a)
        return np.array([potential, 0.5 * float(self.variational_constant or 0) * self.g_values(u) * g_second])

    def g_values(self, u: Array) -> Array:
        """The values g(u), shape (N,)."""
        values = self._program.evaluate(u.size, {self._variable: u})
        return np.asarray(values[self._program.outputs[1]])

    def _variational_constant(self) -> float | None:
        """Found at a few points around the background; b and g' that are proportional there are so everywhere."""
        u = self._background + np.array([-1.3, -0.9, -0.35, 0.25, 0.6, 1.1, 1.7]) * (0.5 * abs(self._background) or 1.0)
        b, g, a, slope, unused = np.empty((5, u.size))
        self.evaluate(u, b, g, a)
        self.slopes(u, unused, slope, a)
        known = np.isfinite(b) & np.isfinite(slope)
        b, slope = b[known], slope[known]
        if not np.any(b):
            return 0.0
        kappa = float(b @ slope) / float(slope @ slope) if np.any(slope) else 0.0
        return kappa if np.allclose(b, kappa * slope, rtol=1e-10, atol=1e-12 * np.abs(b).max()) else None


def dispersive_form(tree: Node, variable: str, background: float) -> FormulaFlux | None:
    """A formula in the form a(u) + b(u) d2(g(u)), or None where it has another.

    Terms may be several, as long as one b or one g, up to constant factors, stands for all.
    """
    terms = _linear(tree) if tree.names <= {variable} else None
    if terms is None:
        return None
    a = ZERO
    for term, inside in terms:
        a = a if inside is not None else _sum(a, term)
    found: dict[bytes, tuple[Node, Node]] = {}
    for factor, inside in terms:
        if inside is not None:
            constant, core = _split(inside)
            key = _key(core)
            before = found[key][0] if key in found else ZERO
            found[key] = (_sum(before, _product(number(constant), factor)), core)
    if len(found) < 2:
        b, g = next(iter(found.values()), (ZERO, ZERO))
        return FormulaFlux(a, b, g, variable, background)
    g, cores = ZERO, {}
    for factor, inside in found.values():
        constant, core = _split(factor)
        cores[_key(core)] = core
        g = _sum(g, _product(number(constant), inside))
    return FormulaFlux(a, next(iter(cores.values())), g, variable, background) if len(cores) == 1 else None


Terms = list[tuple[Node, Node | None]]
"""Pairs of a factor and what its second derivative multiplies; None for a factor that multiplies nothing."""


def _linear(node: Node) -> Terms | None:
    """A formula as a sum of terms that are linear in second derivatives; None where it is no such sum."""
    if not node.has_derivative:
        return [(node, None)]
    if node.kind == "d2":
        return None if node.parts[0].has_derivative else [(ONE, node.parts[0])]
    if node.kind not in ("add", "subtract", "negative", "multiply", "divide"):
        return None
    left, right = _linear(node.parts[0]), _linear(node.parts[-1])
    if left is None or right is None:
        return None
    if node.kind == "add":
        return left + right
    if node.kind == "subtract":
        return left + [(_product(number(-1.0), factor), inside) for factor, inside in right]
    if node.kind == "negative":
        return [(_product(number(-1.0), factor), inside) for factor, inside in left]
    if node.kind == "divide":
        return None if node.parts[1].has_derivative else [(Node("divide", (f, node.parts[1])), inside) for f, inside in left]
    if node.parts[0].has_derivative and node.parts[1].has_derivative:
        return None
    factor, terms = (node.parts[1], left) if node.parts[0].has_derivative else (node.parts[0], right)
    return [(_product(factor, inner), inside) for inner, inside in terms]


def _sum(left: Node, right: Node) -> Node:
    return right if left == ZERO else Node("add", (left, right))


def _product(left: Node, right: Node) -> Node:
    return right if left == ONE else left if right == ONE else Node("multiply", (left, right))


def _split(node: Node) -> tuple[float, Node]:
    """A formula as a number times the rest."""
    if node.kind == "number":
        return node.number, ONE
    if node.kind == "negative":
        constant, core = _split(node.parts[0])
        return -constant, core
    if node.kind == "multiply":
        (first, left), (second, right) = _split(node.parts[0]), _split(node.parts[1])
        return first * second, _product(left, right)
    if node.kind == "divide" and node.parts[1].kind == "number":
        constant, core = _split(node.parts[0])
        return constant / node.parts[1].number, core
    return 1.0, node


def _key(node: Node) -> bytes:
    """Equal for formulas that are computed by the same instructions, such as u*u and u**2."""
    program = Program((node,))
    return program.code.tobytes() + program.numbers.tobytes()
