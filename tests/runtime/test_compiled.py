from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import njit

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
    """Numba says so with a RuntimeError when the function is decorated."""
    asked: list[dict[str, Any]] = []

    def without_cache(**options: Any) -> Any:
        asked.append(options)
        if options.get("cache"):
            raise RuntimeError("cannot cache function: no locator available")
        return lambda function: function

    monkeypatch.setattr(module, "njit", without_cache)
    assert compiled(abs) is abs
    assert asked == [{"cache": True, "error_model": "numpy"}, {"error_model": "numpy"}]


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
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}

    def printed() -> list[str]:
        command = [sys.executable, "-c", PROGRAM]
        return subprocess.run(command, capture_output=True, text=True, env=environment, check=True).stdout.split("\n")[:-1]

    numbers = "[2.0, 2.0, 2.0, 2.0]"
    assert printed() == ["compiling", numbers]
    assert printed() == [numbers]
