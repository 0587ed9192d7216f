"""docs/extending.md holds the module `own_physics` as it stands, and all that it shows can be run."""

import ast
import re
import shlex
import tomllib
from collections.abc import Callable
from pathlib import Path
from subprocess import CompletedProcess

import pytest

HERE = Path(__file__).parent
PAGE = (HERE.parent.parent / "docs" / "extending.md").read_text(encoding="utf-8")
MODULE = (HERE / "own_physics.py").read_text(encoding="utf-8")

Fresh = Callable[..., "CompletedProcess[str]"]


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def script() -> str:
    """The blocks that use the module, one after the other."""
    return "".join(block for block in blocks("python") if block not in MODULE)


def in_folder(folder: Path) -> None:
    """Put what the page says into files: the module from its own blocks, and the script."""
    parts = [block for block in blocks("python") if block in MODULE]
    (folder / "own_physics.py").write_text("\n\n".join(parts), encoding="utf-8")
    (folder / "use.py").write_text(script(), encoding="utf-8")


def lines_of(tree: ast.ClassDef) -> int:
    """How many lines of code a class has, decorators included and docstrings not."""
    first = min([tree.lineno, *(decorator.lineno for decorator in tree.decorator_list)])
    every = set(range(first, (tree.end_lineno or first) + 1))
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node):
            every -= set(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
    source = MODULE.splitlines()
    return sum(bool(source[number - 1].strip()) for number in every)


def test_the_page_holds_the_whole_module() -> None:
    parts = [block for block in blocks("python") if block in MODULE]
    docstring, _, code = MODULE.partition("\n\n")
    assert code == "\n\n".join(parts)
    assert docstring.startswith('"""')


def test_the_lines_are_counted_right() -> None:
    """Those of a run in progress belong to its integrator."""
    classes = {node.name: node for node in ast.parse(MODULE).body if isinstance(node, ast.ClassDef)}
    for name, said in re.findall(r"\| `(\w+)` \| (\d+) \|$", PAGE, re.MULTILINE):
        own = [node for other, node in classes.items() if other in (name, f"{name}Run")]
        assert sum(map(lines_of, own)) == int(said), name


def test_what_it_shows_is_what_comes_out(fresh: Fresh, tmp_path: Path) -> None:
    """The Python blocks in their order, and then the commands."""
    in_folder(tmp_path)
    done = fresh("use.py", path=[])
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "".join(blocks("text"))
    commands = [shlex.split(line) for block in blocks("console") for line in block.splitlines()]
    assert len(commands) > 3
    assert all(command[:2] == ["$", "mol-compactons"] for command in commands)
    arguments = [command[2:] + ([] if command[2] == "info" else ["--quiet"]) for command in commands]
    code = f"from mol_compactons.cli.parser import main\nfor words in {arguments!r}:\n    assert main(words) == 0, words"
    done = fresh("-c", code, path=[])
    assert (done.returncode, done.stderr) == (0, "")


def test_a_package_with_its_entry_points_opens_its_files(fresh: Fresh, tmp_path: Path) -> None:
    """As if a package with the pyproject.toml of the page had been installed."""
    project = tomllib.loads(blocks("toml")[0])["project"]
    in_folder(tmp_path)
    site = tmp_path / "site"
    information = site / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    information.mkdir(parents=True)
    (tmp_path / "own_physics.py").rename(site / "own_physics.py")
    code = """
from own_physics import *
from mol_compactons import Simulation, run
run(Simulation(LogKdV(), Grid(30, 60), [GaussianWave(1, 10)], t_end=0.1, frames=2), "log.nc")
"""
    assert fresh("-c", code, path=[site]).returncode == 0
    repeat = ("-m", "mol_compactons", "run", "log.nc", "-o", "again.nc", "--quiet")
    (information / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: 1.0\n", encoding="utf-8")
    for group, entries in project["entry-points"].items():
        text = "\n".join([f"[{group}]", *(f"{name} = {value}" for name, value in entries.items())])
        (information / "entry_points.txt").write_text(text, encoding="utf-8")
    assert fresh(*repeat, path=[site]).returncode == 0


@pytest.mark.parametrize("name", ["formulas.md"])
def test_what_it_refers_to_exists(name: str) -> None:
    assert f"]({name})" in PAGE
    assert (HERE.parent.parent / "docs" / name).is_file()
