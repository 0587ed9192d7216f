from __future__ import annotations

import numpy as np
import pytest
from hypothesis import settings

np.seterr(all="raise", under="ignore")
settings.register_profile("project", deadline=None, max_examples=40, derandomize=True)
settings.load_profile("project")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--slow", action="store_true", help="run the long studies too")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--slow"):
        return
    skip = pytest.mark.skip(reason="a long study; run with --slow")
    for item in items:
        if "slow" in item.keywords:
            item.add_marker(skip)


@pytest.fixture(autouse=True)
def _compile_silently(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whichever test comes first compiles; what it prints must not depend on that."""
    monkeypatch.setattr("mol_compactons.cli.parser._say_that_it_compiles", lambda: None)
