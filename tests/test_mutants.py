from __future__ import annotations

import ast
import csv
import random
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.mutants import __main__ as command
from benchmarks.mutants.faults import Fault, by_line, find_faults
from benchmarks.mutants.reach import KnownTest
from benchmarks.mutants.trial import Verdict, Workshop, own_tests, refresh, within

ROOT = Path(__file__).parent.parent

SOURCES = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in (ROOT / "mol_compactons").rglob("*.py")
}

EXAMPLE = '''"""A module with 1 fault for each kind."""

TABLE = (1.0, 2.0)
LIMIT = 3.0


@compiled
def middle(values: Array, k: int) -> float:
    """Not 7."""
    for i in range(k):
        values[i] += 2.5
    return min(abs(values[0]), -values[k - 1])


def guarded(a: float, b: float, note: str = "a - b") -> bool:
    require(a > 1, f"{a - 1} must be more than 1.")
    if not a:
        raise ValueError("a < b")
    show(a, b, linewidth=2)
    return a <= b and "a" + note == "b"
'''


def changes(kind: str) -> set[tuple[str, str]]:
    """The places of a kind in the example, and what stands there instead."""
    raw = EXAMPLE.encode()
    return {(raw[fault.begin : fault.end].decode(), fault.text) for fault in find_faults(EXAMPLE) if fault.kind == kind}


def test_each_kind_of_fault_is_found_and_none_in_texts_types_and_tables() -> None:
    assert changes("a constant") == {("3.0", "6.0"), ("2.5", "5.0"), ("1", "2")}
    assert changes("an index") == {("0", "1"), ("i", "i + 1")}
    assert changes("an operator") == {("-", "+")}
    assert changes("a comparison") == {(">", ">="), (">", "<="), ("<=", "<"), ("<=", ">"), ("==", "!=")}
    assert changes("and for or") == {("and", "or")}
    assert changes("min for max") == {("min", "max")}
    assert changes("abs dropped") == {("abs", "")}
    assert changes("a condition turned") == {("not", "")}
    value = "min(abs(values[0]), -values[k - 1])"
    assert changes("a return of zero") == {(value, f"0 * ({value})")}
    assert changes("a factor of 2") == {(value, f"2 * ({value})")}
    assert changes("a sign") == {(value, f"-({value})"), ("-", "")}
    assert changes("arguments swapped") == {("a, b", "b, a")}
    assert changes("a statement dropped") == {("values[i] += 2.5", "pass"), ("show(a, b, linewidth=2)", "pass")}
    assert {text.split("(")[0].split()[0] for text, _ in changes("a guard dropped")} == {"require", "if"}


def test_a_fault_knows_when_it_acts() -> None:
    scopes = {fault.line(EXAMPLE): fault.scope for fault in find_faults(EXAMPLE)}
    assert scopes[4] == "module"
    assert {scopes[line] for line in (11, 12)} == {"compiled"}
    assert {scopes[line] for line in (16, 17, 19, 20)} == {"line"}


@given(st.sampled_from(sorted(file for file in SOURCES if find_faults(SOURCES[file]))), st.randoms(use_true_random=False))
def test_a_fault_changes_one_place_and_can_be_compiled(file: str, chance: random.Random) -> None:
    source = SOURCES[file]
    faults = find_faults(source)
    fault = chance.choice(faults)
    faulty = fault.put_into(source)
    compile(faulty, file, "exec")
    assert faulty.encode()[: fault.begin] == source.encode()[: fault.begin]
    assert faulty.encode()[fault.begin + len(fault.text.encode()) :] == source.encode()[fault.end :]
    assert ast.dump(ast.parse(faulty)) != ast.dump(ast.parse(source))


def test_the_seed_chooses() -> None:
    first, same, other = ([one.key for one in command.choose(ROOT, ["mol_compactons/waves"], 50, seed)] for seed in (1, 1, 2))
    assert first == same != other
    chosen = command.choose(ROOT, ["mol_compactons/grid", "mol_compactons/errors"], 20, 1)
    assert len({(one.file, one.line) for one in chosen}) == 20
    assert {one.file for one in chosen} == {"mol_compactons/grid.py", "mol_compactons/errors.py"}


