"""A copy of the package in which one fault after the other is tried by the tests that reach it, the nearest ones first."""

from __future__ import annotations

import ast
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from pathlib import Path

from benchmarks.mutants import chosen, reach
from benchmarks.mutants.faults import Fault
from benchmarks.mutants.reach import PACKAGE, KnownTest

SKIPPED = shutil.ignore_patterns(".git", ".venv", "__pycache__", ".*_cache", ".hypothesis", "*.egg-info", "benchmark_results")

NO_TESTS = 5
"""What pytest returns if there was nothing to run."""

COMPILATION = 150
"""Seconds of processor time that compiling all kernels may take."""

MEMORY = 8 * 2**30
"""Bytes that a run of tests may ask for."""


@dataclass(frozen=True)
class Verdict:
    """What became of a fault, and the test that noticed it."""

    outcome: str
    test: str = ""

    @property
    def noticed(self) -> bool:
        """Whether any test failed, or did not come to an end."""
        return self.outcome in ("noticed", "endless")


class Workshop:
    """A copy of the repository with its own compiled kernels, and the records of which test reaches what.

    Parameters
    ----------
    root : Path
        The repository; it is not touched.
    folder : Path
        Where the copy and the kernels are, and stay for the next time.
    records : Path
        Where the records are.
    without : sequence of str
        Tests in files whose path begins so are left aside.
    """

    def __init__(self, root: Path, folder: Path, records: Path, without: Sequence[str] = ()) -> None:
        self.root, self.folder, self.records, self.without = root, folder, records, tuple(without)
        self.tree, self.kernels = folder / "tree", folder / "kernels"

    def prepare(self) -> None:
        """Bring the copy up to date, and record what tests reach that are new or no longer the same."""
        refresh(self.root, self.tree)
        for path in (self.records, self.kernels):
            path.mkdir(parents=True, exist_ok=True)
        rooms: dict[str, list[str]] = {}
        for file in self.unknown():
            rooms.setdefault(str(Path(file).parent), []).append(file)
        for room, files in rooms.items():
            print(f"recording what the tests in {room} reach", flush=True)
            _, printed = self.pytest(files, self.kernels, {reach.FOLDER: str(self.records)})
            if missing := sorted(set(files) & set(self.unknown())):
                raise RuntimeError(f"What {', '.join(missing)} reach could not be recorded:\n{printed}")

    def unknown(self) -> list[str]:
        """The files of tests of which it is not known what they reach, but for those that are left aside."""
        return [file for file in reach.outdated(self.records, self.tree) if not file.startswith(self.without)]

    @cached_property
    def tests(self) -> list[KnownTest]:
        """All tests that pass without a fault and are not left aside."""
        return [test for test in reach.read(self.records, self.tree) if not test.file.startswith(self.without)]

    def pytest(
        self, arguments: Sequence[str], kernels: Path, more: dict[str, str], seconds: float | None = None
    ) -> tuple[int, str]:
        """Run pytest in the copy, with at most that many seconds of processor time; its exit status and what it printed."""
        plugin = "benchmarks.mutants.chosen" if chosen.CHOICE in more else "benchmarks.mutants.reach"
        options = [
            "-p",
            plugin,
            "-p",
            "no:cacheprovider",
            "-q",
            "--no-header",
            "--tb=no",
            f"--basetemp={self.folder / 'temporary'}",
        ]
        environment = {
            **os.environ,
            "PYTHONPATH": str(self.tree),
            "NUMBA_CACHE_DIR": str(kernels),
            "MPLBACKEND": "Agg",
            **more,
        }
        environment |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
        log = self.folder / "output.txt"
        with log.open("w") as output:
            process = subprocess.Popen(
                [sys.executable, "-m", "pytest", *options, *arguments],
                cwd=self.tree,
                env=environment,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                preexec_fn=None if seconds is None else lambda: limit(seconds),
            )
            status = wait(process, None if seconds is None else 4 * seconds)
        return status, log.read_text(errors="replace")

    def try_out(self, file: str, fault: Fault, patience: float) -> Verdict:
        """Put a fault into the copy, run the tests that reach it, and take it out again.

        Parameters
        ----------
        file : str
            The file, relative to the root.
        fault : Fault
            The fault.
        patience : float
            No test begins after those before it took this many seconds of processor time without a fault.
        """
        path = self.tree / file
        source, times = path.read_text(encoding="utf-8"), path.stat()
        stages = [stage for stage in self.stages(file, fault, patience) if stage]
        if not stages:
            return Verdict("reached by no test")
        kernels = self.kernels_without(file) if must_compile(source, fault) else self.kernels
        try:
            path.write_text(fault.put_into(source), encoding="utf-8")
            forget_bytecode(path)
            return self.verdict(stages, kernels)
        finally:
            path.write_text(source, encoding="utf-8")
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
            forget_bytecode(path)
            if kernels != self.kernels:
                shutil.rmtree(kernels)

    def verdict(self, stages: Sequence[Sequence[KnownTest]], kernels: Path) -> Verdict:
        """Run some tests, and then others if none of them fails."""
        choice = self.folder / "choice.json"
        for tests in stages:
            choice.write_text(json.dumps([test.name for test in tests]))
            seconds = 60 + 5 * sum(test.seconds for test in tests) + COMPILATION * (kernels != self.kernels)
            files = list(dict.fromkeys(test.file for test in tests))
            status, printed = self.pytest(["-x", *files], kernels, {chosen.CHOICE: str(choice)}, seconds)
            if status in (-signal.SIGKILL, -signal.SIGXCPU):
                return Verdict("endless")
            if status not in (0, NO_TESTS):
                return Verdict("noticed", first_failure(printed))
        return Verdict("survived")

    def stages(self, file: str, fault: Fault, patience: float) -> Iterator[list[KnownTest]]:
        """The tests that reach a fault: first those of the module's own file, then those nearby, each the quickest first."""
        own = own_tests(file)
        near = [test for test in self.tests if self.reaches(test, file, fault)]
        yield within(patience, sorted((test for test in near if test.file == own), key=lambda test: test.seconds))
        others = [test for test in near if test.file != own]
        room = str(Path(own).parent)
        yield within(patience, sorted(others, key=lambda test: (str(Path(test.file).parent) != room, test.seconds)))

    def reaches(self, test: KnownTest, file: str, fault: Fault) -> bool:
        """Whether a test runs the line of a fault; of a line that no tracer sees, whether it runs the modules that use it.

        What runs in processes of their own is seen by no tracer either: such a test is counted for its own module.
        """
        if test.starts_processes and test.file == own_tests(file):
            return True
        if fault.scope == "line":
            first, last = fault.lines
            return not test.lines.get(file, frozenset()).isdisjoint(range(first, last + 1))
        files = {file, *self.users(file)} if fault.scope == "compiled" else {file}
        return test.file == own_tests(file) or any(name in test.lines for name in files)

    def users(self, file: str) -> Collection[str]:
        """The modules that import a module."""
        name = module_name(file)
        return [other for other, names in self.imports.items() if name in names]

    def dependents(self, file: str) -> set[str]:
        """The modules that import a module, or one that imports it, and so on; and the module."""
        found: set[str] = set()
        waiting = [file]
        while waiting:
            one = waiting.pop()
            if one not in found:
                found.add(one)
                waiting += self.users(one)
        return found

    @cached_property
    def sources(self) -> dict[str, str]:
        """The sources of the package, each by its file relative to the root."""
        paths = sorted((self.tree / PACKAGE).rglob("*.py"))
        return {path.relative_to(self.tree).as_posix(): path.read_text(encoding="utf-8") for path in paths}

    @cached_property
    def imports(self) -> dict[str, set[str]]:
        """What each file of the package imports."""
        return {file: imports(source) for file, source in self.sources.items()}

    def kernels_without(self, file: str) -> Path:
        """A copy of the compiled kernels without those that may have a part of this module compiled into them.

        An entry on the disk is outdated when its own file changes, but not when one does whose functions it contains.
        """
        folder = self.folder / "kernels_of_one_fault"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.kernels, folder)
        for dependent in self.dependents(file):
            for path in folder.glob(f"{Path(dependent).parent.name}_*/{Path(dependent).stem}.*"):
                path.unlink()
        return folder


