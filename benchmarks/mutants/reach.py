"""Which tests reach which lines of the package, and how long each takes: a plugin of pytest that writes it down.

`pytest -p benchmarks.mutants.reach TESTS` with REACH_FOLDER set writes one JSON file for each file of tests. Lines of compiled
functions are seen by no tracer; those of their callers are.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections import defaultdict
from collections.abc import Generator, Iterator
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from coverage import Coverage

FOLDER = "REACH_FOLDER"
"""The variable of the environment that names where the records go."""

PACKAGE = "mol_compactons"


@dataclass(frozen=True)
class KnownTest:
    """A test that passes without a fault: its name, the seconds of processor time it took, and the lines of each file.

    Of one that starts processes of its own the lines that these reach are not known.
    """

    name: str
    seconds: float
    lines: dict[str, frozenset[int]] = field(repr=False)
    starts_processes: bool = False

    @property
    def file(self) -> str:
        """The file of tests that it stands in, relative to the root."""
        return self.name.partition("::")[0]


CHILD = 0.2
"""Seconds of processor time: what starts an interpreter takes more."""


def processor_times() -> tuple[float, float]:
    """The seconds that this process and its finished children have computed, each."""
    own, of_system, children, of_system_for_children, _ = os.times()
    return own + of_system, children + of_system_for_children


class Recorder:
    """Traces the package, one context for each test."""

    def __init__(self, folder: Path, root: Path) -> None:
        self.folder, self.root = folder, root
        self.coverage = Coverage(source_pkgs=[PACKAGE], data_file=None, config_file=False, messages=False)
        self.seconds: dict[str, tuple[float, float]] = {}
        self.passed: dict[str, bool] = {}

    def pytest_collection_finish(self) -> None:
        """Import what the first test would import, so that the lines of modules themselves belong to no test."""
        import_module(f"{PACKAGE}.cli.parser")

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, Any, Any]:
        """Give the test its context, and time it."""
        self.coverage.switch_context(item.nodeid)
        own, children = processor_times()
        result = yield
        own_later, children_later = processor_times()
        self.seconds[item.nodeid] = own_later - own, children_later - children
        return result

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """A test passes if its call does and nothing before or after it fails."""
        before = self.passed.get(report.nodeid, True)
        self.passed[report.nodeid] = before and report.passed

    def pytest_sessionfinish(self) -> None:
        """Write one file for each file of tests."""
        self.coverage.stop()
        lines = self.lines()
        files: dict[str, dict[str, object]] = defaultdict(dict)
        for name, (own, children) in self.seconds.items():
            tests = files[name.partition("::")[0]]
            if self.passed.get(name):
                reached = {file: sorted(numbers) for file, numbers in lines[name].items()}
                tests[name] = {"seconds": round(own + children, 3), "starts_processes": children > CHILD, "lines": reached}
        package = package_mark(self.root)
        for file, tests in files.items():
            record = {"package": package, "file": mark(self.root / file), "tests": tests}
            (self.folder / record_name(file)).write_text(json.dumps(record))

    def lines(self) -> dict[str, dict[str, list[int]]]:
        """For each test and each file of the package the lines that it reached."""
        data = self.coverage.get_data()
        found: dict[str, dict[str, list[int]]] = defaultdict(lambda: defaultdict(list))
        for path in data.measured_files():
            file = Path(path).relative_to(self.root).as_posix()
            for line, contexts in data.contexts_by_lineno(path).items():
                for name in contexts:
                    found[name][file].append(line)
        return found


def record_name(file: str) -> str:
    """The name of the record of a file of tests."""
    return file.replace("/", "__").removesuffix(".py") + ".json"


def mark(*paths: Path) -> str:
    """What changes when one of some files does."""
    digest = hashlib.sha256()
    for path in paths:
        digest.update(path.read_bytes())
    return digest.hexdigest()


def package_mark(root: Path) -> str:
    """What changes when any line of the package may have moved, or what is recorded has changed."""
    return mark(Path(__file__), *sorted((root / PACKAGE).rglob("*.py")))


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Begin to trace before the package is imported."""
    if folder := os.environ.get(FOLDER):
        recorder = Recorder(Path(folder), config.rootpath)
        recorder.coverage.start()
        config.pluginmanager.register(recorder)


def test_files(root: Path) -> list[str]:
    """All files that have tests, those with examples in docstrings too, relative to the root."""
    examples = (path for path in sorted((root / PACKAGE).rglob("*.py")) if ">>>" in path.read_text(encoding="utf-8"))
    return [path.relative_to(root).as_posix() for path in (*sorted((root / "tests").rglob("test_*.py")), *examples)]


def outdated(folder: Path, root: Path) -> list[str]:
    """The files of tests without a record, or with one of another text or another package."""
    package = package_mark(root)
    stale = []
    for file in test_files(root):
        path = folder / record_name(file)
        record = json.loads(path.read_text()) if path.is_file() else {}
        if (record.get("package"), record.get("file")) != (package, mark(root / file)):
            stale.append(file)
    return stale


def read(folder: Path, root: Path) -> Iterator[KnownTest]:
    """The tests of the records of all files of tests."""
    for file in test_files(root):
        path = folder / record_name(file)
        tests = json.loads(path.read_text())["tests"] if path.is_file() else {}
        for name, entry in tests.items():
            lines = {where: frozenset(numbers) for where, numbers in entry["lines"].items()}
            yield KnownTest(name, entry["seconds"], lines, entry["starts_processes"])
