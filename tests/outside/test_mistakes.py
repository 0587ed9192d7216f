"""Mistakes of a user's module, each of which gets one sentence, and what it may leave to the package."""

from __future__ import annotations

import gc
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

import numpy as np
import pytest

from mol_compactons import (
    Compacton,
    Equation,
    GranularCompacton,
    Grid,
    InputError,
    Ripple,
    Rosenbrock,
    Scheme,
    Simulation,
    Uniform,
    Wave,
    run,
)
from tests.burgers_texts import MODULE, REPEAT

Fresh = Callable[..., "CompletedProcess[str]"]


def burgers(**more: Any) -> type[Any]:
    names = {"variables": ("u",), "local_flux": lambda self, t, x, y, d: y[0] ** 2 / 2 - 0.1 * d(y[0], 1)}
    return dataclass(frozen=True)(type("B", (Equation,), names | more))


def simulate(equation: Any, *waves: Any, **more: Any) -> Any:
    return run(Simulation(equation, Grid(10, 40), list(waves) or [Uniform(1), Ripple(0.1, 1)], t_end=0.1, frames=3, **more))


def wave(values: Any) -> Any:
    made: Any = type("W", (Wave,), {"values": lambda self, equation, grid, t=0.0: values(grid)})
    return dataclass(frozen=True)(made)()


def test_a_script_run_by_python_makes_files_that_open(fresh: Fresh, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        MODULE.format(nu=0.1) + "\nif __name__ == '__main__':\n    run(simulation, 'first.nc')\n"
    )
    assert fresh("mine.py").returncode == 0
    assert fresh(*REPEAT, "--import", "mine").stderr == ""


def test_schemes_of_one_name_are_two_schemes(fresh: Fresh, tmp_path: Path) -> None:
    scheme = """
@dataclass(frozen=True)
class Own(Scheme):
    def suits(self, equation): return 0.1
    def discretize(self, equation, grid):
        return CentralScheme(order={order}).discretize(equation, grid)
"""
    for name, order in (("a", 2), ("b", 6)):
        (tmp_path / f"{name}.py").write_text(MODULE.format(nu=0.1) + scheme.format(order=order))
    family = "Family(sizes=(20, 40, 80), schemes=(a.Own(), b.Own()))"
    code = f"import a, b; from mol_compactons import *; converge(a.simulation, {family})"
    assert fresh("-c", code).stderr == ""


def test_a_bare_name_of_two_classes_is_refused(fresh: Fresh, tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / f"{name}.py").write_text(MODULE.format(nu=0.1))
    options = ("--import", "a", "--import", "b", "--set", "equation=Burgers()")
    done = fresh("-m", "mol_compactons", "run", "a.py", "-o", "x.nc", "--quiet", *options)
    assert done.returncode == 2
    assert "a:Burgers or b:Burgers" in done.stderr


def test_a_scheme_with_a_required_field_does_not_break_others() -> None:
    @dataclass(frozen=True)
    class Needs(Scheme):
        order: int

        def suits(self, equation: Any) -> float:
            return 0.0

        def discretize(self, equation: Any, grid: Any) -> Any:
            return None

    try:
        Simulation(GranularCompacton(3), Grid(30, 60), [Compacton(1, 10)], 1)
    finally:
        del Needs
        gc.collect()


@pytest.mark.parametrize("entry", ["lab = lab:Burgers", "lab = lab"])
def test_a_package_may_announce_what_it_re_exports(entry: str, fresh: Fresh, tmp_path: Path) -> None:
    site = tmp_path / "site"
    (site / "lab").mkdir(parents=True)
    (site / "lab" / "__init__.py").write_text("from lab.equations import Burgers")
    (site / "lab" / "equations.py").write_text(MODULE.format(nu=0.1))
    info = site / "lab-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: lab\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[mol_compactons]\n{entry}\n")
    fresh(
        "-c", "from lab.equations import simulation; from mol_compactons import run; run(simulation, 'first.nc')", path=[site]
    )
    assert fresh(*REPEAT, path=[site]).stderr == ""


@pytest.mark.parametrize("break_it", ["raise ImportError('no torch')", "gone = 1"])
def test_a_broken_entry_point_is_one_sentence(break_it: str, fresh: Fresh, tmp_path: Path) -> None:
    site = tmp_path / "site"
    info = site / "lab-1.0.dist-info"
    info.mkdir(parents=True)
    (site / "lab.py").write_text(MODULE.format(nu=0.1))
    fresh("-c", "from lab import simulation; from mol_compactons import run; run(simulation, 'first.nc')", path=[site])
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: lab\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[mol_compactons]\nlab = lab:Burgers\n")
    (site / "lab.py").write_text(break_it)
    done = fresh(*REPEAT, path=[site])
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)


