"""Each kind of part from outside: its physics, its files, its tracks and its study."""

import json
import pickle
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mol_compactons import (
    CVODE,
    IDA,
    Compacton,
    Family,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    IntegrationError,
    Lattice,
    Midpoint,
    Rosenbrock,
    Simulation,
    Symplectic,
    converge,
    drift,
    judge,
    open_result,
    open_study,
    run,
    track,
)
from mol_compactons.results.opening import write_tree
from tests.systems import relative_error

# By its name, which is no name for the type checker: nothing of the project imports this module.
own: Any = import_module("own_physics")

Fresh = Callable[..., "CompletedProcess[str]"]

SAMPLES: dict[str, Simulation] = {
    "equation": Simulation(own.LogKdV(), Grid(length=30, size=120), [own.GaussianWave(speed=1, center=10)], t_end=3, frames=7),
    "wave": Simulation(own.LogKdV(), Grid(30, 120), [own.GaussianWave(speed=-1, center=20, sign=-1)], t_end=3, frames=7),
    "scheme": Simulation(GranularCompacton(1.5), Grid(40, 160), [Compacton(1, 15)], 3, scheme=own.PadeScheme(), frames=7),
    "law": Simulation(
        GranularChain(own.TodaContact(b=2)), Lattice(60), [own.TodaSoliton(1.2, 15)], 10, frames=13, integrator=Symplectic(0.1)
    ),
    "integrator": Simulation(
        GranularChain(own.TodaContact()),
        Lattice(60),
        [own.TodaSoliton(1.2, 15)],
        10,
        frames=13,
        integrator=own.RungeKutta4(0.05),
    ),
}
"""A simulation for each kind of part, whose only wave is known at all times."""

MANY = 31
"""Frames that tell whether a wave has settled."""

parts = pytest.mark.parametrize("part", list(SAMPLES))


def exact(simulation: Simulation, t: float) -> Any:
    return simulation.initial[0].values(simulation.equation, simulation.grid, t)[0]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The results of all samples, streamed into files."""
    folder = tmp_path_factory.mktemp("results")
    for part, simulation in SAMPLES.items():
        run(simulation, folder / f"{part}.nc").close()
    return {part: folder / f"{part}.nc" for part in SAMPLES}


@parts
def test_it_runs_close_to_the_exact_wave(part: str, files: dict[str, Path]) -> None:
    simulation = SAMPLES[part]
    with open_result(files[part]) as dataset:
        assert dataset.attrs["status"] == "complete"
        final = dataset[simulation.equation.variables[0]].values[-1]
        assert relative_error(final, exact(simulation, simulation.t_end)) < 3e-4
        assert float(abs(drift(dataset)["mass"]).max()) < 1e-12
        assert float(abs(drift(dataset)["energy"]).max()) < 2e-6


@parts
def test_it_is_tracked(part: str, files: dict[str, Path]) -> None:
    simulation = SAMPLES[part]
    wave: Any = simulation.initial[0]
    with open_result(files[part]) as dataset:
        tracks = track(dataset)
    assert tracks.attrs["lost"] == ""
    places = wave.center + wave.speed * simulation.times
    assert tracks.position.values[:, 0] == pytest.approx(places, abs=1e-3)
    assert tracks.speed.values[1:-1, 0] == pytest.approx(wave.speed, rel=1e-3)
    assert tracks.height.values[-1, 0] == pytest.approx(wave.outline(simulation.equation)[0], rel=1e-3)


@parts
def test_a_study_says_how_much_is_real(part: str) -> None:
    """The truth lies within the error bars; position, height and speed are converged where there are points enough.

    A chain's waves are read from a few sites, and no exact profile of a law of one's own is known to fit: that is told.
    """
    simulation = SAMPLES[part]
    wave: Any = simulation.initial[0]
    summary = converge(replace(simulation, frames=MANY))["summary"].to_dataset().isel(limit=0)
    truth = {
        "position 0": wave.center + wave.speed * simulation.t_end,
        "height 0": wave.outline(simulation.equation)[0],
        "speed 0": wave.speed,
    }
    for quantity, value in truth.items():
        row = summary.sel(quantity=quantity)
        assert (row.verdict.item() == "converged") == simulation.scheme.refines, quantity
        assert abs(float(row.value) - value) <= float(row.error)


@parts
def test_it_can_be_copied_compared_and_hashed(part: str) -> None:
    simulation = SAMPLES[part]
    for again in (pickle.loads(pickle.dumps(simulation)), Simulation.from_json(simulation.to_json())):
        assert again == simulation
        assert hash(again) == hash(simulation)
        assert again is not simulation


@parts
def test_a_process_that_does_not_import_it_refuses_in_one_line(part: str, files: dict[str, Path], fresh: Fresh) -> None:
    done = fresh("-m", "mol_compactons", "run", files[part], "-o", "again.nc")
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("mol-compactons: own_physics:")
    assert "--import own_physics" in done.stderr


def test_a_process_that_imports_it_repeats_every_file_bit_for_bit(
    files: dict[str, Path], fresh: Fresh, tmp_path: Path
) -> None:
    code = """
