from __future__ import annotations

import gc
import importlib.metadata
import subprocess
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from mol_compactons import GranularCompacton, Grid, InputError
from mol_compactons.equations import Equation
from mol_compactons.integrators import Integrator
from mol_compactons.open_set import find, loaded, name_of


class Shape(ABC):
    """A base class of this file's own."""

    @abstractmethod
    def area(self) -> float:
        """Anything."""


@dataclass(frozen=True)
class Square(Shape):
    side: float

    def area(self) -> float:
        return self.side**2


class Round(Shape):
    """Abstract still: it says nothing of its area."""


@dataclass(frozen=True)
class Disc(Round):
    radius: float

    def area(self) -> float:
        return 3 * self.radius**2


class Plain(Shape):
    """Concrete, but no dataclass: nothing of it could be stored."""

    def area(self) -> float:
        return 0.0


def test_only_concrete_dataclasses_count_however_deep() -> None:
    assert loaded(Shape) == {f"{__name__}:Square": Square, f"{__name__}:Disc": Disc}
    assert loaded(Round) == {f"{__name__}:Disc": Disc}
    assert loaded(Square) == {f"{__name__}:Square": Square}


def test_a_hint_that_is_no_class_stands_for_nothing() -> None:
    assert loaded(lambda: Square(1)) == {}


def test_classes_of_the_package_have_bare_names_and_others_their_module() -> None:
    assert name_of(GranularCompacton) == "GranularCompacton"
    assert name_of(Square) == f"{__name__}:Square"
    own = {name for name, cls in loaded(Equation).items() if cls.__module__.startswith("mol_compactons.")}
    assert {"GranularChain", "GranularCompacton", "Nesterenko", "PowerLawEquation", "RosenauHyman"} <= own
    assert all(":" not in name for name in own)
    own_integrators = {name for name in loaded(Integrator) if ":" not in name}
    assert own_integrators == {"CVODE", "GaussLegendre", "IDA", "Midpoint", "Rosenbrock", "Symplectic"}


EVERY_MODULE = """
import pkgutil, sys
import mol_compactons
from mol_compactons.open_set import loaded
from mol_compactons import Equation, Integrator, Scheme, StopRule, Wave, ContactLaw
bases = (Equation, Integrator, Scheme, StopRule, Wave, ContactLaw)
at_once = [sorted(loaded(base)) for base in bases]
for module in pkgutil.walk_packages(mol_compactons.__path__, "mol_compactons."):
    if not module.name.endswith("__main__") and "scenario_scripts" not in module.name:
        __import__(module.name)
assert at_once == [sorted(loaded(base)) for base in bases], at_once
assert all(at_once)
"""


def test_a_part_of_the_package_counts_though_nobody_has_asked_for_it_yet() -> None:
    done = subprocess.run([sys.executable, "-c", EVERY_MODULE], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.fixture
def _nothing_stays() -> Iterator[None]:
    yield
    gc.collect()


@pytest.mark.usefixtures("_nothing_stays")
def test_of_two_classes_with_one_name_the_younger_counts() -> None:
    """As where a module is run again."""

    def again() -> type[Shape]:
        @dataclass(frozen=True)
        class Star(Shape):
            def area(self) -> float:
                return 1.0

        return Star

    first, second = again(), again()
    assert first is not second
    assert loaded(Shape)[name_of(second)] is second


def test_a_name_is_found_below_any_of_some_bases() -> None:
    assert find((Grid, Shape), f"{__name__}:Square", lambda: "a shape") is Square
    assert find((Grid, Shape), "Grid", lambda: "a shape") is Grid
    with pytest.raises(InputError, match="Square is not allowed here; it must be a grid or a shape"):
        find((Grid, Shape), "Square", lambda: "a grid or a shape")
    with pytest.raises(InputError, match=r"tests\.nowhere:Square is not loaded, or not a shape; import tests\.nowhere first"):
        find((Shape,), "tests.nowhere:Square", lambda: "a shape")


MODULE = """
from dataclasses import dataclass
from tests.test_open_set import Shape

@dataclass(frozen=True)
class Announced(Shape):
    def area(self):
        return 5.0
"""


def announce(monkeypatch: pytest.MonkeyPatch, value: str, name: str = "anything") -> None:
    """As if an installed package had this entry point."""
    entry = importlib.metadata.EntryPoint(name=name, value=value, group="mol_compactons")
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda group: [entry] if group == "mol_compactons" else [])


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The name of a module that could be imported, and has not been."""
    name = "announced_shapes"
    (tmp_path / f"{name}.py").write_text(MODULE)
    monkeypatch.syspath_prepend(str(tmp_path))
    assert name not in sys.modules
    yield name
    sys.modules.pop(name, None)
    gc.collect()


def test_no_module_is_imported_because_a_name_names_it(module: str) -> None:
    with pytest.raises(InputError, match=f"import {module} first"):
        find((Shape,), f"{module}:Announced", lambda: "a shape")
    assert module not in sys.modules


def test_an_installed_package_may_announce_its_classes(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    announce(monkeypatch, f"{module}:Announced")
    found = find((Shape,), f"{module}:Announced", lambda: "a shape")
    assert (found.__name__, found().area()) == ("Announced", 5.0)
    assert module in sys.modules


def test_a_module_that_is_announced_brings_all_its_classes(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    announce(monkeypatch, module)
    assert find((Shape,), f"{module}:Announced", lambda: "a shape")().area() == 5.0


def test_what_others_announce_is_not_imported(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    announce(monkeypatch, f"{module}:Announced")
    with pytest.raises(InputError, match="other:Thing is not loaded"):
        find((Shape,), "other:Thing", lambda: "a shape")
    assert module not in sys.modules
