from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import IDA, Compacton, CompactScheme, Grid, InputError, RosenauHyman, Simulation, run


def test_a_k22_compacton_keeps_its_speed_and_height_over_five_widths() -> None:
    """Speed to 1e-3, height to 1e-2; it sheds less than 1e-3 of its height and 1e-6 of Int u^2 (3.4e-4 and 6e-8 seen)."""
    grid = Grid(length=40, size=800)
    simulation = Simulation(
        equation=RosenauHyman(2, 2),
        grid=grid,
        scheme=CompactScheme("wide", viscosity=1e-4),
        initial=[Compacton(1, 10)],
        t_end=63,
        frames=2,
        integrator=IDA(rtol=1e-5),
    )
    u = run(simulation).u.values[-1]
    peak = int(u.argmax())
    curvature, slope, _ = np.polyfit([-1, 0, 1], u[peak - 1 : peak + 2], 2)
    place = grid.spacing * (peak - slope / (2 * curvature))
    assert simulation.t_end > 5 * 4 * np.pi
    assert 1 + (place - 33) / 63 == pytest.approx(1, abs=1e-3)
    assert u.max() == pytest.approx(4 / 3, rel=1e-2)
    shed = u[np.abs(grid.offset(place)) > 2 * np.pi + 0.5]
    assert np.abs(shed).max() < 1e-3 * u.max()
    assert (shed**2).sum() < 1e-6 * (u**2).sum()


@pytest.mark.parametrize("m", [1.5, 2, 2.5, 3, 4])
@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0])
def test_the_compacton_solves_the_equation(m: float, speed: float) -> None:
    """c u = u^m + (u^m)_xx on the support, which is the equation integrated once; by a difference of the fourth order."""
    equation = RosenauHyman(m, m, absolute=m != int(m))
    shape = equation.compacton(speed)
    z, step = np.linspace(-0.4, 0.4, 9) * shape.width, 1e-3 * shape.width

    def g(points: np.ndarray) -> np.ndarray:
        return np.asarray(shape(points) ** m)

    second = (-g(z + 2 * step) + 16 * g(z + step) - 30 * g(z) + 16 * g(z - step) - g(z - 2 * step)) / (12 * step**2)
    assert np.allclose(g(z) + second, speed * shape(z), rtol=1e-7)


@given(st.sampled_from([1.5, 2.0, 3.0, 4.5]), st.floats(0.1, 5))
def test_height_and_width(m: float, speed: float) -> None:
    """M^(m-1) = 2 c m / (m+1) and the width 2 pi m / (m-1), whatever the speed."""
    shape = RosenauHyman(m, m, absolute=True).compacton(speed)
    assert shape.amplitude ** (m - 1) == pytest.approx(2 * speed * m / (m + 1), rel=1e-10)
    assert shape.width == pytest.approx(2 * np.pi * m / (m - 1), rel=1e-12)
    assert RosenauHyman(m, m, absolute=True).compacton_speed(shape.amplitude) == pytest.approx(speed, rel=1e-10)


def test_dark_waves_move_left_only_where_the_power_is_even() -> None:
    assert RosenauHyman(2, 2).compacton(-1, -1).amplitude == pytest.approx(-4 / 3)
    assert RosenauHyman(3, 3).compacton(1, -1).amplitude == pytest.approx(-np.sqrt(1.5))
    assert RosenauHyman(2, 2, absolute=True).compacton(1, -1).amplitude == pytest.approx(-4 / 3)
    assert [RosenauHyman(2, 2).is_odd, RosenauHyman(3, 3).is_odd, RosenauHyman(2, 2, absolute=True).is_odd] == [
        False,
        True,
        True,
    ]


def test_the_two_forms_agree_where_the_wave_is_positive() -> None:
    state = np.linspace(0.1, 2, 7)
    classical, absolute = (RosenauHyman(2, 4, form).dispersive_flux for form in (False, True))
    values = np.empty((2, 3, 7))
    for flux, out in zip((classical, absolute), values, strict=True):
        flux.evaluate(state, *out)
    assert np.allclose(values[0], values[1], rtol=1e-14)
    assert np.allclose(values[0], [np.ones(7), state**4, state**2], rtol=1e-14)
    for flux, out in zip((classical, absolute), values, strict=True):
        flux.evaluate(-state, *out)
    assert np.allclose(values[0, 1:], [state**4, state**2], rtol=1e-14)
    assert np.allclose(values[1, 1:], [-(state**4), -(state**2)], rtol=1e-14)


def test_mass_and_energy_of_the_compacton_of_k_2_2() -> None:
    """u = (4/3) cos^2(z / 4): Int u = 8 pi / 3, Int u^3 / 3 = (4/3)^3 (5 pi / 4) / 3."""
    grid = Grid(length=20, size=2000)
    state = Compacton(1, 10).values(RosenauHyman(2, 2), grid)
    found = RosenauHyman(2, 2).invariants(state, grid.spacing, lambda values: values)
    assert found["mass"] == pytest.approx(8 * np.pi / 3, rel=1e-6)
    assert found["energy"] == pytest.approx((4 / 3) ** 3 * 5 * np.pi / 12, rel=1e-6)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: RosenauHyman(2, 3).compacton(1), "known to this program for m = n larger than 1 only"),
        (lambda: RosenauHyman(0.5, 2), "m = 0.5 must be at least 1"),
        (lambda: RosenauHyman(2.5, 2.5), "whole number in the classical form; set absolute=True"),
        (lambda: RosenauHyman(2, 2).compacton(-1), r"wrong sign for a bright wave of K\(2, 2\); it must be positive"),
        (lambda: RosenauHyman(2, 2).compacton(1, -1), r"wrong sign for a dark wave of K\(2, 2\); it must be negative"),
        (lambda: RosenauHyman(3, 3).compacton(-1, -1), "must be positive"),
    ],
)
def test_bad_input_is_named(make: Callable[[], object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        make()
