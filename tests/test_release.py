"""What must agree before a release: versions, citation, changelog, the oldest dependencies."""

from __future__ import annotations

import ast
import json
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


def cited(field: str) -> str:
    """A field of CITATION.cff, which is one line."""
    (line,) = re.findall(rf"^{field}: (.+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    return str(line).strip('"')


def test_the_citation_the_archive_and_the_paper_tell_the_same() -> None:
    own, archive = project(), json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))
    paper = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")
    assert own["version"] == cited("version") == archive["version"]
    assert own["license"] == cited("license") == archive["license"]
    assert own["description"] == archive["description"]
    assert own["keywords"] == archive["keywords"]
    assert f'title: "{cited("title")}"' in paper
    assert cited("title") == archive["title"]
    assert cited("title").startswith(own["name"])
    assert [author["name"] for author in own["authors"]] == [creator["name"] for creator in archive["creators"]]
    assert [f"https://doi.org/{one['identifier']}" for one in archive["related_identifiers"]] == list(own["urls"].values())


def test_the_paper_cites_what_is_in_its_list() -> None:
    paper = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")
    listed = (ROOT / "paper" / "paper.bib").read_text(encoding="utf-8")
    entries = re.findall(r"^@(?:article|misc)\{(\w+),$", listed, re.MULTILINE)
    cited = {key for group in re.findall(r"\[(@[^\]]+)\]", paper) for key in re.findall(r"@(\w+)", group)}
    assert sorted(cited) == sorted(entries)


def test_the_numbers_of_the_paper_and_the_readme_are_those_of_the_benchmarks() -> None:
    benchmarks, paper, readme = (
        " ".join((ROOT / name).read_text(encoding="utf-8").split())
        for name in ("docs/benchmarks.md", "paper/paper.md", "README.md")
    )
    for seconds in re.findall(r"(\d+\.\d+) s\b", paper.split("# Comparison")[1]):
        assert f"| {seconds} |" in benchmarks
    for seconds in re.findall(r"(\d+\.\d{3}) s\b", readme.split("## How fast")[1]):
        assert f"| {seconds} |" in benchmarks
    assert "in 0.43 of the time by SUNDIALS and 0.48 by" in paper
    assert "in 0.43 of the time by SUNDIALS and 0.48 by" in benchmarks


def test_the_recorded_table_is_that_of_the_page() -> None:
    page = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8").split("## W1")[1].split("## W2")[0]
    recorded = (ROOT / "docs" / "recorded" / "W1.csv").read_text(encoding="utf-8").splitlines()[1:]
    told = re.findall(r"^\| [^|]+ \| ([\d.]+) \| [^|]+ \| ([\de.-]+) \|", page, re.MULTILINE)
    assert [tuple(line.rsplit(",", 2)[1:]) for line in recorded] == told


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
