"""Multipliers with their bars: against matrices whose eigenvalues are known, rounded and defective ones among them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons.analysis import floquet
from mol_compactons.analysis.floquet import CERTAIN, DENSE, FEWEST, changes, spectrum, verdict
from mol_compactons.analysis.orbits import Orbit, Period, advance_with_derivative, close
from tests.analysis.test_orbits import advection, gauss
from tests.systems import Array


def orbit_of(matrix: Array, components: int = 1, uncertainty: float = 0.0) -> Orbit:
    size = matrix.shape[0] // components
    return Orbit(np.ones((components, size)), matrix, residual=0.0, uncertainty=uncertainty, correction=0.0)


def rotated(matrix: Array, seed: int) -> Array:
    """The same in other orthonormal axes."""
    axes = np.linalg.qr(np.random.default_rng(seed).normal(size=matrix.shape))[0]
    return np.asarray(axes @ matrix @ axes.T)


def test_linear_advection_has_the_multipliers_of_its_fourier_modes() -> None:
    size, period = 16, Period(1.3, 1, 5)
    found = spectrum(close(advection(size, 0.7), np.ones((1, size)), period))
    theta = 2 * np.pi * np.fft.fftfreq(size)
    exact = np.array([gauss(4)(-0.7j * np.sin(t) * 1.3 / 5) ** 5 * np.exp(1j * t) for t in theta])
    distance = np.abs(found.values[:, None] - exact).min(axis=1)
    assert np.abs(exact[:, None] - found.values).min(axis=1).max() < 1e-12
    assert (distance <= found.errors).all()
    assert found.errors.max() < 1e-11
    assert np.abs(found.values) == pytest.approx(np.ones(size), abs=1e-13)
    assert verdict(found.values, found.errors) == "stable"


def test_damped_advection_lies_inside_and_grown_advection_outside() -> None:
    for decay, expected in ((0.05, "stable"), (-0.05, "unstable")):
        system = advection(16, 0.7, decay)
        own = advance_with_derivative(system, np.ones((1, 16)), Period(1.0))[1]
        found = spectrum(orbit_of(own))
        assert np.abs(found.values[0]) == pytest.approx(np.exp(-decay), rel=1e-6)
        assert verdict(found.values, found.errors) == expected


def test_modes_are_unit_eigenvectors_with_the_largest_first() -> None:
    matrix = np.random.default_rng(3).normal(size=(12, 12))
    found = spectrum(orbit_of(matrix, components=2))
    assert found.modes.shape == (12, 12)
    assert np.linalg.norm(found.modes, axis=1) == pytest.approx(np.ones(12))
    assert np.abs(matrix @ found.modes.T - found.modes.T * found.values).max() < 1e-12
    assert (np.diff(np.abs(found.values)) <= 1e-12).all()
    assert found.values.sum() == pytest.approx(np.trace(matrix))


@given(seed=st.integers(0, 1000), size=st.integers(3, 12))
def test_the_bars_hold_what_rounding_does_to_a_normal_matrix(seed: int, size: int) -> None:
    exact = np.random.default_rng(seed).uniform(-1, 1, size)
    found = spectrum(orbit_of(rotated(np.diag(exact), seed)))
    gaps = np.abs(found.values[:, None] - exact).min(axis=1)
    assert (gaps <= found.errors).all()
    assert found.errors.max() < 1e-12


@given(seed=st.integers(0, 1000), coupling=st.floats(1e-2, 1e3))
def test_the_bars_of_a_double_multiplier_hold_its_true_value(seed: int, coupling: float) -> None:
    """A Jordan block is split by rounding to about the root of it; the bar of simple ones is then without bound."""
    matrix = np.diag([1.0, 1.0, 0.5, -0.2, 0.1])
    matrix[0, 1] = coupling
    found = spectrum(orbit_of(rotated(matrix, seed)))
    pair = np.abs(found.values - 1).argsort()[:2]
    assert (np.abs(found.values[pair] - 1) <= found.errors[pair]).all()
    assert found.errors[pair].max() < 3e-6 * max(1.0, coupling)
    assert verdict(found.values, found.errors) == "stable"


def test_a_double_multiplier_that_is_not_split_at_all_has_the_bar_of_one_that_is() -> None:
    matrix = np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.3]])
    found = spectrum(orbit_of(matrix))
    assert np.array_equal(found.values[:2], [1, 1])
    assert (found.errors[:2] > 1e-8).all()
    assert (found.errors[:2] < 1e-6).all()
    assert verdict(found.values, found.errors) == "stable"


@given(seed=st.integers(0, 1000), size=st.floats(1e-12, 1e-6))
def test_the_bars_hold_what_the_uncertainty_of_the_orbit_does(seed: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    triangle = np.diag([1.0, 1.0, -0.9, 0.4, 0.3, 0.0]) + np.diag([3.0, 0, 0.5, 0, 0.2], 1)
    matrix = rotated(triangle, seed)
    change = rng.normal(size=(6, 6))
    change *= size * np.linalg.norm(matrix, 2) / np.linalg.norm(change, 2)
    found = spectrum(orbit_of(matrix + change, uncertainty=size))
    assert (np.abs(found.values[:, None] - np.diag(triangle)).min(axis=1) <= found.errors).all()


@given(seed=st.integers(0, 1000))
def test_weights_that_make_a_matrix_normal_are_found(seed: int) -> None:
    """D B D^-1 has the multipliers of B, and as small bars, however uneven D is."""
    exact = np.linspace(-1, 1, 12)
    weights = 10.0 ** np.random.default_rng(seed).uniform(-8, 8, 12)
    found = spectrum(orbit_of(rotated(np.diag(exact), seed) * weights[:, None] / weights))
    assert (np.abs(found.values[:, None] - exact).min(axis=1) <= found.errors).all()
    assert found.errors.max() < 1e-12


def test_a_window_follows_its_cells_alone() -> None:
    matrix = np.random.default_rng(3).normal(size=(12, 12))
    cells = np.array([True, False, True, True, False, True])
    kept = np.flatnonzero(np.tile(cells, 2))
    found = spectrum(orbit_of(matrix, components=2), cells)
    assert np.sort_complex(found.values) == pytest.approx(np.sort_complex(np.linalg.eigvals(matrix[np.ix_(kept, kept)])))
    assert found.modes.shape == (8, 12)
    assert not found.modes[:, ~np.tile(cells, 2)].any()


def test_arnoldis_method_agrees_with_the_dense_one(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(4)
    matrix = rotated(np.diag(np.r_[1.3, -1.2, 1.1, 1.05, 1.0, 0.9, 0.8, rng.uniform(-0.6, 0.6, 193)]), 4)
    matrix += 0.02 * rng.normal(size=matrix.shape) / np.sqrt(200)
    dense = spectrum(orbit_of(matrix))
    assert dense.values.size == 200 < DENSE
    monkeypatch.setattr(floquet, "DENSE", 100)
    few = spectrum(orbit_of(matrix))
    assert few.values.size == FEWEST
    assert few.values == pytest.approx(dense.values[:FEWEST], abs=1e-12)
    assert (np.abs(few.values - dense.values[:FEWEST]) <= few.errors + dense.errors[:FEWEST]).all()
    assert few.errors.max() < 1e-9
    overlap = np.abs(np.sum(few.modes.conj() * dense.modes[:FEWEST], axis=1))
    assert overlap == pytest.approx(np.ones(FEWEST), abs=1e-9)


def test_where_arnoldis_method_finds_nothing_the_dense_one_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    nothing = (np.empty(0, dtype=complex), np.empty((40, 0), dtype=complex))
    monkeypatch.setattr(floquet, "DENSE", 10)
    monkeypatch.setattr(floquet, "_arnoldi", lambda matrix, count: nothing)
    assert spectrum(orbit_of(np.diag(np.linspace(0, 1, 40)))).values.size == 40


def test_changes_are_those_of_the_modulus_to_the_nearest() -> None:
    values, others = np.array([1j, -1.1, 0.5]), np.array([-1.0, 0.6, 1.02j, 0.4])
    assert changes(values, others) == pytest.approx([0.02, 0.1, 0.1])


@pytest.mark.parametrize(
    ("values", "errors", "expected"),
    [
        ([1.07, 1.0], [1e-6, 1e-9], "unstable"),
        ([-1.07, 1.0], [0.1, 1e-9], "undecided"),
        ([1.0 + 1e-9, 1.0], [1e-8, 1e-9], "stable"),
        ([1.0, 1.0], [1e-8, 10 * CERTAIN], "undecided"),
        ([1.0, 0.3], [1e-8, 10.0], "stable"),
        ([0.8j, 1e-9], [1e-9, 1e-9], "stable"),
    ],
)
def test_the_verdict_follows_from_the_values_and_their_bars(values: list[complex], errors: list[float], expected: str) -> None:
    assert verdict(np.array(values, dtype=complex), np.array(errors)) == expected