def test_faults_of_lines_that_read_alike_are_told_apart() -> None:
    source = "def f(a: float, b: float) -> float:\n    if a > b:\n        return a - b\n    return a - b\n"
    found = [command.mutant("f.py", source, fault) for fault in find_faults(source) if fault.kind == "an operator"]
    assert [one.line for one in found] == [3, 4]
    assert len({one.key for one in found}) == len({one.key[:1] + one.key[2:] for one in found}) + 1


def test_what_differs_is_shown() -> None:
    source = "def f(a: float) -> float:\n    if a < 0:\n        raise ValueError\n    return a\n"
    shown = {
        one.fault.kind: one.difference() for one in (command.mutant("f.py", source, fault) for fault in find_faults(source))
    }
    assert shown["a return of zero"] == "- return a\n+ return 0 * (a)"
    assert shown["a constant"] == "- if a < 0:\n+ if a < 1:"
    assert shown["a guard dropped"] == "- if a < 0:\n  raise ValueError\n+ pass"


COUNTING = """def halves(n: int) -> int:
    count = 0
    while n > 1:
        n = n // 2
        count += 1
    return count


def twice(n: int) -> int:
    return n + n


def forgotten(n: int) -> int:
    return n
"""

TESTS_OF_COUNTING = """from mol_compactons.counting import halves, twice


def test_halves() -> None:
    assert halves(8) == 3


def test_twice() -> None:
    assert twice(8) > 0
"""


@pytest.fixture
def small_repository(tmp_path: Path) -> Path:
    """A package of one module, with a good test, a poor one, and none."""
    root = tmp_path / "repository"
    texts = {
        "pyproject.toml": "[tool.pytest.ini_options]\n",
        "mol_compactons/__init__.py": "",
        "mol_compactons/cli/__init__.py": "",
        "mol_compactons/cli/parser.py": "",
        "mol_compactons/counting.py": COUNTING,
        "tests/__init__.py": "",
        "tests/test_counting.py": TESTS_OF_COUNTING,
    }
    benchmarks = (ROOT / "benchmarks/__init__.py", *sorted((ROOT / "benchmarks/mutants").glob("*.*")))
    texts |= {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in benchmarks}
    for name, text in texts.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    return root


def test_good_tests_notice_and_poor_ones_do_not(small_repository: Path, tmp_path: Path) -> None:
    shop = Workshop(small_repository, tmp_path / "shop", tmp_path / "records")
    shop.prepare()
    file = "mol_compactons/counting.py"
    faults = [fault for fault in find_faults(COUNTING) if fault.kind == "a factor of 2"]
    noticed = Verdict("noticed", "tests/test_counting.py::test_halves")
    expected = [noticed, Verdict("survived"), Verdict("reached by no test")]
    assert [shop.try_out(file, fault, patience=10) for fault in faults] == expected
    assert [(root / file).read_text() for root in (shop.tree, small_repository)] == [COUNTING, COUNTING]
    assert [test.file for test in shop.tests] == ["tests/test_counting.py"] * 2
    assert Workshop(small_repository, shop.folder, shop.records, ["tests/test_c"]).tests == []


def test_tests_that_are_left_aside_need_not_be_known(small_repository: Path, tmp_path: Path) -> None:
    shop, hurried = (Workshop(small_repository, tmp_path, tmp_path / "records", without) for without in ((), ("tests/slow",)))
    (small_repository / "tests/slow").mkdir()
    (small_repository / "tests/slow/test_all.py").write_text("")
    refresh(small_repository, shop.tree)
    assert shop.unknown() == ["tests/slow/test_all.py", "tests/test_counting.py"]
    assert hurried.unknown() == ["tests/test_counting.py"]


