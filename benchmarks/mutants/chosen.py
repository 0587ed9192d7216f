"""A plugin of pytest that runs chosen tests in the order in which they are named, and is content with the first failure."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from hypothesis import Phase, settings

CHOICE = "CHOSEN_TESTS"
"""The variable of the environment that names a file with the names of the tests."""


@pytest.hookimpl(trylast=True)
def pytest_configure() -> None:
    """Do not let hypothesis look for the smallest example: one is enough."""
    if CHOICE in os.environ:
        settings.register_profile("first failure", settings.default, phases=(Phase.explicit, Phase.generate))
        settings.load_profile("first failure")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the tests that are named, and put them in order."""
    if path := os.environ.get(CHOICE):
        order = {name: place for place, name in enumerate(json.loads(Path(path).read_text()))}
        kept = sorted((item for item in items if item.nodeid in order), key=lambda item: order[item.nodeid])
        config.hook.pytest_deselected(items=[item for item in items if item.nodeid not in order])
        items[:] = kept
