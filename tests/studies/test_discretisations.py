from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from mol_compactons import (
    Compacton,
    CompactScheme,
    ConservativeScheme,
    Family,
    FourierScheme,
    GranularCompacton,
    Grid,
    InputError,
    Midpoint,
    PeriodicWave,
    Simulation,
    converge,
    judge,
    run,
)
from mol_compactons.studies import compare_schemes
from mol_compactons.studies.family import Member
from tests.chain.chains import ring
from tests.studies.by_hand import LENGTH, SIMULATION, UNIT, exact, spacing, study

SMOOTH = Simulation(
    equation=GranularCompacton(3),
    grid=Grid(length=2 * np.pi, size=64),
    scheme=ConservativeScheme(order=4),
    initial=[PeriodicWave(speed=1, crest=1.5**0.5)],
    t_end=0.5,
    frames=3,
    integrator=Midpoint(step=0.01, order=4),
)

ORDERS = {
    CompactScheme("wide"): 2,
    CompactScheme("five_point"): 4,
    ConservativeScheme(order=2): 2,
    ConservativeScheme(order=4): 4,
}


@pytest.fixture(scope="module")
def smooth() -> xr.DataTree:
    """Four schemes and the Fourier scheme on a smooth wave."""
    return converge(SMOOTH, Family(sizes=(16, 32, 64), schemes=(*ORDERS, FourierScheme()), tolerances=(0.02, 0.01)))


def test_each_scheme_shows_its_order_on_a_smooth_wave(smooth: xr.DataTree) -> None:
    table = smooth["schemes"].to_dataset()
    assert table["reference"].item() == "the exact wave"
    for scheme, order in ORDERS.items():
        own = table.sel(scheme=scheme.label, n=3)
        assert float(own["order"].sel(size=64)) == pytest.approx(order, abs=0.15)
        assert np.isnan(own["order"].sel(size=16))
        assert float(own["fitted_order"]) == pytest.approx(order, abs=0.6)
        assert (np.diff(own["error"].values) < 0).all()
    fourier = table.sel(scheme=FourierScheme().label, n=3)
    assert float(fourier["order"].sel(size=32)) > 8
    assert np.isnan(fourier["order"].sel(size=64)), "the error of time hides that of space"


def test_errors_drifts_and_costs_are_those_of_the_runs(smooth: xr.DataTree) -> None:
    table = smooth["schemes"].to_dataset()
    scheme, size = ConservativeScheme(order=4), 32
    own = table.sel(scheme=scheme.label, size=size, n=3)
    result = run(replace(SMOOTH, scheme=scheme, grid=replace(SMOOTH.grid, size=size)))
    wave = SMOOTH.initial[0].values(SMOOTH.equation, Grid(2 * np.pi, size), SMOOTH.t_end)[0]
    assert float(own["error"]) == pytest.approx(np.linalg.norm(result.W.values[-1] - wave) / np.linalg.norm(wave), rel=1e-10)
    assert float(own["momentum_drift"]) == pytest.approx(
        float(abs(result.momentum - result.momentum[0]).max() / result.momentum[0]), rel=1e-10
    )
    assert own["solver_steps"].item() == result.attrs["solver_steps"]
    assert own["integrator"].item() == "Midpoint"
    assert own["status"].item() == "complete"
    assert smooth["members"][own["member"].item()].attrs["label"] == own["member"].item()


@given(st.floats(1, 4), st.floats(-3, -1))
@settings(max_examples=10)
def test_a_deviation_of_any_rate_is_seen_as_its_order(rate: float, exponent: float) -> None:
    tree = judge(study(lambda member: 10**exponent * (spacing(member) / 0.5) ** rate))
    table = tree["schemes"].to_dataset()
    assert table.sizes["n"] == 1
    own = table.isel(scheme=0, n=0)
    coarse = 10**exponent * UNIT / exact()
    assert float(own["error"].sel(size=60)) == pytest.approx(coarse, rel=0.02)
    assert float(own["fitted_order"]) == pytest.approx(rate, abs=0.02)
    assert float(own["order"].sel(size=240)) == pytest.approx(rate, abs=0.02)