def test_near_and_quick_tests_come_first(tmp_path: Path) -> None:
    lines = {"mol_compactons/a/b.py": frozenset({3, 7})}
    tests = [
        KnownTest("tests/c/test_d.py::far", 0.1, lines),
        KnownTest("tests/a/test_c.py::beside", 5.0, lines),
        KnownTest("tests/a/test_b.py::slow", 2.0, lines),
        KnownTest("tests/a/test_b.py::quick", 1.0, lines),
        KnownTest("tests/a/test_b.py::elsewhere", 0.0, {"mol_compactons/a/b.py": frozenset({4})}),
        KnownTest("tests/a/test_b.py::apart", 3.0, {}, starts_processes=True),
        KnownTest("tests/a/test_c.py::apart", 3.0, {}, starts_processes=True),
    ]
    shop = Workshop(tmp_path, tmp_path, tmp_path)
    shop.__dict__["tests"] = tests
    fault = Fault("a sign", 0, 1, "", (7, 8), "line")
    names = [[test.name.partition("::")[2] for test in stage] for stage in shop.stages("mol_compactons/a/b.py", fault, 60)]
    assert names == [["quick", "slow", "apart"], ["beside", "far"]]
    assert [test.seconds for test in within(6.0, tests)] == [0.1, 5.0, 2.0]
    assert own_tests("mol_compactons/a/b.py") == "tests/a/test_b.py"


def test_tests_that_cannot_be_recorded_are_named(small_repository: Path, tmp_path: Path) -> None:
    """Or all that they would notice would count as not noticed."""
    (small_repository / "tests/test_broken.py").write_text("import nothing_of_this_name\n")
    with pytest.raises(RuntimeError, match=r"tests/test_broken\.py, tests/test_counting\.py reach could not be recorded"):
        Workshop(small_repository, tmp_path / "shop", tmp_path / "records").prepare()


def test_a_copy_keeps_the_times_of_what_stays_the_same(tmp_path: Path) -> None:
    root, tree = tmp_path / "root", tmp_path / "tree"
    root.mkdir()
    for name in ("same", "other", "gone"):
        (root / name).write_text(name)
    refresh(root, tree)
    before = {path.name: path.stat().st_mtime_ns for path in tree.iterdir()}
    (root / "other").write_text("changed")
    (root / "gone").unlink()
    refresh(root, tree)
    assert {path.name: path.read_text() for path in tree.iterdir()} == {"same": "same", "other": "changed"}
    assert (tree / "same").stat().st_mtime_ns == before["same"]
    assert (tree / "other").stat().st_mtime_ns > before["other"]


def test_what_was_tried_is_not_tried_again_unless_it_survived(tmp_path: Path) -> None:
    first, second = command.choose(ROOT, ["mol_compactons/grid"], 2, 0)
    path = tmp_path / "outcomes.csv"
    ledger = command.Ledger(path, again=False)
    ledger.enter(first, Verdict("noticed", "tests/test_grid.py::test_it"), 1.0)
    ledger.enter(second, Verdict("survived"), 2.0)
    with path.open(newline="") as file:
        assert [row["outcome"] for row in csv.DictReader(file)] == ["noticed", "survived"]
    assert command.Ledger(path, again=False).verdict(second) == Verdict("survived")
    again = command.Ledger(path, again=True)
    assert (again.verdict(first), again.verdict(second)) == (Verdict("noticed", "tests/test_grid.py::test_it"), None)
    lines, share = command.summary([first, second], ledger)
    assert share == 0.5
    assert lines[-1] == "noticed: 50.0 % of 2"


def test_every_equivalent_stands_in_the_sources_as_it_is_named() -> None:
    """A reason that belongs to no fault any more has to go."""
    for file, before, after in command.reasons():
        source = SOURCES[file]
        known = [command.mutant(file, source, fault) for faults in by_line(source).values() for fault in faults]
        assert (before, after) in {(one.before, one.after) for one in known}, (file, before)


@pytest.mark.parametrize("size", ["<", "  # a < b\n  <", ") <"])
def test_an_operator_is_found_over_brackets_and_comments(size: str) -> None:
    opening = "(" if ")" in size else ""
    source = f"def f(a, b):\n    return ({opening}a{size} b)\n"
    (fault,) = [fault for fault in find_faults(source) if fault.text == ">="]
    assert fault.put_into(source) == source[::-1].replace("<", "=>", 1)[::-1]
