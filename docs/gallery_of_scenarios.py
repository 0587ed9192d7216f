"""The scenarios as a gallery: each script with a title that Sphinx understands, run where that takes seconds."""

from __future__ import annotations

import ast
import re
import shutil
from pathlib import Path
from typing import Any

RUN = (
    "hertz_chain",
    "hertz_compacton",
    "lattice_collision",
    "lattice_single",
    "no_viscosity",
    "paper_figures",
    "prestressed_chain",
    "rarefaction",
    "rarefaction_chain",
    "single_compacton",
    "two_bright",
)
"""The scenarios that run when the documentation is built: of a few seconds each, and without processes of their own."""

README = """Scenarios
=========

Every scenario of the package, as ``mol-compactons scenarios`` lists them. Those of a few seconds are run when this page is
made, with the pictures and the numbers that come out; of the others, which would take longer, there is the script.
"""


def title_of(docstring: str) -> str:
    """The first sentence of a docstring, or what stands before its colon, as a title."""
    line = docstring.splitlines()[0]
    return re.split(r"(?<!Fig)[.:](?:\s|$)", line, maxsplit=1)[0]


def escaped(text: str) -> str:
    """Plain text for reStructuredText, but for indented blocks, which become literal ones."""
    paragraphs = []
    for paragraph in text.split("\n\n"):
        if paragraph.startswith("    "):
            paragraphs.append("::\n\n" + paragraph)
        else:
            literal = re.sub(r"`([^`]+)`", r"``\1``", paragraph)
            paragraphs.append(re.sub(r"(?<!\\)([|*])", r"\\\1", literal))
    return "\n\n".join(paragraphs)


def with_title(source: str) -> str:
    """A script whose docstring begins with an underlined title."""
    module = ast.parse(source)
    docstring = ast.get_docstring(module, clean=True) or ""
    body = "".join(source.splitlines(keepends=True)[module.body[0].end_lineno :])
    title = title_of(docstring)
    return f'r"""\n{title}\n{"=" * len(title)}\n\n{escaped(docstring)}\n"""\n{body}'


def write_scripts(scenarios: Path, folder: Path) -> None:
    """Put the scripts of the gallery into a folder."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "README.rst").write_text(README, encoding="utf-8")
    for path in sorted(scenarios.glob("*.py")):
        (folder / path.name).write_text(with_title(path.read_text(encoding="utf-8")), encoding="utf-8")


class PicturesOfScripts:
    """Takes the pictures that a script has saved, since the scenarios draw without pyplot; copies go to a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __repr__(self) -> str:
        """The same in each build, so that Sphinx sees no change."""
        return "PicturesOfScripts"

    def __call__(self, block: tuple[Any, ...], variables: dict[str, Any], conf: dict[str, Any]) -> str:
        """Move what was drawn to where Sphinx looks for it, and say so in reStructuredText."""
        from sphinx_gallery.scrapers import figure_rst

        taken = []
        self._folder.mkdir(parents=True, exist_ok=True)
        for picture in sorted(Path(variables["src_file"]).parent.rglob("*.png")):
            place = next(variables["image_path_iterator"])
            shutil.copy(picture, self._folder / picture.name)
            shutil.move(picture, place)
            taken.append(place)
        return str(figure_rst(taken, conf["src_dir"]))
