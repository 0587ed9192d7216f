"""No `__init__.py` stands here: these tests import `own_physics` as a user does, by its own name, not as a part of `tests`."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import pytest

HERE = Path(__file__).parent

Fresh = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture(scope="session")
def launch() -> Fresh:
    """Starts Python in a fresh process and a given folder: ``launch(folder, "-m", "mol_compactons", ..., path=[...])``.

    On its path are the given folders alone, by default that of `own_physics`.
    """

    def start(folder: Path, *arguments: object, path: Sequence[Path] = (HERE,)) -> subprocess.CompletedProcess[str]:
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, path)), "MPLBACKEND": "agg"}
        command = [sys.executable, *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment, check=False)

    return start


@pytest.fixture
def fresh(launch: Fresh, tmp_path: Path) -> Fresh:
    """The same in an empty folder."""
    return partial(launch, tmp_path)
