"""How classes of other modules are found: by import and by entry point, and never because a file names them."""

import json
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

import netCDF4
import pytest

from mol_compactons import (
    ContactLaw,
    Equation,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    Integrator,
    PowerContact,
    Scheme,
    Simulation,
    Uniform,
    Wave,
)
from mol_compactons.configuration import decode, encode
from tests.burgers_texts import MODULE, REPEAT
from tests.systems import one_compacton

Fresh = Callable[..., "CompletedProcess[str]"]


@pytest.fixture
def burgers(tmp_path: Path) -> Path:
    """A folder with a module `burgers`, off the working folder."""
    folder = tmp_path / "modules"
    folder.mkdir()
    (folder / "burgers.py").write_text(MODULE.format(nu=0.1), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def made(launch: Fresh, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result of `burgers`."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "burgers.py").write_text(MODULE.format(nu=0.1), encoding="utf-8")
    code = "from burgers import *; run(simulation, 'first.nc')"
    assert launch(folder, "-c", code, path=[]).returncode == 0
    return folder / "first.nc"


@pytest.fixture
def first(made: Path, tmp_path: Path) -> Path:
    """The same in the working folder."""
    return Path(shutil.copy(made, tmp_path))


def changed(part: str, name: Any) -> str:
    """The JSON of a simulation in which one part has another class."""
    data = encode(one_compacton())
    target = data["initial"][0] if part == "initial" else data[part]
    target["type"] = name
    return json.dumps(data)


NAMES = ["evil:Burgers", "evil", "evil:", "evil.sub:Burgers", ":evil", "evil:Burgers:Burgers", ["evil:Burgers"], None, 3]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("part", ["equation", "initial", "scheme", "integrator", "grid"])
def test_no_module_is_imported_because_a_text_names_it(
    part: str, name: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "evil.py").write_text("raise SystemExit", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(InputError) as refusal:
        Simulation.from_json(changed(part, name))
    assert "\n" not in str(refusal.value)
    assert "evil" not in sys.modules


@pytest.mark.parametrize(
    "name", ["os:system", "subprocess:Popen", "Simulation", "Grid", "mol_compactons.grid:Grid", "Equation"]
)
def test_what_is_loaded_but_is_no_equation_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="Equation"):
        Simulation.from_json(changed("equation", name))


@pytest.mark.parametrize("command", ["run", "converge"])
@pytest.mark.usefixtures("first")
def test_no_module_is_imported_because_a_file_names_it(command: str, fresh: Fresh, tmp_path: Path, burgers: Path) -> None:
    """Though it stands in the working folder and on the path, and its name is that of the class in the file."""
    for folder in (tmp_path, burgers):
        (folder / "evil.py").write_text("from pathlib import Path\nPath('flag').touch()\n" + MODULE.format(nu=0.1), "utf-8")
    with netCDF4.Dataset(tmp_path / "first.nc", "a") as file:
        file.simulation = file.simulation.replace("burgers:", "evil:")
    refused = fresh("-m", "mol_compactons", command, "first.nc", "-o", "again.nc", "--quiet", path=[burgers])
    assert refused.returncode == 2
    assert len(refused.stderr.splitlines()) == 1
    assert "No module is imported because a file names it" in refused.stderr
    assert not (tmp_path / "flag").exists()
    assert fresh(*REPEAT, "--import", "evil", path=[burgers]).returncode == 0
    assert (tmp_path / "flag").exists()


def test_a_script_repeats_its_result(fresh: Fresh, tmp_path: Path) -> None:
    """A class of a scenario script has the name of the script."""
    (tmp_path / "mine.py").write_text(MODULE.format(nu=0.1), encoding="utf-8")
    assert fresh("-m", "mol_compactons", "run", "mine.py", "-o", "first.nc", "--quiet", path=[]).returncode == 0
    assert "mine:Burgers is not loaded" in fresh(*REPEAT, path=[]).stderr
    for module in ("mine", "./mine.py"):
        assert fresh(*REPEAT, "--import", module, path=[]).returncode == 0


def test_two_modules_may_have_classes_of_one_name(fresh: Fresh, burgers: Path) -> None:
    (burgers / "other.py").write_text(MODULE.format(nu=0.2), encoding="utf-8")
    code = """
import burgers, other
from mol_compactons import Simulation
from mol_compactons.assignment import assign
for module in (burgers, other, burgers):
    again = Simulation.from_json(module.simulation.to_json())
    assert type(again.equation) is module.Burgers
    assert again == module.simulation
assert burgers.simulation != other.simulation
changed = assign(burgers.simulation, {"equation": "other:Burgers(nu=0.3)"})
assert changed.equation == other.Burgers(0.3)
assert assign(changed, {"equation": "burgers:Burgers"}) == burgers.simulation
"""
    done = fresh("-c", code, path=[burgers])
    assert (done.returncode, done.stderr) == (0, "")


def test_of_a_class_defined_twice_the_younger_counts(fresh: Fresh, tmp_path: Path) -> None:
    """As in a notebook, where a cell is run again."""
    (tmp_path / "cells.py").write_text(
        MODULE.format(nu=0.1)
        + "\nfirst = simulation\n"
        + MODULE.format(nu=0.2)
        + """
again = Simulation.from_json(simulation.to_json())
assert again == simulation and type(again.equation) is Burgers
old = Simulation.from_json(first.to_json())
assert type(old.equation) is Burgers and old.equation.nu == 0.1
""",
        encoding="utf-8",
    )
    done = fresh("cells.py")
    assert (done.returncode, done.stderr) == (0, "")


class PlainEquation(Equation):
    """No dataclass."""

    variables = ("u",)

    def local_flux(self, t: float, x: Any, state: Any, derivative: Any) -> Any:
        return state[0]


class PlainWave(Wave):
    """No dataclass."""

    def values(self, equation: Equation, grid: Any, t: float = 0.0) -> Any:
        return grid.x[None]


class PlainScheme(Scheme):
    """No dataclass."""

    def suits(self, equation: Equation) -> float:
        return 1.0

    def discretize(self, equation: Equation, grid: Any) -> Any:
        return None


class PlainIntegrator(Integrator):
    """No dataclass."""

    def start(self, system: Any, state: Any, t_end: float) -> Any:
        return None


class PlainLaw(ContactLaw):
    """No dataclass."""

    def force(self, z: Any, factor: Any) -> Any:
        return z

    stiffness = energy = force


@pytest.mark.parametrize(
    "make",
    [
        lambda: Simulation(PlainEquation(), Grid(10, 40), [Uniform(1)], 1),
        lambda: Simulation(GranularCompacton(3), Grid(10, 40), [PlainWave()], 1),
        lambda: Simulation(GranularCompacton(3), Grid(10, 40), [Uniform(1)], 1, scheme=PlainScheme()),
        lambda: Simulation(GranularCompacton(3), Grid(10, 40), [Uniform(1)], 1, integrator=PlainIntegrator()),
        lambda: GranularChain(PlainLaw()),
    ],
)
def test_a_class_that_is_no_dataclass_gets_a_sentence(make: Callable[[], object]) -> None:
    with pytest.raises(InputError, match=r"^Plain\w+ is no frozen dataclass .* write @dataclass\(frozen=True\)"):
        make()


def announce(folder: Path, entries: str) -> None:
    """Make a folder look as if a distribution had been installed there."""
    information = folder / "granular_extras-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: granular-extras\nVersion: 1.0\n", encoding="utf-8")
    (information / "entry_points.txt").write_text(f"[mol_compactons]\n{entries}\n", encoding="utf-8")


@pytest.mark.parametrize("entry", ["burgers = burgers", "Burgers = burgers:Burgers", "anything = burgers:simulation"])
@pytest.mark.usefixtures("first")
def test_what_an_installed_package_announces_is_found(entry: str, fresh: Fresh, tmp_path: Path, burgers: Path) -> None:
    """A file decodes without --import, once a distribution in the path announces the module or something in it."""
    announce(burgers, entry)
    done = fresh(*REPEAT, path=[burgers])
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "again.nc").is_file()


