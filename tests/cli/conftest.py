from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent

QUICK = ["--set", "t_end=0.5", "--set", "frames=6", "--set", "grid.size=150"]
"""Options that make any scenario a short run."""


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
