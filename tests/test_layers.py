"""The shape of the package: which room may know which, no circles inside a room, and a test file for each module."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGE = "mol_compactons"

LAYERS: tuple[tuple[str, ...], ...] = (
    ("errors",),
    ("open_set", "notebook"),
    ("configuration",),
    ("assignment", "runtime", "progress"),
    ("stencils", "grid", "expressions"),
    ("semidiscrete",),
    ("equations",),
    ("waves",),
    ("schemes",),
    ("chain",),
    ("integrators",),
    ("simulation",),
    ("stop_rules",),
    ("results",),
    ("course",),
    ("running",),
    ("analysis",),
    ("studies",),
    ("figures",),
    ("pages",),
    ("cli",),
    ("__init__", "__main__"),
)
"""The rooms, lowest first. A room knows itself and those of lower layers; two in one layer do not know each other."""

STRANGERS = {"integrators": ("equations", "waves", "schemes", "chain")}
"""Lower rooms that a room must not know all the same: an integrator knows the system that it solves, and no physics."""

NEED_NO_TEST = ("__init__", "__main__")


def modules() -> dict[str, Path]:
    """Every module of the package by its name below it: "grid", "schemes.base"; a room itself is "schemes.__init__"."""
    folder = ROOT / PACKAGE
    return {".".join(path.relative_to(folder).with_suffix("").parts): path for path in sorted(folder.rglob("*.py"))}


def only_for_types(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test) in ("TYPE_CHECKING", "typing.TYPE_CHECKING")


def statements(tree: ast.AST) -> Iterator[ast.AST]:
    """All nodes, inside functions too, but for what only a type checker imports."""
    for node in ast.iter_child_nodes(tree):
        if only_for_types(node):
            assert isinstance(node, ast.If)
            yield from (inner for other in node.orelse for inner in (other, *statements(other)))
        else:
            yield node
            yield from statements(node)


def imported(source: str, known: Mapping[str, object], name: str = "") -> set[str]:
    """The modules of the package that a source of a name below it imports."""
    found = []
    for node in statements(ast.parse(source)):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = [PACKAGE, *name.split(".")][: -node.level] if node.level else []
            start = ".".join([*above, *([node.module] if node.module else [])])
            found += [f"{start}.{alias.name}" for alias in node.names]
    return {module for full in found if (module := module_of(full, known)) is not None}


def module_of(full: str, known: Mapping[str, object]) -> str | None:
    """The module in which a dotted name is found; None for one of another package."""
    package, *parts = full.split(".")
    if package != PACKAGE:
        return None
    for length in range(len(parts), 0, -1):
        name = ".".join(parts[:length])
        if name in known:
            return name
        if f"{name}.__init__" in known:
            return f"{name}.__init__"
    return "__init__"


def arrows() -> dict[str, set[str]]:
    """What each module of the package imports of it."""
    known = modules()
    return {name: imported(path.read_text(encoding="utf-8"), known, name) for name, path in known.items()}


def room(module: str) -> str:
    return module.partition(".")[0]


def layer(name: str) -> int:
    return next(level for level, rooms in enumerate(LAYERS) if name in rooms)


def against_the_order(graph: Mapping[str, set[str]]) -> list[str]:
    """The arrows that lead upwards, sideways, or to a stranger."""
    return [
        f"{module} imports {other}"
        for module, others in graph.items()
        for other in sorted(others)
        if room(module) != room(other)
        and (layer(room(other)) >= layer(room(module)) or room(other) in STRANGERS.get(room(module), ()))
    ]


def circle(graph: Mapping[str, set[str]]) -> list[str]:
    """The modules of one circle, the first of which stands at its end again; empty where there is none."""
    finished: set[str] = set()

    def follow(module: str, path: list[str]) -> list[str]:
        if module in path:
            return [*path[path.index(module) :], module]
        if module in finished:
            return []
        for other in sorted(graph.get(module, ())):
            if found := follow(other, [*path, module]):
                return found
        finished.add(module)
        return []

    return next((found for module in sorted(graph) if (found := follow(module, []))), [])


def test_every_room_has_its_place() -> None:
    places = [name for rooms in LAYERS for name in rooms]
    assert sorted(places) == sorted({room(module) for module in modules()})


def test_no_arrow_leads_against_the_order() -> None:
    assert against_the_order(arrows()) == []


def test_there_is_no_circle_of_modules() -> None:
    assert circle(arrows()) == []


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("from mol_compactons.grid import Grid", {"grid"}),
        ("from mol_compactons.chain import kernels", {"chain.kernels"}),
        ("from mol_compactons.chain import PowerContact", {"chain.__init__"}),
        ("from mol_compactons import run", {"__init__"}),
        ("import mol_compactons.chain.kernels as k, numpy", {"chain.kernels"}),
        ("from . import kernels", {"chain.kernels"}),
        ("from ..grid import Grid", {"grid"}),
        ("def f():\n    from mol_compactons.grid import Grid", {"grid"}),
        ("class A:\n    def f(self):\n        with a:\n            import mol_compactons.grid", {"grid"}),
        (
            "if TYPE_CHECKING:\n    from mol_compactons.grid import Grid\nelse:\n    import mol_compactons.chain.kernels",
            {"chain.kernels"},
        ),
        ("from numpy import grid", set()),
    ],
)
def test_imports_are_seen_wherever_they_stand(source: str, expected: set[str]) -> None:
    known = dict.fromkeys(("__init__", "grid", "chain.__init__", "chain.kernels", "chain.law"))
    assert imported(source, known, "chain.law") == expected


def test_wrong_arrows_and_circles_are_found() -> None:
    upwards = {"schemes.base": {"analysis.drift"}, "analysis.drift": {"schemes.base"}}
    assert against_the_order(upwards) == ["schemes.base imports analysis.drift"]
    assert circle(upwards) == ["analysis.drift", "schemes.base", "analysis.drift"]
    assert against_the_order({"grid": {"stencils"}}) == ["grid imports stencils"]
    assert against_the_order({"integrators.base": {"equations.flux"}}) == ["integrators.base imports equations.flux"]
    inside = {"chain.law": {"chain.kernels"}, "chain.kernels": {"chain.chain"}, "chain.chain": {"chain.law"}}
    assert against_the_order(inside) == []
    assert len(circle(inside)) == 4
    line = {str(one): {str(other)} for one, other in pairwise(range(5))}
    assert circle(line) == []


def test_every_module_has_its_test_file() -> None:
    """mol_compactons/schemes/base.py has tests/schemes/test_base.py."""
    missing = []
    for module in modules():
        *folders, name = module.split(".")
        expected = Path("tests", *folders, f"test_{name}.py")
        if name not in NEED_NO_TEST and not (ROOT / expected).is_file():
            missing.append(str(expected))
    assert missing == []
