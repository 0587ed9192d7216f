from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mol_compactons import (
    Compacton,
    CompactScheme,
    ConservativeScheme,
    Family,
    Formula,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    IntegrationError,
    Lattice,
    Nesterenko,
    PowerContact,
    Rosenbrock,
    Samples,
    Simulation,
    Symplectic,
    Wave,
    converge,
    run,
)

GAUSSIAN = "1 + exp(-(x - 20)**2 / 8) / 2"
GRID = Grid(length=40, size=120)
EQUATION = GranularCompacton(n=3)


def gaussian(x: np.ndarray) -> np.ndarray:
    return np.asarray(1 + np.exp(-((x - 20) ** 2) / 8) / 2)


def written(path: Path, header: bool = True) -> str:
    rows = [f"{x!r},{u!r}" for x, u in zip(GRID.x.tolist(), gaussian(GRID.x).tolist(), strict=True)]
    path.write_text("\n".join(["x,u", *rows] if header else rows), encoding="utf-8")
    return str(path)


@pytest.fixture
def three(tmp_path: Path) -> list[Wave]:
    """One Gaussian by formula, by CSV and by array."""
    return [Formula(GAUSSIAN), Samples(file=written(tmp_path / "wave.csv")), Samples(gaussian(GRID.x))]  # type: ignore[arg-type]


def simulation(wave: Wave, **changes: Any) -> Simulation:
    one = Simulation(
        equation=EQUATION,
        grid=GRID,
        scheme=ConservativeScheme(order=4, grid_viscosity=0.03, viscosity_order=6),
        initial=[wave],
        t_end=4,
        frames=21,
        integrator=Rosenbrock(rtol=1e-5),
    )
    return replace(one, **changes)


def test_three_ways_to_one_run(three: list[Wave]) -> None:
    results = [run(simulation(wave)) for wave in three]
    assert np.abs(results[0].W.values[-1] - results[0].W.values[0]).max() > 0.1
    for other in results[1:]:
        assert np.abs(other.W.values - results[0].W.values).max() < 1e-12


def test_all_three_converge_alike(three: list[Wave]) -> None:
    """On grids where the samples have to be interpolated, and on theirs; the last profile agrees to the error bars."""
    family = Family(sizes=(60, 120, 240), schemes=(ConservativeScheme(order=4),), grid_viscosities=(0.06, 0.03))
    summaries = [converge(simulation(wave, t_end=1), family)["summary"].to_dataset() for wave in three]
    judged = [summary.sel(limit="conservative", quantity="profile") for summary in summaries]
    first = judged[0]
    assert float(first.error / first.scale) < 0.01
    for other in judged[1:]:
        assert float(other.value) == pytest.approx(float(first.value), rel=1e-7)
        assert float(other.error) == pytest.approx(float(first.error), rel=1e-3)


def test_smooth_samples_are_interpolated_by_their_series() -> None:
    """Finer, coarser and shifted: to round-off, where a spline has 1e-4."""
    coarse = Samples(gaussian(GRID.x), places=GRID.x)  # type: ignore[arg-type]
    for grid in (Grid(40, 240), Grid(40, 100), Grid(40, 60), Grid(40, 77, left=3.21), Grid(40, 120, left=-7.5)):
        x = (grid.x - 0.0) % 40
        assert np.abs(coarse.values(EQUATION, grid)[0] - gaussian(x)).max() < 1e-12


def test_kinks_are_interpolated_without_overshoot() -> None:
    """A compacton with a kink, from 64 points on 200: nowhere below zero or above its height."""
    wave, few, many = Compacton(speed=1, center=20), Grid(40, 64), Grid(40, 200)
    coarse = wave.values(EQUATION, few)
    fine = Samples(coarse).values(EQUATION, many)  # type: ignore[arg-type]
    assert fine.min() >= 0
    assert fine.max() <= coarse.max()
    error = np.linalg.norm(fine - wave.values(EQUATION, many)) / np.linalg.norm(wave.values(EQUATION, many))
    assert error < 0.03


def test_uneven_places_and_a_gap_across_the_end() -> None:
    places = np.sort(np.random.default_rng(3).uniform(1, 39, 400))
    values = Samples(gaussian(places), places=places).values(EQUATION, GRID)[0]  # type: ignore[arg-type]
    assert np.abs(values - gaussian(GRID.x)).max() < 5e-3


def test_numbers_of_other_kinds_are_numbers() -> None:
    speed = Fraction(1, 4)
    assert Compacton(speed, xr.DataArray(3.0)).speed == 0.25  # type: ignore[arg-type]
    assert Compacton(np.array(2.0), np.float32(3)) == Compacton(2, 3)  # type: ignore[arg-type]
    assert Grid(length=Fraction(30), size=np.int64(60)) == Grid(30, 60)  # type: ignore[arg-type]
    assert Samples(xr.DataArray([1.0, 2.0])) == Samples((1, 2))  # type: ignore[arg-type]


RUNS = [
    Simulation(EQUATION, Grid(30, 120), [Compacton(1, 8), Compacton(1 / 4, 20, sign=-1)], t_end=12, frames=4),
    Simulation(Nesterenko(1.5), Grid(20, 40), [Compacton(1, 6)], t_end=2, frames=3),
    Simulation(Nesterenko(1.5), Grid(20, 80), [Compacton(1, 6)], t_end=0.3, frames=3, scheme=CompactScheme(viscosity=1e-3)),
    Simulation(GranularChain(PowerContact(1.5)), Lattice(40), [Compacton(1, 12)], t_end=9, frames=3),
    Simulation(
        GranularChain(PowerContact(1.5), form="displacements", ends="fixed"),
        Lattice(20),
        [Samples(np.concatenate([np.linspace(0.1, -0.1, 20), np.zeros(20)]))],  # type: ignore[arg-type]
        t_end=9,
        frames=3,
        integrator=Symplectic(step=0.01),
    ),
]


