from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import njit
from numba.core import config
from numba.core.caching import FunctionCache

from mol_compactons.runtime import compiled as module
from mol_compactons.runtime.compiled import announcing_compilation, compiled
from tests.systems import Array


def test_a_compiled_function_does_what_it_did() -> None:
    def plain(values: Array) -> float:
        total = 0.0
        for k in range(values.size):
            total += values[k] ** 2 / (k + 1)
        return total

    values = np.linspace(-1, 2, 7)
    assert compiled(plain)(values) == pytest.approx(plain(values), rel=1e-14)
    assert getattr(compiled(plain), "py_func", None) is plain


def test_division_by_zero_follows_numpy_and_not_python() -> None:
    def ratio(a: float, b: float) -> float:
        return a / b

    with pytest.raises(ZeroDivisionError):
        ratio(1.0, 0.0)
    assert compiled(ratio)(1.0, 0.0) == np.inf
    assert np.isnan(compiled(ratio)(0.0, 0.0))


def test_where_no_folder_can_be_written_it_compiles_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """Numba says so with a RuntimeError, when it looks for one."""

    def refuse(function: Any) -> Any:
        raise RuntimeError("cannot cache function: no locator available")

    def twice(x: float) -> float:
        return 2 * x

    monkeypatch.setattr(module, "_Cache", refuse)
    assert compiled(twice)(1.5) == 3.0


def test_without_a_compiler_a_function_stays_what_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    def twice(x: float) -> float:
        return 2 * x

    monkeypatch.setattr(config, "DISABLE_JIT", 1)
    assert compiled(twice) is twice


KERNEL = """
from mol_compactons.runtime.compiled import compiled

@compiled
def kernel(x):
    return 3.0 * x + 1.0
"""


class Cached:
    """A module with one kernel, loaded as in a new process, and the cache of it."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.cache, self._source = folder / "cache", folder / "kernels_of_a_test.py"
        self._source.write_text(KERNEL)
        monkeypatch.setattr(config, "CACHE_DIR", str(self.cache))

    def load(self) -> Any:
        specification = importlib.util.spec_from_file_location("kernels_of_a_test", self._source)
        assert specification is not None
        assert specification.loader is not None
        loaded = importlib.util.module_from_spec(specification)
        specification.loader.exec_module(loaded)
        return loaded.kernel

    def compiles(self) -> bool:
        """Whether the kernel must be compiled; it is right in any case."""
        said: list[bool] = []
        with announcing_compilation(lambda: said.append(True)):
            assert self.load()(2.0) == 7.0
        return bool(said)

    def file(self, suffix: str) -> Path:
        (found,) = self.cache.rglob(f"*{suffix}")
        return found


@pytest.fixture
def cached(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Cached:
    return Cached(tmp_path, monkeypatch)


def noisy(content: bytes) -> bytes:
    return np.random.default_rng(0).bytes(len(content))


def flipped(content: bytes) -> bytes:
    """Some bit in the middle is wrong: what an unpickler takes, and a processor too."""
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 4]) + content[middle + 1 :]


DAMAGES: tuple[Callable[[bytes], bytes], ...] = (
    lambda content: b"",
    lambda content: content[: len(content) // 2],
    lambda content: content[:-1],
    noisy,
    flipped,
    lambda content: content[:-32],
    lambda content: b"cos\nsystem\n(S'exit 3'\ntR.",
)


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
def test_a_damaged_cache_is_compiled_anew_and_mended(suffix: str, cached: Cached) -> None:
    assert (cached.compiles(), cached.compiles()) == (True, False)
    content = cached.file(suffix).read_bytes()
    for damage in DAMAGES:
        cached.file(suffix).write_bytes(damage(content))
        assert (cached.compiles(), cached.compiles()) == (True, False)


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
def test_a_folder_in_the_place_of_a_file_is_done_without(suffix: str, cached: Cached) -> None:
    assert cached.compiles()
    place = cached.file(suffix)
    place.unlink()
    place.mkdir()
    assert (cached.compiles(), cached.compiles()) == (True, True)
    assert list(cached.cache.rglob("*.tmp.*")) == []


def test_a_cache_whose_folder_becomes_a_file_is_done_without(cached: Cached) -> None:
    assert cached.compiles()
    kernel = cached.load()
    (folder,) = cached.cache.iterdir()
    shutil.rmtree(folder)
    folder.write_text("no folder")
    assert kernel(2.0) == 7.0
    assert cached.compiles()


def test_a_change_of_the_source_compiles_anew(cached: Cached) -> None:
    assert cached.compiles()
    cached._source.write_text(KERNEL + "\n")
    assert (cached.compiles(), cached.compiles()) == (True, False)


def test_numba_reads_what_is_kept_here(cached: Cached, monkeypatch: pytest.MonkeyPatch) -> None:
    """An earlier version, or another program with the same folder, is not disturbed."""
    assert cached.compiles()
    monkeypatch.setattr(module, "_Cache", FunctionCache)
    assert not cached.compiles()


def test_it_is_said_once_that_something_compiles_and_never_again() -> None:
    """A function of this test is in no cache before, and in memory afterwards."""
    said: list[str] = []

    def one(x: float) -> float:
        return x + 1.0

    def two(x: float) -> float:
        return x + 2.0

    first: Any = njit(one)
    second: Any = njit(two)
    with announcing_compilation(lambda: said.append("first")):
        assert (first(1.0), second(1.0)) == (2.0, 3.0)
    assert said == ["first"]
    with announcing_compilation(lambda: said.append("again")):
        assert first(2.0) == 3.0
    assert said == ["first"]


PROGRAM = """
import numpy as np
from mol_compactons.runtime.compiled import announcing_compilation
from mol_compactons.stencils import SECOND_NEAREST
with announcing_compilation(lambda: print("compiling")):
    print(SECOND_NEAREST.apply(np.array([0.0, 1.0, 4.0, 9.0, 16.0, 25.0]), 1.0)[1:-1].tolist())
"""


def test_the_machine_code_is_kept_for_the_next_process(tmp_path: Path) -> None:
    """Where its files are damaged, and none may grow, as on a full disk, all is as without a cache."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}

    def printed(first: str = "") -> list[str]:
        command = [sys.executable, "-c", first + PROGRAM]
        return subprocess.run(command, capture_output=True, text=True, env=environment, check=True).stdout.split("\n")[:-1]

    numbers = "[2.0, 2.0, 2.0, 2.0]"
    assert printed() == ["compiling", numbers]
    assert printed() == [numbers]
    files = sorted(tmp_path.rglob("*.nb?"))
    for path, damage in zip(files, DAMAGES, strict=False):
        path.write_bytes(damage(path.read_bytes()))
    assert printed("import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))") == ["compiling", numbers]
    assert sorted(path for path in tmp_path.rglob("*") if path.is_file()) == files
