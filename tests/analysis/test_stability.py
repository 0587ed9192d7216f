from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from mol_compactons import CompactScheme, GranularCompacton, InputError
from mol_compactons.analysis.stability import (
    StabilityStudy,
    evolution_growth,
    exact_spectrum,
    integrals,
    report,
    scaled_functional,
    second_variation,
    verdict,
    verdicts,
)
from mol_compactons.assignment import assign
from tests.systems import fitted_order


@pytest.mark.parametrize("n", [1.2, 1.5, 2, 3, 4, 7])
@pytest.mark.parametrize("speed", [0.5, 1.0])
def test_the_integrals_are_the_integrals_and_obey_the_identity(n: float, speed: float) -> None:
    terms = integrals(n, speed)
    assert terms["I"] == pytest.approx((n - 1) / (n + 3) * terms["J"], rel=1e-12)
    shape = GranularCompacton(n).compacton(speed)
    half = shape.width / 2
    pull = quad(lambda z: float(shape(np.array([z]))[0]) ** (n + 1) / (n + 1), -half, half)[0]
    mass = quad(lambda z: float(shape(np.array([z]))[0]), -half, half)[0]
    assert terms["J"] == pytest.approx(pull, rel=1e-7)
    assert terms["mass"] == pytest.approx(mass, rel=1e-7)


def test_the_printed_limits_of_integration_break_the_identity() -> None:
    """Over +-pi/2 instead of +-pi/(2K), I = (n-1)/(n+3) J fails."""
    n = 3
    shape = GranularCompacton(n).compacton(1)

    def slope_part(z: float) -> float:
        point = np.array([z])
        return float((n + 1) / 4 * shape(point)[0] ** (n - 1) * shape.slope(point)[0] ** 2)

    stretch = quad(slope_part, -np.pi / 2, np.pi / 2)[0]
    pull = quad(lambda z: float(shape(np.array([z]))[0]) ** (n + 1) / (n + 1), -np.pi / 2, np.pi / 2)[0]
    assert abs(stretch / ((n - 1) / (n + 3) * pull) - 1) > 0.3


@pytest.mark.parametrize(
    ("n", "mass", "momentum", "energy"),
    [(2, 9 * np.pi / 4, 81 * np.pi / 64, -27 * np.pi / 32), (3, 4 * np.sqrt(2), np.pi, -np.pi / 2)],
)
def test_closed_forms(n: float, mass: float, momentum: float, energy: float) -> None:
    terms = integrals(n)
    assert (terms["mass"], terms["momentum"], terms["energy"]) == pytest.approx((mass, momentum, energy), rel=1e-13)


@pytest.mark.parametrize("n", [1.5, 2, 3, 4])
def test_the_functional_has_its_minimum_at_one_with_the_corrected_curvature(n: float) -> None:
    """Lambda' = 0 and Lambda'' = (n-1) J at lambda = 1, twice what the paper prints."""
    step = 1e-4
    below, middle, above = scaled_functional(n, np.array([1 - step, 1, 1 + step]))
    assert (above - below) / (2 * step) == pytest.approx(0, abs=1e-6)
    assert (above - 2 * middle + below) / step**2 == pytest.approx((n - 1) * integrals(n)["J"], rel=1e-5)


@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_the_second_variation_converges_to_the_poeschl_teller_spectrum(n: float) -> None:
    sizes = [100, 200, 400]
    errors = [np.abs(second_variation(n, size)["free"] - exact_spectrum(n)) for size in sizes]
    for mode in range(5):
        assert fitted_order(sizes, [float(error[mode]) for error in errors]) == pytest.approx(2, abs=0.1)
    assert errors[-1].max() < 2e-3


@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_the_report_counts_one_negative_direction_and_none_under_the_constraint(n: float) -> None:
    dataset = report(StabilityStudy(n=n, sizes=(50, 100, 200)))
    assert dataset.negative_directions.sel(constraint="free") == 1
    assert dataset.negative_directions.sel(constraint="constrained") == 0
    off = np.abs(dataset["value"].sel(constraint="free") - dataset["exact"])
    assert (off <= dataset["uncertainty"].sel(constraint="free")).all()
    assert float(dataset["value"].sel(constraint="constrained", mode=0)) == pytest.approx(0, abs=1e-4)
    assert set(dataset["wave"].values) == {"bright", "dark"}
    assert np.allclose(dataset["growth"].sel(wave="bright"), dataset["growth"].sel(wave="dark"), atol=1e-6)
    assert verdict(dataset) == "stable"
    assert verdicts(dataset)[-1].startswith("verdict: stable")


@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_the_limit_is_nearer_than_the_finest_value_and_the_bar_is_three_times_the_error_of_that(n: float) -> None:
    """Errors of the second order: a third of the last change, which is the correction."""
    dataset = report(StabilityStudy(n=n, sizes=(50, 100, 200))).sel(constraint="free")
    finest = abs(dataset["eigenvalue"].isel(resolution=-1) - dataset["exact"])
    assert (finest > 1e-6).all()
    assert (np.abs(dataset["value"] - dataset["exact"]) < finest / 20).all()
    assert dataset["uncertainty"].values == pytest.approx(3 * finest.values, rel=0.1)


@pytest.mark.parametrize("n", [1.2, 3.1, 3.3, 3.5, 4, 4.5, 4.9])
def test_the_error_bars_hold_the_exact_values(n: float) -> None:
    """For n > 3 the potential is singular and attractive and convergence slow: the bars must say so."""
    dataset = report(StabilityStudy(n=n, sizes=(50, 100, 200))).sel(constraint="free")
    assert (np.abs(dataset["value"] - dataset["exact"]) <= dataset["uncertainty"]).all()


def test_a_report_can_be_undecided() -> None:
    dataset = report(StabilityStudy(n=4.9, sizes=(20, 40, 80)))
    assert verdict(dataset) == "undecided"
    assert "undecided at these sizes" in verdicts(dataset)[-1]


def test_a_report_can_be_unstable() -> None:
    """Turned over, the functional of a compacton has negative directions that the constraint does not remove."""
    dataset = report(StabilityStudy(n=3, sizes=(20, 40, 80)))
    assert verdict(dataset.assign(value=-dataset["value"])) == "unstable"


@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("shift", [0.0, 0.25, 0.5])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_linearised_evolution_is_neutral_for_the_scheme_of_the_paper(n: float, shift: float, sign: int) -> None:
    assert abs(evolution_growth(CompactScheme("wide", viscosity=0), n, 120, shift, sign=sign)) < 1e-9


def test_the_linearised_evolution_finds_the_growth_of_the_nearest_neighbour_difference() -> None:
    """It falls with the grid: the scheme's, not the equation's."""
    rates = [evolution_growth(CompactScheme("nearest", 0), 3, size) for size in (100, 200, 400)]
    assert 0.01 < rates[2] < rates[1] < rates[0] < 0.1


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("n", "1", "larger than 1"),
        ("n", "5", "must be less than 5"),
        ("sizes", "100,200", "at least three"),
        ("sizes", "100,200,300", "must double"),
        ("sizes", "10,20,40", "start at 20"),
        ("sizes", "4000,8000,16000", "end at 3200 or less"),
        ("speed", "-1", "must be positive"),
    ],
)
def test_bad_input_is_named(field: str, value: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        assign(StabilityStudy(), {field: value})