def test_what_is_announced_is_imported_only_where_it_is_named(fresh: Fresh, burgers: Path) -> None:
    announce(burgers, "Burgers = burgers:Burgers")
    code = """
import sys, mol_compactons
from mol_compactons import *
own = Simulation(GranularCompacton(n=3), Grid(30, 60), [Compacton(1, 5)], t_end=1, frames=2)
assert Simulation.from_json(own.to_json()) == own
for name in ("evil:Burgers", "burger:Burgers", "Burger"):
    try:
        Simulation.from_json(own.to_json().replace('"GranularCompacton"', f'"{name}"'))
    except InputError:
        pass
assert "burgers" not in sys.modules and "evil" not in sys.modules
"""
    done = fresh("-c", code, path=[burgers])
    assert (done.returncode, done.stderr) == (0, "")


def test_a_law_inside_of_a_chain_is_found_as_well(fresh: Fresh) -> None:
    code = """
from own_physics import TodaContact
from mol_compactons import Equation, GranularChain
from mol_compactons.configuration import decode, encode
chain = GranularChain(TodaContact(b=2))
assert encode(chain)["law"] == {"type": "own_physics:TodaContact", "b": 2.0}
assert decode(Equation, encode(chain)) == chain
"""
    done = fresh("-c", code)
    assert (done.returncode, done.stderr) == (0, "")
    data = encode(GranularChain(PowerContact(2)))
    data["law"]["type"] = "evil:Law"
    with pytest.raises(InputError, match="evil:Law is not loaded, or not ContactLaw"):
        decode(Equation, data)


@pytest.mark.usefixtures("first")
def test_fields_of_an_earlier_version_are_read(fresh: Fresh, burgers: Path) -> None:
    """A class that has another field today says how it was spelt before."""
    later = MODULE.format(nu=0.1).replace("nu: float", "viscosity: float").replace("self.nu", "self.viscosity")
    (burgers / "burgers.py").write_text(later, encoding="utf-8")
    assert "Burgers has no field 'nu'" in fresh(*REPEAT, "--import", "burgers", path=[burgers]).stderr
    method = "\n    @classmethod\n    def from_earlier(cls, fields):\n        return {'viscosity': fields.get('nu', 0.1)}\n"
    (burgers / "burgers.py").write_text(later.replace("\nsimulation", method + "\nsimulation"), encoding="utf-8")
    done = fresh(*REPEAT, "--import", "burgers", path=[burgers])
    assert (done.returncode, done.stderr) == (0, "")
