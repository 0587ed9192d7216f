from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from mol_compactons import Compacton, Formula, GranularCompacton, Grid, Simulation, run
from mol_compactons.analysis.drift import drift
from mol_compactons.analysis.summary import kept
from tests.systems import one_compacton


def series(values: list[float], magnitude: float | None = None) -> xr.Dataset:
    sizes = {} if magnitude is None else {"magnitude": magnitude}
    return xr.Dataset(
        {"mass": ("t", values, {"role": "conserved", **sizes})},
        {"t": np.arange(len(values))},
        {"format": 2, "status": "complete"},
    )


@pytest.mark.parametrize(
    ("values", "magnitude", "scale", "meaning"),
    [
        ([2.0, 2.0, 1.0], 2.0, 2.0, "its first value"),
        ([-2e-30, -2e-30, -1e-30], 2e-30, 2e-30, "its first value"),
        ([1e-17, 0.5, -1.0], 4.0, 4.0, "the sum of the sizes of its parts"),
        ([0.0, 0.5, -1.0], None, 1.0, "its largest value"),
        ([0.0, 0.0, 0.0], 0.0, 0.0, "its largest value"),
    ],
)
def test_what_a_drift_is_relative_to(values: list[float], magnitude: float | None, scale: float, meaning: str) -> None:
    change = drift(series(values, magnitude)).mass
    assert change.attrs["scale"] == scale
    assert change.attrs["relative_to"] == meaning
    assert np.array_equal(change.values, (np.array(values) - values[0]) / (scale or 1))


@settings(max_examples=20)
@given(st.floats(-12, 12), st.sampled_from([1.5, 2, 3]))
def test_it_does_not_depend_on_the_size_of_the_wave(power: float, n: float) -> None:
    """W -> r W: all of a run is scaled, and the drift says the same of it, however small the wave."""
    r = 10**power
    system = Simulation(GranularCompacton(n), Grid(40, 80), [Compacton(1, 20)], t_end=1).discretize()
    state = Compacton(1, 20).values(GranularCompacton(n), Grid(40, 80))
    later = 0.9 * np.roll(state, 3)
    found = []
    for factor in (1.0, r):
        first, last = (system.invariants(factor * one) for one in (state, later))
        sizes = system.magnitudes(factor * state)
        found.append([float(drift(series([first[q], last[q]], sizes[q])).mass[1]) for q in ("mass", "momentum", "energy")])
    assert np.all(np.abs(found[0]) > 0.01)
    assert found[1] == pytest.approx(found[0], rel=1e-9)


def test_cancelling_masses_are_measured_by_their_sizes() -> None:
    """A bright wave and its mirror image have no mass together; what it drifts by counts against that of both."""
    waves = [Compacton(1, 8), Compacton(1, 22, sign=-1)]
    dataset = run(Simulation(GranularCompacton(3), Grid(30, 150), waves, t_end=1, frames=3))
    assert abs(float(dataset.mass[0])) < 1e-14
    change = drift(dataset).mass
    assert change.attrs["scale"] == pytest.approx(2 * 4 * np.sqrt(2), rel=1e-3)
    assert "mass to" in kept(dataset)
    assert "of the sum of the sizes of its parts" in kept(dataset)


def test_a_lost_tenth_is_not_hidden_by_a_small_wave() -> None:
    """With a loose absolute tolerance a small wave loses much of its energy, and the report says so."""
    small = GranularCompacton(1.5).compacton(1e-4).amplitude
    formula = f"{small}*cos((x - 20)/5)**4*heaviside(2.5*pi - abs(x - 20))"
    coarse = Simulation(GranularCompacton(1.5), Grid(40, 40), [Formula(formula)], t_end=1e5, frames=3)
    dataset = run(coarse)
    lost = float(abs(dataset.energy - dataset.energy[0]).max() / abs(dataset.energy[0]))
    change = drift(dataset).energy
    assert float(abs(change).max()) == pytest.approx(lost, rel=1e-12)
    assert lost > 1e-6


def test_a_run_keeps_what_it_should() -> None:
    dataset = run(one_compacton(size=300, viscosity=0.0, integrator=None))
    changes = drift(dataset)
    assert float(np.abs(changes.mass).max()) < 1e-12
    assert float(np.abs(changes.energy).max()) < 1e-5
    assert dataset.energy[0] == pytest.approx(-np.pi / 2, rel=1e-2)
    assert dataset.momentum[0] == pytest.approx(np.pi, rel=1e-4)
    assert dataset.mass[0] == pytest.approx(4 * np.sqrt(2), rel=1e-3)


def test_the_order_in_time_changes_nothing() -> None:
    result = series([2.0, 2.0, 1.0])
    change = drift(result)
    assert change.mass.values.tolist() == [0, 0, -0.5]
    xr.testing.assert_identical(drift(result.isel(t=slice(None, None, -1))), change)
