"""How Sphinx makes the documentation: `python -m sphinx -W --keep-going -E -b html docs build/docs`."""

from __future__ import annotations

import os
import re
import shutil
import sys
import tomllib
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from gallery_of_scenarios import RUN, PicturesOfScripts, write_scripts  # noqa: E402
from pictures_of_pages import draw, replace_pictures  # noqa: E402

BUILD = HERE.parent / "build"
PROJECT = tomllib.loads((HERE.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]

project = "mol_compactons"
author = PROJECT["authors"][0]["name"]
copyright = author
release = version = PROJECT["version"]

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
templates_path = ["_templates"]
exclude_patterns = [
    "gallery/*.py",
    "gallery/*.ipynb",
    "gallery/*.md5",
    "gallery/sg_execution_times.rst",
    "sg_execution_times.rst",
]
root_doc = "index"

html_theme = "pydata_sphinx_theme"
html_title = f"mol_compactons {version}"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_show_sourcelink = False
html_theme_options = {
    "navbar_align": "left",
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

# Each page is run when it is read, in the order of the names; a cell that fails, fails the build.
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 120
copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True
copybutton_exclude = ".linenos, .gp, .go"

autosummary_generate = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

sphinx_gallery_conf = {
    "examples_dirs": [str(BUILD / "scripts")],
    "gallery_dirs": ["gallery"],
    "filename_pattern": "/(" + "|".join(RUN) + r")\.py",
    "image_scrapers": (PicturesOfScripts(BUILD / "scenario_pictures"),),
    "reset_modules": (),
    "parallel": 2,
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 1e9,
    "abort_on_example_error": True,
    "copyfile_regex": r".*\.md",
}
# The gallery is made anew: what a script leaves behind is shown by other pages too.
shutil.rmtree(HERE / "gallery", ignore_errors=True)
write_scripts(HERE.parent / "scenarios", BUILD / "scripts")

# The commands and scripts that the pages show run in a folder of their own, as a reader's do, and find the data of the pages.
TUTORIAL = BUILD / "tutorial"
os.environ |= {"TUTORIAL_FOLDER": str(TUTORIAL), "MPLBACKEND": "agg", "COLUMNS": "100"}
os.environ["PYTHONPATH"] = os.pathsep.join([str(HERE), *filter(None, [os.environ.get("PYTHONPATH")])])
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])


def _begin(app: Any) -> None:
    """A new folder for the tutorial."""
    shutil.rmtree(TUTORIAL, ignore_errors=True)
    TUTORIAL.mkdir(parents=True)


def _pictures(app: Any, exception: Exception | None) -> None:
    """Fresh pictures in place of those that stand beside the pages, once Sphinx has copied these."""
    if exception is None and app.builder.name == "html":
        draw(BUILD / "pictures", BUILD / "scenario_pictures")
        replace_pictures(BUILD / "pictures", Path(app.outdir) / "_images")


def _escape(app: Any, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Let |W| in a docstring be an absolute value, which reStructuredText takes for a substitution."""
    lines[:] = [re.sub(r"(?<![`\\])\|", r"\\|", line) if "::" not in line else line for line in lines]


def setup(app: Any) -> None:
    """What Sphinx calls first."""
    app.connect("builder-inited", _begin)
    app.connect("autodoc-process-docstring", _escape)
    app.connect("build-finished", _pictures)
