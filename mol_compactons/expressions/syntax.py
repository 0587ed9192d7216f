"""From the text of a formula to its tree; nothing in the text is ever run.

The text is cut into numbers, names and signs, anything else is refused. Python's own parser, which runs nothing, then makes a
syntax tree of it, and of its nodes only arithmetic, known names and known functions are taken over.
"""

from __future__ import annotations

import ast
import keyword
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mol_compactons.configuration import did_you_mean
from mol_compactons.errors import InputError
from mol_compactons.expressions.program import folded
from mol_compactons.expressions.tree import DERIVATIVES, FUNCTIONS, Node

LONGEST_TEXT = 2000
"""The most characters of a formula."""

DEEPEST = 100
"""The deepest nesting of a formula; a sum of so many terms nests as deep."""

LARGEST_EXPONENT = 100
"""The largest exponent of a power, of either sign."""

CONSTANTS = {"pi": math.pi, "e": math.e}

RESERVED = frozenset({*FUNCTIONS, *DERIVATIVES, *CONSTANTS, *keyword.kwlist})
"""Names that a formula understands already, or cannot hold."""

LONGEST_SHOWN = 60
"""How much of a formula a sentence shows."""

_TOKEN = re.compile(
    r"(?P<space>\s+)|(?P<number>(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*)|(?P<sign>\*\*|[-+*/(),])", re.A
)

_ARITHMETIC: dict[type, str] = {ast.Add: "add", ast.Sub: "subtract", ast.Mult: "multiply", ast.Div: "divide"}

_CURES = {
    "^": "write ** for a power",
    "|": "write abs(...)",
    "=": "give one side of an equation only",
    "<": "write heaviside(...) for a condition",
    ">": "write heaviside(...) for a condition",
    ".": "a number has digits beside its point",
    "[": "write round brackets",
    "{": "write round brackets",
}


def parse(
    text: str, role: str, names: Sequence[str], parameters: Mapping[str, float] | None = None, derivatives: bool = False
) -> Node:
    """The tree of a formula.

    Parameters
    ----------
    text : str
        The formula.
    role : str
        What it is, for sentences: "CustomEquation.flux".
    names : sequence of str
        The variables that may stand in it.
    parameters : mapping, optional
        Names that stand for numbers.
    derivatives : bool
        Whether d1, d2 and d3 may stand in it.

    Raises
    ------
    InputError
        If it is no such formula. The sentence shows the place and says what to write.
    """
    return _Reader(text, role, tuple(names), dict(parameters or {}), derivatives).read()


def check_name(name: str, role: str) -> None:
    """Refuse a name that cannot stand in a formula, or has a meaning there already."""
    if not (name.isidentifier() and name.isascii()):
        raise InputError(f"{role}: the name {name!r} must consist of letters, digits and underscores; choose another.")
    if name in RESERVED:
        raise InputError(f"{role}: the name {name!r} has a meaning in formulas already; choose another, such as {name}0.")


