from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from mol_compactons import GranularCompacton, InputError, run
from mol_compactons.cli import scenarios
from tests.cli.conftest import ROOT
from tests.systems import one_compacton

SCRIPT = '''"""A short line about it.

And more.
"""

from mol_compactons import Compacton, GranularCompacton, Grid, Simulation

simulation = Simulation(GranularCompacton(3), Grid(30, 60), [Compacton(1, 10)], t_end=1, title="of one's own")
'''


@pytest.fixture(autouse=True)
def _no_module_stays(tmp_path: Path) -> Iterator[None]:
    """What a test imports from its own folder is forgotten."""
    yield
    for name, module in list(sys.modules.items()):
        place = getattr(module, "__file__", None)
        if place and (not Path(place).is_absolute() or Path(place).is_relative_to(tmp_path)):
            del sys.modules[name]


def test_in_a_checkout_the_scenarios_are_those_of_the_folder() -> None:
    assert scenarios.folder() == ROOT / "scenarios"


def test_an_installed_package_brings_them_along(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "mol_compactons"
    (package / "cli").mkdir(parents=True)
    monkeypatch.setattr(scenarios, "__file__", str(package / "cli" / "scenarios.py"))
    assert scenarios.folder() == tmp_path / "scenarios"
    (package / "scenario_scripts").mkdir()
    (package / "scenario_scripts" / "mine.py").write_text(SCRIPT)
    assert scenarios.folder() == package / "scenario_scripts"
    assert scenarios.listing() == {"mine": "A short line about it."}
    assert scenarios.load("mine").title == "of one's own"


def test_every_scenario_has_a_line() -> None:
    lines = scenarios.listing()
    assert list(lines) == sorted(path.stem for path in (ROOT / "scenarios").glob("*.py"))
    assert all(line.endswith(".") for line in lines.values())


def test_a_script_is_found_by_its_path_and_comes_before_a_scenario_of_its_name() -> None:
    Path("two_bright.py").write_text(SCRIPT)
    assert scenarios.load("two_bright.py").title == "of one's own"
    assert scenarios.load("two_bright").title.startswith("Two bright compactons")
    assert scenarios.load(str(ROOT / "scenarios" / "two_bright.py")) == scenarios.load("two_bright")


def test_a_result_is_a_scenario(tmp_path: Path) -> None:
    run(one_compacton(), tmp_path / "one.nc").close()
    assert scenarios.load("one.nc") == one_compacton()


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("nothing.py", "", "does not define a Simulation under the name 'simulation'; add one"),
        ("number.py", "simulation = 3", "does not define a Simulation"),
        ("broken.py", "1 / 0", r"could not be run \(ZeroDivisionError: division by zero\); correct the script"),
        ("syntax.py", "def", r"could not be run \(SyntaxError"),
        ("leaving.py", "raise SystemExit(3)", r"could not be run \(SystemExit: 3\)"),
        ("notes.txt", "text", "is neither a script"),
    ],
)
def test_a_script_that_is_none_is_named(name: str, text: str, words: str) -> None:
    Path(name).write_text(text)
    with pytest.raises(InputError, match=words):
        scenarios.load(name)


def test_bad_input_in_a_script_is_said_as_it_is() -> None:
    Path("wrong.py").write_text("from mol_compactons import GranularCompacton\nGranularCompacton(1)")
    with pytest.raises(InputError, match=r"^GranularCompacton\.n = 1 must be larger than 1"):
        scenarios.load("wrong.py")


def test_the_nearest_scenario_is_suggested() -> None:
    with pytest.raises(InputError, match="There is no scenario 'two_brigth'; did you mean 'two_bright'"):
        scenarios.load("two_brigth")


MODULE = """
from dataclasses import dataclass
from mol_compactons import GranularCompacton

@dataclass(frozen=True)
class Stiffer(GranularCompacton):
    pass
"""


@pytest.mark.parametrize(
    ("place", "name", "module"),
    [
        ("stiff_physics.py", "stiff_physics", "stiff_physics"),
        ("folder/stiff_file.py", "folder/stiff_file.py", "stiff_file"),
        ("parcel/stiff_part.py", "parcel.stiff_part", "parcel.stiff_part"),
    ],
)
def test_a_module_of_ones_own_is_imported_by_its_name_or_its_path(place: str, name: str, module: str) -> None:
    Path(place).parent.mkdir(exist_ok=True)
    Path(place).write_text(MODULE)
    scenarios.import_module(name)
    first = sys.modules[module]
    assert issubclass(first.Stiffer, GranularCompacton)
    assert first.Stiffer.__module__ == module
    if not name.endswith(".py"):
        scenarios.import_module(name)
        assert sys.modules[module] is first


def test_an_installed_module_is_imported_too() -> None:
    scenarios.import_module("wave")
    assert "wave" in sys.modules


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("nowhere_to_be_found", None, "There is no module 'nowhere_to_be_found'; give the name of one that Python finds"),
        ("mol_compactons.nothing", None, r"There is no module 'mol_compactons\.nothing'"),
        ("dividing", "1 / 0", "could not be imported"),
        ("needing", "import nowhere_to_be_found", "could not be imported"),
    ],
)
def test_a_module_that_cannot_be_imported_is_named(name: str, text: str | None, words: str) -> None:
    if text is not None:
        Path(f"{name}.py").write_text(text)
    with pytest.raises(InputError, match=words):
        scenarios.import_module(name)


def test_a_script_does_not_replace_a_module_of_its_name() -> None:
    """As one that is called numpy.py."""
    import numpy

    Path("numpy.py").write_text("simulation = 1")
    with pytest.raises(InputError, match="another module of the name numpy is loaded; rename the file"):
        scenarios.load("numpy.py")
    assert sys.modules["numpy"] is numpy