def refresh(root: Path, tree: Path) -> None:
    """Make a copy the same as the repository, and leave files alone that are the same: compiled kernels know the times."""
    fresh = tree.with_name("fresh")
    shutil.rmtree(fresh, ignore_errors=True)
    shutil.copytree(root, fresh, ignore=SKIPPED)
    wanted = {path.relative_to(fresh) for path in fresh.rglob("*") if path.is_file()}
    for path in [path for path in tree.rglob("*") if path.is_file()]:
        if path.relative_to(tree) not in wanted:
            path.unlink()
    for name in wanted:
        if not (tree / name).is_file() or (tree / name).read_bytes() != (fresh / name).read_bytes():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(fresh / name, tree / name)
    shutil.rmtree(fresh)


def limit(seconds: float) -> None:
    """Let a process compute for so long, for the time on the clock would depend on what else runs, and not fill the memory."""
    whole = int(seconds) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (whole, whole))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def wait(process: subprocess.Popen[bytes], seconds: float | None) -> int:
    """The exit status; negative if the process was ended, because it computed or waited for too long."""
    try:
        return process.wait(seconds)
    except subprocess.TimeoutExpired:
        return -signal.SIGKILL
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def forget_bytecode(path: Path) -> None:
    """Remove what Python has compiled: it knows a source by its size and second, and a fault may change neither."""
    for compiled in (path.parent / "__pycache__").glob(f"{path.stem}.*.pyc"):
        compiled.unlink()


def must_compile(source: str, fault: Fault) -> bool:
    """Whether compiled kernels may contain what the fault changes, or are known by the time of its file."""
    return fault.scope != "line" or "@compiled" in source


def own_tests(file: str) -> str:
    """The file of tests that a module has: mol_compactons/a/b.py has tests/a/test_b.py."""
    path = Path("tests", *Path(file).parts[1:])
    return path.with_name(f"test_{path.name}").as_posix()


def within(patience: float, tests: Sequence[KnownTest]) -> list[KnownTest]:
    """The tests that begin before a time is over."""
    begins = accumulate((test.seconds for test in tests), initial=0.0)
    return [test for test, begin in zip(tests, begins, strict=False) if begin < patience]


def first_failure(printed: str) -> str:
    """The name of the test that failed, from the summary; the last line if it cannot be found."""
    found = re.search(r"^(?:FAILED|ERROR) (\S+)", printed, re.MULTILINE)
    return found.group(1) if found else (printed.strip().splitlines() or [""])[-1]


def module_name(file: str) -> str:
    """The name by which a file is imported."""
    return ".".join(Path(file).with_suffix("").parts).removesuffix(".__init__")


def imports(source: str) -> set[str]:
    """The names that a source imports, with and without their last part."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names