@dataclass(frozen=True)
class _Reader:
    text: str
    role: str
    names: tuple[str, ...]
    parameters: Mapping[str, float]
    derivatives: bool

    def read(self) -> Node:
        """The tree of the whole text."""
        if len(self.text) > LONGEST_TEXT:
            raise InputError(
                f"{self.role} has {len(self.text)} characters, a formula may have {LONGEST_TEXT}; give numbers as parameters."
            )
        self._check_tokens()
        if not self.text.strip():
            raise InputError(f"{self.role} is empty; write a formula, such as 0.")
        try:
            # With spaces for line breaks, and none in front, every place is a column of one line.
            tree = ast.parse(re.sub(r"\s", " ", self.text).lstrip(), mode="eval").body
        except SyntaxError as error:
            start = min((error.offset or 1) - 1 + self._indent, len(self.text) - 1)
            raise self._error(
                start, start + 1, "the formula cannot be read on from here", self._unbalanced() or "look for what is missing"
            ) from None
        except (RecursionError, MemoryError):
            raise InputError(f"{self.role} = {self._shown(0)} is nested too deeply; write it in fewer brackets.") from None
        self._check_depth(tree)
        return self._convert(tree)

    @property
    def _indent(self) -> int:
        return len(self.text) - len(self.text.lstrip())

    def _shown(self, around: int) -> str:
        """The text, or the part of it around a place."""
        if len(self.text) <= LONGEST_SHOWN:
            return repr(self.text)
        start = max(0, min(around - LONGEST_SHOWN // 2, len(self.text) - LONGEST_SHOWN))
        before, after = "..." if start else "", "..." if start + LONGEST_SHOWN < len(self.text) else ""
        return repr(before + self.text[start : start + LONGEST_SHOWN] + after)

    def _error(self, start: int, stop: int, problem: str, cure: str) -> InputError:
        piece = self.text[start:stop]
        piece = piece if len(piece) <= LONGEST_SHOWN else piece[:LONGEST_SHOWN] + "..."
        end = "" if cure.endswith("?") else "."
        return InputError(f"{self.role} = {self._shown(start)}: at character {start + 1}, {piece!r}, {problem}; {cure}{end}")

    def _check_tokens(self) -> None:
        """Refuse every character that no formula has, before Python's parser sees any."""
        position, before = 0, ""
        while position < len(self.text):
            token = _TOKEN.match(self.text, position)
            if token is None:
                character = self.text[position]
                cure = _CURES.get(character, "a formula has numbers, names, + - * / ** ( ) and commas")
                raise self._error(position, position + 1, "there is a sign that no formula has", cure)
            word, kind = token.group(), token.lastgroup
            if kind == "name" and keyword.iskeyword(word):
                raise self._error(position, token.end(), "there is a word of the language Python", "choose another name")
            # A name before a bracket is a function; every other two values need a sign between them.
            value = kind in ("number", "name") or (word == "(" and before != "name")
            if value and before in ("number", "name", ")"):
                raise self._error(position, token.end(), "two values stand side by side", "write * between them for a product")
            if kind != "space":
                before = word if kind == "sign" else str(kind)
            position = token.end()
        if before in ("+", "-", "*", "/", "**", "(", ","):
            raise self._error(
                len(self.text.rstrip()) - len(before),
                len(self.text.rstrip()),
                "the formula ends too early",
                "go on with a value",
            )

    def _unbalanced(self) -> str:
        missing = self.text.count("(") - self.text.count(")")
        if missing == 0:
            return ""
        return f"{abs(missing)} bracket{'s' * (abs(missing) > 1)} {'must be closed' if missing > 0 else 'too many close'}"

    def _check_depth(self, tree: ast.expr) -> None:
        """Refuse deep nesting, without recursion."""
        waiting: list[tuple[ast.AST, int]] = [(tree, 1)]
        while waiting:
            node, depth = waiting.pop()
            if depth > DEEPEST:
                start, stop = self._span(node)
                raise self._error(
                    start, stop, f"the formula is nested more than {DEEPEST} deep", "write it in fewer brackets or terms"
                )
            waiting += [(child, depth + 1) for child in ast.iter_child_nodes(node) if isinstance(child, ast.expr)]

    def _span(self, node: ast.AST) -> tuple[int, int]:
        start, stop = getattr(node, "col_offset", 0), getattr(node, "end_col_offset", 0)
        return start + self._indent, stop + self._indent

    def _error_at(self, node: ast.AST, problem: str, cure: str) -> InputError:
        return self._error(*self._span(node), problem, cure)

    def _node(self, node: ast.AST, kind: str, parts: tuple[Node, ...], exponent: float = 0.0) -> Node:
        """An operation; on numbers it is one number."""
        start, stop = self._span(node)
        text, place = self.text[start:stop], start + 1
        if kind not in DERIVATIVES and all(part.kind == "number" for part in parts):
            value = folded(kind, tuple(part.number for part in parts), exponent)
            if not math.isfinite(value):
                raise self._error_at(node, "the number is too large, or does not exist", "write one that does")
            return Node("number", number=value, text=text, place=place)
        return Node(kind, parts, exponent, text=text, place=place)

    def _convert(self, node: ast.expr) -> Node:
        match node:
            case ast.Constant(value=int() | float() as value):
                return self._number(node, value)
            case ast.Name(id=name):
                return self._name(node, name)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self._node(node, "negative", (self._convert(operand),))
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return self._convert(operand)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _ARITHMETIC:
                return self._node(node, _ARITHMETIC[type(op)], (self._convert(left), self._convert(right)))
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                return self._power(node, self._convert(left), self._convert(right))
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
                return self._call(node, name, arguments)
            case ast.Call(func=func):
                raise self._error_at(
                    func, "a value is called like a function", f"write {ast.unparse(func)}*(...) for a product"
                )
            case ast.Tuple():
                raise self._error_at(node, "a comma stands outside a function", "a number has a decimal point, not a comma")
        raise self._error_at(node, "there is something that no formula has", "use + - * / **, numbers, names and functions")

    def _number(self, node: ast.expr, value: float) -> Node:
        start, stop = self._span(node)
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self._error(start, stop, "the number is too large", "write one below 1e308")
        return Node("number", number=number, text=self.text[start:stop], place=start + 1)

    def _name(self, node: ast.expr, name: str) -> Node:
        start, stop = self._span(node)
        if name in self.names:
            return Node("name", name=name, text=name, place=start + 1)
        value = self.parameters.get(name, CONSTANTS.get(name))
        if value is not None:
            return Node("number", number=value, text=name, place=start + 1)
        if name in FUNCTIONS or name in DERIVATIVES:
            raise self._error(start, stop, "a function stands without its argument", f"write {name}(...)")
        if (slope := re.fullmatch(r"(\w+)_(x{1,3})", name)) and slope[1] in self.names and self.derivatives:
            raise self._error(start, stop, "there is an unknown name", f"write d{len(slope[2])}({slope[1]})")
        known = [*self.names, *self.parameters, *CONSTANTS]
        raise self._error(start, stop, "there is an unknown name", did_you_mean(name, known).rstrip("."))

    def _call(self, node: ast.Call, name: str, arguments: list[ast.expr]) -> Node:
        allowed = {**FUNCTIONS, **(dict.fromkeys(DERIVATIVES, 1) if self.derivatives else {})}
        start, _ = self._span(node)
        if name in DERIVATIVES and not self.derivatives:
            raise self._error(
                start, start + len(name), "a derivative in space stands where there is none", "write it out as a formula"
            )
        if name not in allowed:
            if name in self.names or name in self.parameters or name in CONSTANTS:
                raise self._error(
                    start, start + len(name), "a value is called like a function", f"write {name}*(...) for a product"
                )
            raise self._error(
                start, start + len(name), "there is an unknown function", did_you_mean(name, list(allowed)).rstrip(".")
            )
        if len(arguments) != allowed[name] or any(isinstance(argument, ast.Starred) for argument in arguments):
            count = f"{allowed[name]} argument{'s' * (allowed[name] > 1)}"
            raise self._error_at(node, f"{name} has {len(arguments)} arguments", f"give it {count}")
        parts = tuple(self._convert(argument) for argument in arguments)
        if name == "sqrt":
            return self._node(node, "power", parts, 0.5)
        return self._node(node, name, parts)

    def _power(self, node: ast.BinOp, base: Node, exponent: Node) -> Node:
        if exponent.kind != "number":
            cure = "an exponent is made of numbers and parameters"
            if base.kind == "number":
                cure = f"write exp(({exponent.text})*log({base.text}))"
            raise self._error_at(node.right, "the exponent is no constant", cure)
        if abs(exponent.number) > LARGEST_EXPONENT:
            raise self._error_at(
                node.right,
                f"the exponent {exponent.number:g} is too large",
                f"write one between -{LARGEST_EXPONENT} and {LARGEST_EXPONENT}",
            )
        return self._node(node, "power", (base,), exponent.number)
