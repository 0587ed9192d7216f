"""All single faults that may be put into a source, each as one place of its text and what stands there instead.

Left alone are types, texts and what is told to the user, tables of constants, and what only decorates a figure: no test has to
know them. The rest of the text stays as it is.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

Scope = Literal["line", "compiled", "module"]

OPERATORS: dict[type[ast.operator], tuple[str, str]] = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.FloorDiv: ("//", "*"),
    ast.Mod: ("%", "*"),
    ast.Pow: ("**", "*"),
}

COMPARISONS: dict[type[ast.cmpop], tuple[str, tuple[str, ...]]] = {
    ast.Lt: ("<", ("<=", ">=")),
    ast.LtE: ("<=", ("<", ">")),
    ast.Gt: (">", (">=", "<=")),
    ast.GtE: (">=", (">", "<")),
    ast.Eq: ("==", ("!=",)),
    ast.NotEq: ("!=", ("==",)),
}

PARTNERS = {"min": "max", "minimum": "maximum", "argmin": "argmax", "any": "all", "floor": "ceil", "sin": "cos"}
PARTNERS |= {right: left for left, right in PARTNERS.items()}

SIZES = ("abs", "fabs", "absolute")

ANY_ORDER = (
    *PARTNERS,
    "hypot",
    "isclose",
    "allclose",
    "isinstance",
    "issubclass",
    "getattr",
    "hasattr",
    "cast",
    "TypeVar",
    "print",
)
"""Functions for whose arguments the order says nothing, or is seen by any reader at once."""

DECORATION = (
    *("linewidth", "linewidths", "alpha", "figsize", "dpi", "fontsize", "zorder", "markersize", "rotation", "aspect", "ncols"),
    *("help", "metavar", "description", "epilog", "stacklevel"),
)
"""Keyword arguments that only decorate."""

NUMBERS = ("float", "int", "complex", "Array", "NDArray")


@dataclass(frozen=True)
class Fault:
    """One fault: the bytes from `begin` to `end` of the source are replaced by `text`.

    `lines` are those of the statement that it stands in. The scope tells where it acts: when this line runs, in a function
    that is compiled, or when the module is imported.
    """

    kind: str
    begin: int
    end: int
    text: str
    lines: tuple[int, int]
    scope: Scope

    def put_into(self, source: str) -> str:
        """The source with this fault."""
        raw = source.encode()
        return (raw[: self.begin] + self.text.encode() + raw[self.end :]).decode()

    def line(self, source: str) -> int:
        """The number of the line, from 1, in which the place begins."""
        return source.encode().count(b"\n", 0, self.begin) + 1


def find_faults(source: str) -> list[Fault]:
    """All faults of a source, in the order of their places."""
    finder = _Finder(source)
    finder.visit(ast.parse(source))
    return sorted(finder.faults, key=lambda fault: (fault.begin, fault.end, fault.text))


def by_line(source: str) -> dict[int, list[Fault]]:
    """The faults of a source, by the number of the line in which they begin."""
    found: dict[int, list[Fault]] = {}
    for fault in find_faults(source):
        found.setdefault(fault.line(source), []).append(fault)
    return found


class _Finder(ast.NodeVisitor):
    """Walks over a module, and notes the faults."""

    def __init__(self, source: str) -> None:
        self.raw = source.encode()
        self.starts = [0, *(place + 1 for place, byte in enumerate(self.raw) if byte == ord("\n"))]
        self.faults: list[Fault] = []
        self.functions: list[ast.FunctionDef] = []
        self.statements: list[ast.stmt] = []
        self.counters: set[str] = set()

    # Where things stand.

    def begin(self, node: ast.expr | ast.stmt) -> int:
        return self.starts[node.lineno - 1] + node.col_offset

    def end(self, node: ast.expr | ast.stmt) -> int:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return self.starts[node.end_lineno - 1] + node.end_col_offset

    def text(self, node: ast.expr | ast.stmt) -> str:
        return self.raw[self.begin(node) : self.end(node)].decode()

    def scope(self) -> Scope:
        if not self.functions:
            return "module"
        return "compiled" if any(name_of(item) == "compiled" for item in self.functions[-1].decorator_list) else "line"

    def note(self, kind: str, begin: int, end: int, text: str) -> None:
        self.faults.append(Fault(kind, begin, end, text, header(self.statements[-1]), self.scope()))

    def around(self, kind: str, node: ast.expr, before: str, after: str = ")") -> None:
        self.note(kind, self.begin(node), self.end(node), f"{before}{self.text(node)}{after}")

    def between(self, kind: str, left: ast.expr, right: ast.expr, old: str, new: str) -> None:
        """Replace the operator between two operands, over brackets and comments."""
        place, last = self.end(left), self.begin(right)
        while place < last:
            if self.raw[place : place + 1] == b"#":
                place = self.raw.index(b"\n", place)
            if self.raw.startswith(old.encode(), place):
                self.note(kind, place, place + len(old), new)
                return
            place += 1

    # Statements.

    def visit(self, node: ast.AST) -> None:
        """Go on below a node, and keep in mind the statement."""
        if not isinstance(node, ast.stmt):
            super().visit(node)
            return
        if left_alone(node) or (not self.functions and is_table(node)):
            return
        self.statements.append(node)
        if droppable(node):
            kind = "a guard dropped" if is_guard(node) else "a statement dropped"
            self.note(kind, self.begin(node), self.end(node), "pass")
        super().visit(node)
        self.statements.pop()

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        for default in (*node.args.defaults, *(one for one in node.args.kw_defaults if one is not None)):
            self.visit(default)
        self.functions.append(node)
        for statement in node.body:
            self.visit(statement)
        self.functions.pop()

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        for statement in node.body:
            self.visit(statement)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_If(self, node: ast.If) -> None:
        if isinstance(node.body[-1], ast.Raise) and not node.orelse:
            self.note("a guard dropped", self.begin(node), self.end(node), "pass")
        self.generic_visit(node)

    def visit_For(self, node: ast.For) -> None:
        if isinstance(node.iter, ast.Call) and name_of(node.iter.func) in ("range", "enumerate"):
            first = node.target.elts[0] if isinstance(node.target, ast.Tuple) else node.target
            if isinstance(first, ast.Name):
                self.counters.add(first.id)
        self.generic_visit(node)

    def visit_Return(self, node: ast.Return) -> None:
        if node.value is None:
            return
        if self.functions and is_number(self.functions[-1].returns):
            self.around("a return of zero", node.value, "0 * (")
            self.around("a factor of 2", node.value, "2 * (")
            self.around("a sign", node.value, "-(")
        self.visit(node.value)

    # Expressions.

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Texts stay."""

    def visit_Constant(self, node: ast.Constant) -> None:
        self.note_constant("a constant", node)

    def note_constant(self, kind: str, node: ast.Constant) -> None:
        match node.value:
            case bool():
                self.note(kind, self.begin(node), self.end(node), str(not node.value))
            case int():
                self.note(kind, self.begin(node), self.end(node), str(node.value + 1))
            case float():
                self.note(kind, self.begin(node), self.end(node), repr(2 * node.value or 1.0))

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if type(node.op) in OPERATORS and not (is_text(node.left) or is_text(node.right)):
            self.between("an operator", node.left, node.right, *OPERATORS[type(node.op)])
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        match node.op:
            case ast.USub():
                self.note("a sign", self.begin(node), self.begin(node) + 1, "")
            case ast.Not():
                self.note("a condition turned", self.begin(node), self.begin(node) + len("not"), "")
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        old, new = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
        for left, right in pairwise(node.values):
            self.between("and for or", left, right, old, new)
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        for left, operator, right in zip((node.left, *node.comparators), node.ops, node.comparators, strict=False):
            if type(operator) in COMPARISONS:
                old, others = COMPARISONS[type(operator)]
                for new in others:
                    self.between("a comparison", left, right, old, new)
        self.generic_visit(node)

    def visit_Subscript(self, node: ast.Subscript) -> None:
        if name_of(node.value) in ("Literal", "Annotated", "NDArray"):
            return
        self.visit(node.value)
        for index in indices(node.slice):
            if isinstance(index, ast.Constant):
                self.note_constant("an index", index)
            elif isinstance(index, ast.Name) and index.id in self.counters:
                self.around("an index", index, "", " + 1")
            else:
                self.visit(index)

    def visit_Call(self, node: ast.Call) -> None:
        name = name_of(node.func)
        if name in PARTNERS:
            self.note("min for max", self.end(node.func) - len(name), self.end(node.func), PARTNERS[name])
        if name in SIZES and len(node.args) == 1:
            self.note("abs dropped", self.begin(node.func), self.end(node.func), "")
        if name not in ANY_ORDER:
            for left, right in swappable(node.args):
                between = self.raw[self.end(left) : self.begin(right)].decode()
                swapped = f"{self.text(right)}{between}{self.text(left)}"
                self.note("arguments swapped", self.begin(left), self.end(right), swapped)
        self.visit(node.func)
        for argument in arguments_to_visit(node, name):
            self.visit(argument)


