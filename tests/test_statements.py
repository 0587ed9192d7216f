"""Statements 1 to 3 of the paper: the Hamiltonian form, the conservation of H and Q, and the compacton as a critical point."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import Compacton, GranularCompacton, Grid, RosenauHyman
from mol_compactons.analysis.residuals import interior_residual
from mol_compactons.equations.nesterenko import Nesterenko
from tests.systems import Array

GRID = Grid(length=2 * np.pi, size=64)


def derivative(values: Array, order: int = 1) -> Array:
    """A spectral derivative on the grid; odd orders drop the wave of two grid points."""
    factor = (1j * GRID.wavenumbers) ** order
    if order % 2:
        factor[-1] = 0
    return np.fft.irfft(factor * np.fft.rfft(values), n=GRID.size)


def energy(equation: GranularCompacton, w: Array) -> float:
    """The energy of the package, with spectral derivatives."""
    return equation.invariants(w[None], GRID.spacing, lambda values: derivative(values, 2))["energy"]


def flux(equation: GranularCompacton, w: Array) -> Array:
    """The flux of the package, with spectral derivatives."""
    out = np.empty_like(w)
    equation.dispersive_flux.convective(w, out)
    return out + equation.dispersive_flux.b(w) * derivative(equation.dispersive_flux.g(w), 2)


def smooth_state(seed: int, mean: float) -> Array:
    """A smooth random state about a mean, well resolved; with a small mean it changes its sign."""
    rng = np.random.default_rng(seed)
    waves = sum(rng.normal() / 2**k * np.cos(k * GRID.x + rng.uniform(0, 6)) for k in range(1, 5))
    return mean + 0.5 * np.asarray(waves)


CASES = st.tuples(st.sampled_from([1.5, 2.0, 2.7, 3.0, 4.0, 5.0]), st.sampled_from([3.0, -3.0])) | st.tuples(
    st.sampled_from([3.0, 5.0]), st.just(0.1)
)
"""n and the mean of the state: of one sign for any n, of both signs where the flux is smooth through zero."""


@given(CASES, st.integers(0, 1000))
def test_the_energy_is_that_of_the_paper(case: tuple[float, float], seed: int) -> None:
    """H = Int (n+1)/4 |W|^(n-1) W_x^2 - |W|^(n+1) / (n+1)."""
    n, mean = case
    w = smooth_state(seed, mean)
    density = (n + 1) / 4 * np.abs(w) ** (n - 1) * derivative(w) ** 2 - np.abs(w) ** (n + 1) / (n + 1)
    assert energy(GranularCompacton(n), w) == pytest.approx(GRID.spacing * float(density.sum()), rel=1e-9, abs=1e-9)


@given(CASES, st.integers(0, 1000))
def test_statement_1_the_flux_is_the_variational_derivative(case: tuple[float, float], seed: int) -> None:
    """W_t = d/dx of dH/dW: the flux is minus the variational derivative of H, here by central differences of H."""
    n, mean = case
    equation, w, direction, step = GranularCompacton(n), smooth_state(seed, mean), smooth_state(seed + 1, 1), 1e-5
    slope = (energy(equation, w + step * direction) - energy(equation, w - step * direction)) / (2 * step)
    predicted = -GRID.spacing * float(flux(equation, w) @ direction)
    assert slope == pytest.approx(predicted, rel=1e-6, abs=1e-6)


@given(CASES, st.integers(0, 1000))
def test_statement_2_energy_and_momentum_are_conserved(case: tuple[float, float], seed: int) -> None:
    """dQ/dt = Int W_x F = 0 and dH/dt = Int F F_x = 0, to the accuracy of the spectral sums."""
    n, mean = case
    w = smooth_state(seed, mean)
    f = flux(GranularCompacton(n), w)
    assert abs(float(derivative(w) @ f)) < 1e-8 * float(np.abs(derivative(w)) @ np.abs(f))
    assert abs(float(derivative(f) @ f)) < 1e-8 * float(np.abs(derivative(f)) @ np.abs(f))


@pytest.mark.parametrize("n", [1.5, 2, 2.5, 3, 4])
@pytest.mark.parametrize("sign", [1, -1])
def test_statement_3_along_random_directions(n: float, sign: int) -> None:
    """dH/dW + c W = 0 on the support: with dH/dW = -F that is the balance F = c W, at random points."""
    points = np.random.default_rng(7).uniform(-0.98, 0.98, 50)
    balance = interior_residual(Compacton(1.3, 0, sign), GranularCompacton(n), points)
    assert np.abs(balance).max() < 1e-13 * abs(GranularCompacton(n).compacton(1.3).amplitude)


@pytest.mark.parametrize("n", [1.5, 2, 2.5, 3, 4, 5])
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0])
def test_statement_3_the_compacton_is_a_critical_point(n: float, sign: int, speed: float) -> None:
    """nu H + c Q is stationary at the compacton, nu = -1 for dark waves with even n in the paper's H without |W|.

    With the odd extension nu = 1 throughout. The derivative of the functional along stretched and scaled compactons,
    a W_c(b z), has closed forms in I, J, Q: dH/da = (n+1) H, dQ/da = 2 Q; dH/db = I + J, dQ/db = -Q at a = b = 1.
    """
    shape = GranularCompacton(n).compacton(speed, sign)
    z = np.linspace(-0.5, 0.5, 400_001)[1:-1] * shape.width
    step = z[1] - z[0]
    w, slope = shape(z), shape.slope(z)
    stretch = (n + 1) / 4 * step * float((np.abs(w) ** (n - 1) * slope**2).sum())
    pull = step * float((np.abs(w) ** (n + 1)).sum()) / (n + 1)
    momentum = 0.5 * step * float(w @ w)
    assert (n + 1) * (stretch - pull) + speed * 2 * momentum == pytest.approx(0, abs=1e-5 * pull)
    assert stretch + pull - speed * momentum == pytest.approx(0, abs=1e-5 * pull)


def test_the_energies_of_the_other_equations_are_conserved() -> None:
    """K(m,m): Int u^m u_t = 0. Nesterenko: d/dt Int v^2/2 + E[S] = 0 with S_t = -v_x, v_t = -F_x."""
    u = smooth_state(3, 3)
    for m in (2, 3):
        f = u**m + derivative(u**m, 2)
        assert abs(float((u**m) @ derivative(f))) < 1e-9 * float(np.abs(u**m) @ np.abs(derivative(f)))
        assert RosenauHyman(m, m).dispersive_flux.variational_constant is None
    equation = Nesterenko(n=2, strength=1.3, grain_distance=0.4, prestress=0.7)
    stress, velocity = smooth_state(4, 3), smooth_state(5, 0)
    g = equation.dispersive_flux.g(stress)
    out = np.empty_like(stress)
    equation.dispersive_flux.convective(stress, out)
    f = out + equation.dispersive_flux.b(stress) * derivative(g, 2)
    step = 1e-5

    def total(s: Array, v: Array) -> float:
        return equation.invariants(np.array([s, v]), GRID.spacing, lambda values: derivative(values, 2))["energy"]

    rates = -derivative(velocity), -derivative(f)
    change = (
        total(stress + step * rates[0], velocity + step * rates[1])
        - total(stress - step * rates[0], velocity - step * rates[1])
    ) / (2 * step)
    assert abs(change) < 1e-7 * abs(total(stress, velocity))