@pytest.mark.parametrize("before", RUNS)
def test_the_last_frame_of_a_run_is_initial_data(before: Simulation, tmp_path: Path) -> None:
    """From the file or from its Dataset, also where a wave has undershot or a grain is at a wall."""
    path = tmp_path / "before.nc"
    try:
        dataset = run(before, path)
    except IntegrationError as error:
        dataset = error.dataset
    last = np.array([dataset[name].values[-1] for name in before.equation.variables])
    for wave in (Samples(last), Samples(file=str(path))):  # type: ignore[arg-type]
        again = replace(before, initial=[wave], t_end=before.t_end / 10)
        assert np.array_equal(again.initial_state(), last)
        assert Simulation.from_json(again.to_json()) == again
    if before.equation.variables == ("S", "v"):
        assert last[0].min() < 0
    after = run(replace(before, initial=[Samples(last)], t_end=0.1, frames=2))  # type: ignore[arg-type]
    assert np.array_equal(after[before.equation.variables[0]].values[0], last[0])


def test_a_frame_by_its_time_and_a_variable_by_its_name(tmp_path: Path) -> None:
    dataset = run(RUNS[0], tmp_path / "run.nc")
    found = Samples(file=str(tmp_path / "run.nc"), variable="W", t=4.1).values(EQUATION, Grid(30, 120))
    assert np.array_equal(found[0], dataset.W.sel(t=4, method="nearest").values)


def test_what_was_read_is_stored(tmp_path: Path) -> None:
    """The file may be gone when the run is repeated."""
    path = tmp_path / "wave.csv"
    one = simulation(Samples(file=written(path, header=False)))
    path.unlink()
    again = Simulation.from_json(one.to_json())
    assert np.array_equal(again.initial_state()[0], gaussian(GRID.x))


def bad(text: str) -> Callable[[Path], Any]:
    def attempt(folder: Path) -> Any:
        (folder / "bad.csv").write_text(text, encoding="utf-8")
        return Samples(file=str(folder / "bad.csv"))

    return attempt


@pytest.mark.parametrize(
    ("attempt", "words"),
    [
        (lambda folder: Samples(), "holds no numbers; give values_at_points, or the name of a file"),
        (lambda folder: Samples(file=str(folder / "none.csv")), "There is no file"),
        (lambda folder: Samples(file=str(folder / "none.nc")), "There is no file"),
        (bad("x,u\n1,2\n2,three\n"), "Line 3 of .*, '2, three', holds what is no number"),
        (bad("x,u\n1,2\n2,3,4\n"), "must have the same columns in each line"),
        (bad(""), "must have the same columns"),
        (bad("1,2\n1,3\n"), "must ascend"),
        (lambda folder: Samples((1, 2, float("nan"))), "must be finite"),
        (
            lambda folder: simulation(Samples((1, 2))),
            "holds 2 numbers .* give 120 numbers, or 1 for each of at least 5",
        ),
        (lambda folder: simulation(Samples(np.ones(9), places=np.arange(9) * 7.0)), "reach over 56"),  # type: ignore[arg-type]
        (lambda folder: simulation(Formula("1/(x - 20)")), "x = 20"),
        (lambda folder: simulation(Formula("exp(x*x*x)")), "is not finite at x = 9;"),
        (lambda folder: Formula("exp(-y)"), "'y'"),
        (lambda folder: simulation(Formula("x", second="x")), "is for equations with two components"),
        (
            lambda folder: Simulation(GranularChain(PowerContact(2)), Lattice(8), [Samples(np.ones(6))], t_end=1),  # type: ignore[arg-type]
            "on 8 points; give 16 numbers",
        ),
    ],
)
def test_bad_data_is_one_sentence(attempt: Callable[[Path], Any], words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words) as caught:
        attempt(tmp_path)
    assert str(caught.value).count("\n") == 0


def test_formulas_of_two_components() -> None:
    """The second is zero where none is given; parameters stand in both."""
    equation, grid = Nesterenko(3), Grid(length=4, size=4, left=1)
    both = Formula("a*x", second="x**2 - a", parameters={"a": 3}).values(equation, grid)
    assert both.tolist() == [[3.0, 6.0, 9.0, 12.0], [-2.0, 1.0, 6.0, 13.0]]
    assert Formula("x").values(equation, grid).tolist() == [[1.0, 2.0, 3.0, 4.0], [0.0] * 4]
    assert Formula("2").values(GranularChain(PowerContact(2)), Lattice(3)).tolist() == [[2.0] * 3, [0.0] * 3]
    with pytest.raises(InputError, match=r"Formula\.second = 'exp\(300\*x\)' is not finite at x = 3;"):
        Formula("x", second="exp(300*x)").values(equation, grid)


def test_samples_of_two_components_are_the_first_and_then_the_second() -> None:
    numbers = np.arange(16.0)
    for values in (numbers, numbers.reshape(2, 8)):
        wave = Samples(values)  # type: ignore[arg-type]
        assert wave.values(Nesterenko(3), Grid(8, 8)).tolist() == [list(range(8)), list(range(8, 16))]
        assert wave.values(GranularChain(PowerContact(2)), Lattice(8)).tolist() == [list(range(8)), list(range(8, 16))]
    with pytest.raises(InputError, match=r"holds 16 numbers at 3 places, .* give 16 numbers, or 2 for each of at least 5"):
        Samples(numbers, places=(0, 1, 2)).values(Nesterenko(3), Grid(8, 8))  # type: ignore[arg-type]