def name_of(node: ast.expr) -> str:
    """The last part of a name with dots; of a decorator that is called, that of what is called."""
    match node:
        case ast.Name():
            return node.id
        case ast.Attribute():
            return node.attr
        case ast.Call():
            return name_of(node.func)
    return ""


def header(statement: ast.stmt) -> tuple[int, int]:
    """The first and the last line of a statement without those that stand in its body."""
    body = getattr(statement, "body", None)
    last = max(body[0].lineno - 1, statement.lineno) if body else (statement.end_lineno or statement.lineno)
    return statement.lineno, last


def left_alone(node: ast.stmt) -> bool:
    """Whether a statement is only for readers, types or errors."""
    match node:
        case ast.Expr(value=ast.Constant()) | ast.Raise() | ast.Assert() | ast.Import() | ast.ImportFrom():
            return True
        case ast.If():
            return any(name in ast.unparse(node.test) for name in ("TYPE_CHECKING", "__name__"))
    return False


def is_table(node: ast.stmt) -> bool:
    """Whether an assignment names several constants at once, or types."""
    if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
        return False
    return any(isinstance(inner, ast.Tuple | ast.List | ast.Dict | ast.Set | ast.BitOr) for inner in ast.walk(node.value))


def droppable(node: ast.stmt) -> bool:
    """Whether a statement acts by what it does and not by a name that later ones need."""
    match node:
        case ast.Expr(value=ast.Call()) | ast.AugAssign():
            return True
        case ast.Assign(targets=[ast.Attribute() | ast.Subscript()]):
            return True
    return False


