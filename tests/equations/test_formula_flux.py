from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import GranularCompacton
from mol_compactons.equations.formula_flux import FormulaFlux, dispersive_form
from mol_compactons.expressions import parse
from tests.systems import Array

POINTS = np.array([-2.3, -1.0, -0.2, 0.4, 1.1, 3.0])


def form(text: str, background: float = 0.0) -> FormulaFlux | None:
    return dispersive_form(parse(text, "flux", ("u",), derivatives=True), "u", background)


def values(flux: FormulaFlux, u: Array = POINTS) -> tuple[Array, Array, Array]:
    b, g, a = np.empty((3, u.size))
    flux.evaluate(u, b, g, a)
    return a, b, g


@pytest.mark.parametrize(
    ("text", "a", "bg"),
    [
        ("u**2/2 + d2(u)", POINTS**2 / 2, (1, POINTS)),
        ("u**3 + u*d2(u**2)", POINTS**3, (POINTS, POINTS**2)),
        ("2*d2(u**2) - 3*d2(u**2) + u", POINTS, (-1, POINTS**2)),
        ("-(u*d2(u)/2) + 1", np.ones(6), (-POINTS / 2, POINTS)),
        ("u*d2(u) + u*d2(u**2)", np.zeros(6), (POINTS, POINTS + POINTS**2)),
        ("u**2", POINTS**2, (0, 0 * POINTS)),
        ("d2(2*u*u) + u*0", np.zeros(6), (2, POINTS**2)),
    ],
)
def test_a_formula_is_taken_apart(text: str, a: Array, bg: tuple[float | Array, Array]) -> None:
    """What counts is a, and the product b g up to how a constant is shared."""
    flux = form(text)
    assert flux is not None
    found_a, found_b, found_g = values(flux)
    assert found_a == pytest.approx(a, abs=1e-14)
    assert found_b * found_g == pytest.approx(np.broadcast_to(bg[0], 6) * bg[1], abs=1e-13)


@pytest.mark.parametrize(
    "text", ["d2(u)**2", "d2(d2(u))", "u + d1(u)", "d2(u)*d2(u)", "1/d2(u)", "u*d2(u) + d2(u**2)", "sin(d2(u))"]
)
def test_another_form_is_none(text: str) -> None:
    assert form(text) is None


@given(st.sampled_from(["u**3 + u*d2(u**2)", "sin(u) + cos(u)*d2(exp(u/2))", "u**2 + d2(u**3)"]), st.floats(-2, 2))
def test_slopes_are_derivatives(text: str, place: float) -> None:
    flux = form(text)
    assert flux is not None
    u, step = np.array([place]), 1e-5
    b, g, a = np.empty((3, 1))
    flux.slopes(u, b, g, a)
    ahead, behind = values(flux, u + step), values(flux, u - step)
    for slope, high, low in zip((a, b, g), ahead, behind, strict=True):
        assert slope == pytest.approx((high - low) / (2 * step), rel=1e-6, abs=1e-7)


def test_the_granular_flux_as_a_formula_is_the_granular_flux() -> None:
    """n = 3: u^3 + u (u^2)_xx, with kappa = 1/2 and the same density of energy."""
    flux, own = form("u**3 + u*d2(u**2)"), GranularCompacton(3).dispersive_flux
    assert flux is not None
    mine, b, g, a = np.empty((4, 6))
    own.evaluate(POINTS, b, g, a)
    for found, expected in zip(values(flux), (a, b, g), strict=True):
        assert found == pytest.approx(expected, rel=1e-14)
    assert flux.variational_constant == pytest.approx(0.5, rel=1e-12) == pytest.approx(own.variational_constant)
    mine[:] = flux.energy_parts(POINTS, np.cos(POINTS)).sum(axis=0)
    assert mine == pytest.approx(own.energy_parts(POINTS, np.cos(POINTS)).sum(axis=0), rel=1e-12)


@given(st.sampled_from([0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0]), st.floats(0.1, 3))
def test_the_potential_of_a_power_is_exact(power: float, place: float) -> None:
    """A(u) = u^(p+1) / (p+1), by a quadrature, for powers by quarters too."""
    flux = form(f"u**{power}")
    assert flux is not None
    potential, _ = flux.energy_parts(np.array([place]), np.zeros(1))
    assert potential == pytest.approx([place ** (power + 1) / (power + 1)], rel=1e-12)


def test_a_potential_vanishes_at_the_background() -> None:
    flux = form("u**2", background=1.0)
    assert flux is not None
    potential, _ = flux.energy_parts(np.array([1.0, 2.0]), np.zeros(2))
    assert potential == pytest.approx([0.0, 7 / 3], abs=1e-14)


@pytest.mark.parametrize(
    ("text", "kappa"),
    [("u**2 + d2(u)", 1.0), ("3*u*d2(u**2)", 1.5), ("u**2", 0.0), ("u + d2(u**2)", None), ("exp(u)*d2(exp(u))", 1.0)],
)
def test_whether_there_is_an_energy(text: str, kappa: float | None) -> None:
    flux = form(text)
    assert flux is not None
    assert flux.variational_constant == (None if kappa is None else pytest.approx(kappa, rel=1e-9))


def test_terms_that_differ_in_a_number_alone_are_two() -> None:
    flux = form("d2(sin(2*u)) - 3*d2(sin(5*u))")
    assert flux is not None
    a, b, g = values(flux)
    assert b * g == pytest.approx(np.sin(2 * POINTS) - 3 * np.sin(5 * POINTS), abs=1e-13)
    assert not a.any()
    assert form("u**2*d2(u**2) + u**3*d2(u**3)") is None


def test_the_energy_has_two_parts() -> None:
    """u^2 + 3 u (u^2)_xx: A = u^3 / 3, kappa = 3/2, and (kappa / 2) g g_xx."""
    flux = form("u**2 + 3*u*d2(u**2)")
    assert flux is not None
    second = np.cos(POINTS)
    potential, dispersive = flux.energy_parts(POINTS, second)
    assert potential == pytest.approx(POINTS**3 / 3, rel=1e-12)
    assert dispersive == pytest.approx(0.75 * POINTS**2 * second, rel=1e-9)