def test_a_module_by_its_path_may_import_its_neighbours(fresh: Fresh, tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "helper.py").write_text("NU = 0.1")
    (tmp_path / "sub" / "mod.py").write_text("import helper\n" + MODULE.format(nu=0.1))
    options = ("--import", "sub/mod.py", "--set", "title=x", "--set", "t_end=0.1", "--set", "frames=2")
    assert fresh("-m", "mol_compactons", "run", "two_bright", "-o", "x.nc", "--quiet", *options).stderr == ""


def test_a_title_is_no_module(fresh: Fresh) -> None:
    options = ("--set", "title=case:two", "--set", "t_end=0.1", "--set", "frames=2")
    assert fresh("-m", "mol_compactons", "run", "two_bright", "-o", "x.nc", "--quiet", *options).stderr == ""


def test_a_script_loaded_twice_can_be_pickled(fresh: Fresh, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(MODULE.format(nu=0.1))
    code = "import pickle; from mol_compactons.cli.scenarios import load; load('mine.py'); pickle.dumps(load('mine.py'))"
    assert fresh("-c", code).stderr == ""


@pytest.mark.parametrize(
    "values",
    [
        lambda grid: np.ones(grid.size),
        lambda grid: np.ones((1, grid.size - 1)),
        lambda grid: np.full((1, grid.size), np.nan),
        lambda grid: 1j * np.ones((1, grid.size)),
    ],
)
def test_a_wave_of_a_wrong_shape_is_one_sentence(values: Any) -> None:
    with pytest.raises(InputError, match="W"):
        simulate(burgers()(), wave(values))


def test_whole_numbers_are_numbers() -> None:
    simulate(burgers()(), wave(lambda grid: np.arange(grid.size)[None]))


@pytest.mark.parametrize("flux", [lambda y: 0.0, lambda y: y, lambda y: None])
def test_a_flux_of_a_wrong_shape_is_one_sentence(flux: Any) -> None:
    with pytest.raises(InputError, match="B"):
        simulate(burgers(local_flux=lambda self, t, x, y, d: flux(y))())


@pytest.mark.parametrize("variables", ["u", "uv", ("x",), ("t",), ("mass",), ("u", "w"), ("u/v",)])
def test_variables_that_cannot_be_are_one_sentence(variables: Any) -> None:
    with pytest.raises(InputError, match="variables"):
        simulate(burgers(variables=variables)(), Uniform(1))


@pytest.mark.parametrize("invariants", [lambda y: {"a": y.sum(axis=1)}, lambda y: {"u": 1.0}])
def test_invariants_that_cannot_be_are_one_sentence(invariants: Any) -> None:
    with pytest.raises(InputError):
        simulate(burgers(invariants=lambda self, y, h, d: invariants(y))())


def test_a_dataclass_that_is_not_frozen_is_one_sentence() -> None:
    names = {"variables": ("u",), "local_flux": lambda self, t, x, y, d: y[0]}
    made: Any = type("M", (Equation,), names)
    equation = dataclass(made)()
    with pytest.raises(InputError, match="frozen"):
        simulate(equation)


@pytest.mark.parametrize(
    ("hint", "value"),
    [
        (np.ndarray, np.ones(2)),
        (list[float], [1.0]),
        (dict[str, float], {"a": 1.0}),
        (Callable, np.sin),
        (complex, 1j),
        (set, {1}),
        (bytes, b"x"),
        (tuple, (1, 2)),
    ],
)
def test_a_field_that_cannot_be_stored_is_one_sentence_with_a_cure(hint: Any, value: Any) -> None:
    made = burgers(__annotations__={"p": hint}, p=field(default_factory=lambda: value))
    with pytest.raises(InputError, match=r"tuple\[float|cannot be stored"):
        made()


def test_with_a_source_nothing_is_taken_for_conserved() -> None:
    result = simulate(burgers(local_source=lambda self, t, x, y, d: -y[0])())
    assert result.mass.attrs["role"] == "diagnostic"


def test_a_source_that_depends_on_time_is_noticed() -> None:
    counts = []
    for said in ({}, {"depends_on_time": True}):
        driven = burgers(local_source=lambda self, t, x, y, d: np.cos(20 * t) + 0 * x, **said)()
        counts.append(simulate(driven, Uniform(1), integrator=Rosenbrock(rtol=1e-7)).attrs["solver_steps"])
    assert counts[0] == counts[1]


def test_a_result_names_only_its_own_references() -> None:
    result = simulate(burgers(reference="Burgers (1948)")())
    assert result.attrs["references"] == "Burgers (1948)"


def test_the_names_that_a_part_needs_stand_at_the_top() -> None:
    import mol_compactons

    assert {"LocalizedWave", "Counters", "require"} <= set(mol_compactons.__all__)


def test_a_file_may_be_imported_by_its_path_though_its_module_is_loaded(fresh: Fresh, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(MODULE.format(nu=0.1))
    names = ("mine", "mine.py", "./mine.py")
    code = f"from mol_compactons.cli.scenarios import import_module; [import_module(name) for name in {names}]"
    assert fresh("-c", code).stderr == ""