def is_guard(node: ast.stmt) -> bool:
    """Whether a statement refuses what must not be."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Call) and refuses(node.value)


def refuses(node: ast.Call) -> bool:
    """Whether a call tells what is wrong."""
    name = name_of(node.func).lstrip("_")
    return name.startswith(("require", "check", "refuse")) or name in ("warn", "InputError")


def is_number(annotation: ast.expr | None) -> bool:
    """Whether a function gives a number or an array of them."""
    match annotation:
        case ast.Name() | ast.Attribute():
            return name_of(annotation) in NUMBERS
        case ast.Subscript():
            return name_of(annotation.value) in NUMBERS
    return False


def is_text(node: ast.expr) -> bool:
    """Whether an operand is a text or a list, which no sign suits."""
    match node:
        case ast.BinOp():
            return is_text(node.left) or is_text(node.right)
        case ast.Constant():
            return isinstance(node.value, str | bytes)
    return isinstance(node, ast.JoinedStr | ast.List | ast.ListComp | ast.Dict | ast.Set)


def indices(node: ast.expr) -> Iterator[ast.expr]:
    """The parts of what stands between the square brackets."""
    match node:
        case ast.Tuple():
            for element in node.elts:
                yield from indices(element)
        case ast.Slice():
            yield from (part for part in (node.lower, node.upper, node.step) if part is not None)
        case _:
            yield node


def swappable(arguments: Sequence[ast.expr]) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Neighbours among the arguments that differ and are no texts."""
    for left, right in pairwise(arguments):
        fixed = any(isinstance(one, ast.Starred) or is_text(one) for one in (left, right))
        if not fixed and ast.dump(left) != ast.dump(right):
            yield left, right


def arguments_to_visit(node: ast.Call, name: str) -> Iterator[ast.expr]:
    """The arguments of a call in which faults are looked for: not in messages and types, nor in what only decorates."""
    told = refuses(node)
    first = 1 if name in ("cast", "TypeVar") else 0
    yield from node.args[first : 1 if told else None]
    yield from (item.value for item in node.keywords if item.arg not in DECORATION and not told)