def test_a_scheme_that_failed_has_its_reason_and_no_number() -> None:
    def fails(member: Member) -> bool:
        return member.scheme.startswith("Compact") and member.size == 240

    table = judge(study(lambda member: 1e-3 * spacing(member) ** 2, fails=fails))["schemes"].to_dataset().isel(n=0)
    dead = table.sel(scheme=CompactScheme("wide").label)
    assert dead["status"].sel(size=240).item() == "failed: as a test"
    assert np.isnan(dead["error"].sel(size=240))
    assert np.isfinite(dead["error"].sel(size=120))
    assert np.isnan(dead["fitted_order"])


def test_without_an_exact_wave_errors_are_those_against_the_profile_of_the_study_or_a_finer_run() -> None:
    pair = replace(SIMULATION, initial=[Compacton(1, 10), Compacton(0.5, 22)], t_end=1, frames=5)
    family = Family(sizes=(75, 150, 300), schemes=(ConservativeScheme(order=2), ConservativeScheme(order=4)))
    tree = converge(replace(pair, grid=Grid(LENGTH, 300)), replace(family, grid_viscosities=(0.0,), tolerances=(1e-5, 1e-6)))
    own = tree["schemes"].to_dataset().isel(n=0)
    assert own["reference"].item().startswith("the profile")
    judged = tree["summary"].to_dataset().sel(quantity="profile").isel(limit=0)
    assert float(own["reference_error"]) == pytest.approx(float(judged["error"] / judged["scale"]))
    finer = [run(replace(pair, scheme=ConservativeScheme(order=6), grid=Grid(LENGTH, size))) for size in (600, 1200)]
    by_run = compare_schemes(tree, finer).isel(n=0)
    assert by_run["reference"].item() == "a run on 1200 points"
    assert float(by_run["reference_error"]) < 1e-4
    true = np.linalg.norm(finer[1].W.values[-1][::16] - tree["members"][by_run["member"].values[0, 0]].W.values)
    assert float(by_run["error"][0, 0]) == pytest.approx(true / np.linalg.norm(finer[1].W.values[-1][::16]), rel=1e-10)
    np.testing.assert_allclose(own["error"].sel(size=75), by_run["error"].sel(size=75), rtol=0.1)
    with pytest.raises(InputError, match="double the first"):
        compare_schemes(tree, [finer[0], run(replace(pair, grid=Grid(LENGTH, 900)))])


def test_a_chain_has_no_discretisations() -> None:
    tree = converge(ring(t_end=1), Family(tolerances=(0.1, 0.05)))
    assert "schemes" not in tree.children
    with pytest.raises(InputError, match="A chain has no discretisations"):
        compare_schemes(tree)


def test_the_page_says_what_plain_xarray_says(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Its code runs as it stands, and prints what stands below it."""
    docs = Path(__file__).parents[2] / "docs"
    monkeypatch.chdir(docs)
    page = (docs / "discretisations.md").read_text(encoding="utf-8")
    names: dict[str, object] = {}
    pairs = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", page, re.DOTALL)
    assert len(pairs) == 4
    for code, expected in pairs:
        exec(code, names)
        assert capsys.readouterr().out.strip() == expected.strip()


def test_the_orders_of_the_study_are_those_of_the_page_on_schemes() -> None:
    docs = Path(__file__).parents[2] / "docs"
    page = (docs / "schemes.md").read_text(encoding="utf-8")
    with xr.open_dataset(docs / "discretisations.nc") as study:
        orders = study["fitted_order"].load()
    tables = {
        ("smooth wave", 3.0): page.split("## Observed orders")[1].split("The Fourier error")[0],
        **{("compacton", n): page.split(f"\nn = {n:g}:\n")[1].split("\nn = ")[0].split("\n## ")[0] for n in (1.5, 2.0, 3.0)},
    }
    compared = 0
    for (problem, n), table in tables.items():
        for scheme, rate in re.findall(r"^\| ([^|]+) \|.*\| ([\d.]+) \|$", table, re.MULTILINE):
            own = float(orders.sel(problem=problem, n=n, scheme=scheme))
            if np.isfinite(own):
                assert own == pytest.approx(float(rate), abs=0.006)
                compared += 1
    assert compared == 6 + 3 + 4 + 4
