"""What must agree before a release: versions, citation, changelog, the oldest dependencies."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent


def project() -> dict[str, Any]:
    return dict(tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"])


def release(version: str) -> tuple[int, ...]:
    """A version as numbers without zeros at the end: 3.7 and 3.7.0 are one."""
    return tuple(int(part) for part in re.sub(r"(\.0)+$", "", version).split("."))


def test_the_citation_and_the_changelog_have_the_version() -> None:
    version = project()["version"]
    assert re.findall(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE) == [version]
    headings = re.findall(r"^## (\S+), ", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert headings[0] == version


def test_the_oldest_versions_that_are_tested_are_the_lower_bounds() -> None:
    bounds = dict(dependency.split(">=") for dependency in project()["dependencies"])
    constraints = (ROOT / "constraints-oldest.txt").read_text(encoding="utf-8")
    tested = dict(re.findall(r"^([\w-]+)==(\S+)$", constraints, re.MULTILINE))
    assert {name: release(version) for name, version in tested.items()} == {
        name: release(version) for name, version in bounds.items()
    }


def test_the_type_hints_are_marked_as_such() -> None:
    assert (ROOT / "mol_compactons" / "py.typed").is_file()
    assert "Typing :: Typed" in project()["classifiers"]


def imported() -> set[str]:
    """The packages that the modules import, inside functions too."""
    found = set()
    for path in (ROOT / "mol_compactons").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                found.add(str(node.module).partition(".")[0])
    return found - set(sys.stdlib_module_names) - {"mol_compactons"}


def test_what_is_imported_is_a_dependency_and_no_more() -> None:
    names = {"sksundae": "scikit-sundae", "lazy_loader": "lazy-loader", "imageio_ffmpeg": "imageio-ffmpeg", "PIL": "pillow"}
    found = {names.get(module, module) for module in imported()}
    engines = {"netCDF4"}  # with which xarray opens results where nothing is said
    needed, extras = project()["dependencies"], project()["optional-dependencies"]
    wanted = (*needed, *extras["dask"], *extras["film"], *extras["report"])
    of_notebooks = {"ipywidgets"}  # which brings it where it is used
    assert (found | engines) - of_notebooks == {dependency.partition(">=")[0] for dependency in wanted}