import sys
from mol_compactons.cli.parser import main
for path in sys.argv[1:]:
    assert main(["run", path, "--import", "own_physics", "--quiet"]) == 0
"""
    done = fresh("-c", code, *files.values())
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    for path in files.values():
        with open_result(path) as first, open_result(tmp_path / path.name) as again:
            xr.testing.assert_identical(first.drop_attrs(deep=False), again.drop_attrs(deep=False))
            assert first.attrs["simulation"] == again.attrs["simulation"]
            assert first.attrs["solver_steps"] == again.attrs["solver_steps"]


def test_a_result_can_be_looked_at_without_the_module(files: dict[str, Path], fresh: Fresh, tmp_path: Path) -> None:
    """What is in it, its picture and its tracks need the file alone."""
    said = fresh("-m", "mol_compactons", "info", files["equation"])
    assert (said.returncode, said.stderr) == (0, "")
    assert "equation: own_physics:LogKdV()" in said.stdout
    assert fresh("-m", "mol_compactons", "plot", files["equation"], "-o", "picture.png").returncode == 0
    assert (tmp_path / "picture.png").is_file()
    code = "import sys, pathlib; from mol_compactons import *; print(track(open_result(pathlib.Path(sys.argv[1]))).speed)"
    tracked = fresh("-c", code, files["equation"])
    assert (tracked.returncode, tracked.stderr) == (0, "")
    assert "own_physics" not in tracked.stdout


@pytest.mark.parametrize(
    ("module", "changes"),
    [
        ([], ["equation=own_physics:LogKdV()", "initial=[own_physics:GaussianWave(1, center=10)]"]),
        ([], ["equation=own_physics:LogKdV", "initial=[own_physics:GaussianWave(speed=1, center=10)]"]),
        (["--import", "own_physics"], ["equation=LogKdV()", "initial=[GaussianWave(1, 10)]", "integrator.rtol=1e-6"]),
        (["--import", Path(__file__).parent / "own_physics.py"], ["equation=LogKdV", "initial=[GaussianWave(1, 10)]"]),
    ],
)
def test_parts_can_be_set_on_the_command_line(module: list[Any], changes: list[str], fresh: Fresh, tmp_path: Path) -> None:
    """By "module:Class", which imports the module, or by the bare name after --import."""
    here = [*changes, "scheme=none", "grid=Grid(30, 120)", "t_end=0.5", "frames=3", "title=own"]
    options = [word for change in here for word in ("--set", change)]
    done = fresh("-m", "mol_compactons", "run", "single_compacton", "-o", "a.nc", "--quiet", *module, *options)
    assert (done.returncode, done.stderr) == (0, "")
    with open_result(tmp_path / "a.nc") as dataset:
        simulation = json.loads(dataset.attrs["simulation"])
        assert simulation["equation"]["type"] == "own_physics:LogKdV"
        assert simulation["initial"] == [{"type": "own_physics:GaussianWave", "speed": 1.0, "center": 10.0, "sign": 1}]


def test_a_study_can_be_read_without_the_module_and_judged_with_it(fresh: Fresh, tmp_path: Path) -> None:
    write_tree(converge(replace(SAMPLES["integrator"], frames=MANY)), tmp_path / "study.nc")
    assert "speed 0" in fresh("-m", "mol_compactons", "info", "study.nc").stdout
    code = "from mol_compactons import *; from pathlib import Path; judge(open_study(Path('study.nc')), 0.1)"
    assert "import own_physics first" in fresh("-c", code).stderr
    assert fresh("-c", "import own_physics; " + code).returncode == 0
    anew = judge(open_study(tmp_path / "study.nc"), accuracy=0.1)
    assert anew["summary"].to_dataset().sel(quantity="profile").verdict.item() == "converged"


def test_the_default_scheme_of_the_equation_is_central_and_the_own_one_checks_it() -> None:
    simulation = SAMPLES["equation"]
    assert type(simulation.scheme).__name__ == "CentralScheme"
    assert Family().completed(simulation).schemes == (simulation.scheme, own.PadeScheme())
    assert (
        replace(simulation, scheme=own.PadeScheme()).scheme.independent_alternative(own.LogKdV(), simulation.grid) is not None
    )


@pytest.mark.parametrize("integrator", [Midpoint(step=0.02), Rosenbrock(rtol=1e-6)])
def test_the_scheme_needs_no_jacobian_of_its_own(integrator: Any) -> None:
    """Implicit methods make it by differences, with its mass matrix."""
    simulation = replace(SAMPLES["scheme"], integrator=integrator, t_end=1, frames=2)
    assert relative_error(run(simulation).W.values[-1], exact(simulation, 1)) < 3e-4


def test_the_scheme_is_of_fourth_order() -> None:
    precise = replace(SAMPLES["equation"], scheme=own.PadeScheme(), integrator=IDA(rtol=1e-6), frames=2)
    results = [run(replace(precise, grid=Grid(30, size))).u.values[-1] for size in (60, 120)]
    errors = [relative_error(final, exact(replace(precise, grid=Grid(30, final.size)), 3)) for final in results]
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.3)


def test_the_integrator_is_of_fourth_order() -> None:
    coarse, fine = (replace(SAMPLES["integrator"], integrator=own.RungeKutta4(step), frames=2) for step in (0.2, 0.1))
    errors = [relative_error(run(simulation).R.values[-1], exact(simulation, 10)) for simulation in (coarse, fine)]
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.2)


def test_the_integrator_takes_a_mass_matrix_and_says_when_it_blows_up() -> None:
    simulation = replace(SAMPLES["equation"], scheme=own.PadeScheme(), t_end=0.5, frames=2)
    stable = replace(simulation, integrator=own.RungeKutta4(0.002))
    assert relative_error(run(stable).u.values[-1], exact(stable, 0.5)) < 1e-4
    with pytest.raises(InputError, match="mass matrix"):
        replace(simulation, integrator=CVODE())
    with pytest.raises(IntegrationError, match=r"choose a shorter integrator\.step"):
        run(replace(simulation, t_end=50, integrator=own.RungeKutta4(0.1)))


@pytest.mark.parametrize("form", ["stresses", "displacements"])
def test_the_soliton_is_exact_in_both_forms_of_the_chain(form: Any) -> None:
    chain = GranularChain(own.TodaContact(b=0.5), form=form, ends="free")
    waves = [own.TodaSoliton(1.3, center=15)]
    simulation = Simulation(chain, Lattice(60), waves, 10, frames=2, integrator=Symplectic(0.02, order=6))
    for component, name in enumerate(chain.variables):
        truth = waves[0].values(chain, simulation.grid, 10)[component]
        assert relative_error(run(simulation)[name].values[-1], truth) < 1e-8


def test_the_law_is_the_derivative_of_its_energy_and_has_its_stiffness() -> None:
    law, z, factor = own.TodaContact(b=1.5), np.linspace(-1, 1, 9), np.array([2.0])
    slope = (law.energy(z + 1e-6, factor) - law.energy(z - 1e-6, factor)) / 2e-6
    assert slope == pytest.approx(law.force(z, factor), abs=1e-8)
    slope = (law.force(z + 1e-6, factor) - law.force(z - 1e-6, factor)) / 2e-6
    assert slope == pytest.approx(law.stiffness(z, factor), rel=1e-8)
    pushed = law.static_compression(3.0, factor)
    assert law.force(pushed, factor) == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: own.GaussianWave(1, 10, sign=0), "GaussianWave.sign = 0 must be one of 1, -1"),
        (lambda: own.GaussianWave("fast", 10), "must be a number"),
        (lambda: own.TodaContact(b=-1), "must be positive"),
        (lambda: own.RungeKutta4(step=0), "must be positive"),
        (lambda: own.TodaSoliton(0.5, 10), "must lie between 1.001"),
        (
            lambda: replace(SAMPLES["scheme"], initial=[own.GaussianWave(1, 10)]),
            "is a wave of LogKdV, not of GranularCompacton",
        ),
        (lambda: replace(SAMPLES["equation"], initial=[Compacton(1, 10)]), "LogKdV has no compacton of closed form"),
        (
            lambda: replace(SAMPLES["equation"], initial=[own.TodaSoliton(2, 10)]),
            "is a wave of a GranularChain with",
        ),
        (lambda: replace(SAMPLES["law"], initial=[Compacton(1, 10)]), "The continuum of a chain of TodaContact contacts"),
        (
            lambda: replace(SAMPLES["law"], scheme=own.PadeScheme()),
            "PadeScheme is for LogKdV and GranularCompacton",
        ),
        (lambda: replace(SAMPLES["equation"], grid=Grid(30, 8)), "grid.size = 8 is too small"),
        (lambda: Family(schemes=(own.PadeScheme(),)).completed(SAMPLES["law"]), "a chain has no grid to refine"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(make: Callable[[], object], words: str) -> None:
    with pytest.raises(InputError) as refusal:
        make()
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)
