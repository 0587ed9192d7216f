"""What a run leaves that is killed at the worst moments, and what becomes of it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent

COMPILER = shutil.which("cc") or shutil.which("gcc")

pytestmark = pytest.mark.skipif(
    COMPILER is None or sys.platform != "linux",
    reason="faults are put under the program by a library, for which a C compiler is needed",
)


@pytest.fixture(scope="module")
def faults(tmp_path_factory: pytest.TempPathFactory) -> Path:
    library = tmp_path_factory.mktemp("faults") / "faults.so"
    assert COMPILER
    source = Path(__file__).parent / "faults.c"
    subprocess.run([COMPILER, "-shared", "-fPIC", "-Wall", "-Werror", "-o", str(library), str(source), "-ldl"], check=True)
    return library


def outcomes(faults: Path, folder: Path, stride: int, *names: str) -> dict[str, dict[str, object]]:
    command = [sys.executable, "-m", "tests.survival.driver", str(folder), str(stride), *names]
    environment = os.environ | {"LD_PRELOAD": str(faults)}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=ROOT, check=False)
    assert done.returncode == 0, done.stderr
    found = [json.loads(line) for line in done.stdout.splitlines()]
    return {one["name"]: one for one in found}


@pytest.mark.parametrize(
    ("name", "stride"),
    [
        pytest.param("Midpoint", 31, marks=pytest.mark.slow),
        ("Symplectic", 29),
        pytest.param("IDA", 17, marks=pytest.mark.slow),
    ],
)
def test_a_kill_at_a_write_loses_no_frame_that_was_safe(name: str, stride: int, faults: Path, tmp_path: Path) -> None:
    """SIGKILL before, in the middle of and after calls that change files: what is left opens, and goes on to the right end."""
    found = outcomes(faults, tmp_path, stride, name)[name]
    assert found["faults"] == []
    assert int(str(found["calls"])) > 60
    assert int(str(found["trials"])) > 8


NAMES = ["Midpoint", "Symplectic", "Rosenbrock", "GaussLegendre", "IDA", "CVODE"]


@pytest.mark.slow
def test_random_kills_lose_no_frame_that_was_safe(faults: Path, tmp_path: Path) -> None:
    found = outcomes(faults, tmp_path, 0, *NAMES)
    assert [found[name]["faults"] for name in NAMES] == [[]] * len(NAMES)
    assert sum(int(str(one["trials"])) for one in found.values()) >= 40


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_kill_at_any_write_loses_no_frame_that_was_safe(name: str, faults: Path, tmp_path: Path) -> None:
    assert outcomes(faults, tmp_path, 1, name)[name]["faults"] == []
