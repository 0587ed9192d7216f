from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    CVODE,
    IDA,
    Compacton,
    CompactScheme,
    GranularCompacton,
    Grid,
    InputError,
    Lattice,
    Nesterenko,
    RosenauHyman,
    Samples,
    Simulation,
    run,
)
from mol_compactons.equations.base import Array, Derivative, Equation
from mol_compactons.equations.custom import CustomEquation
from mol_compactons.schemes.base import best_scheme
from mol_compactons.schemes.central import CentralScheme, measured_reach
from mol_compactons.stencils import central
from tests.systems import (
    analytic_jacobian,
    difference_jacobian,
    fitted_order,
    random_state,
    relative_error,
    right_hand_side,
)

Order = Literal[2, 4, 6]
orders = st.sampled_from([2, 4, 6])
seeds = st.integers(0, 10**6)

ONE_WAY = [
    "3*u**2 + d2(u)",
    "u**3 + u*d2(u**2)",
    "abs(u)**1.5*sign(u) + abs(u)**0.25*d2(abs(u)**0.25*u)",
    "d1(u*d2(u)) + sin(u)*d3(u**2)",
    "u*tanh(u) + sqrt(1 + d1(u)**2) + exp(-u**2)*d1(d1(u))",
    "max(u, d1(u)) + abs(d2(u))*x + cos(t)*u/(2 + u**2)",
]
KDV = CustomEquation("3*u**2 + d2(u)")

polynomials = st.recursive(
    st.sampled_from(["u", "0.5", "-2", "u**2", "u**3"]),
    lambda inner: st.one_of(
        st.builds("({} {} {})".format, inner, st.sampled_from("+-*"), inner),
        st.builds("{}(0.1*({}))".format, st.sampled_from(["d1", "d2", "d3"]), inner),
        st.builds("{}({})".format, st.sampled_from(["sin", "tanh"]), inner),
    ),
    max_leaves=6,
)
"""Formulas at random, with derivatives nested as they come."""


@dataclass(frozen=True)
class LogKdV(Equation):
    """An equation of one's own by a class: F = u log|u| + u_xx, which knows no derivatives."""

    variables = ("u",)

    def local_flux(self, t: float, x: Array, state: Array, derivative: Derivative) -> Array:
        size = np.abs(state[0]) + 1e-300
        return np.asarray(state[0] * np.log(size) + derivative(state[0], 2))


def final(equation: Equation, grid: Grid, initial: Array, t_end: float, scheme: Any = None, **changes: Any) -> Any:
    """The result of a run that starts with given numbers."""
    settings = {"frames": 3, "integrator": CVODE(rtol=1e-5), **changes}
    samples = Samples(tuple(initial.ravel()))
    return run(Simulation(equation=equation, grid=grid, initial=[samples], t_end=t_end, scheme=scheme, **settings))


@given(st.sampled_from(ONE_WAY), orders, st.sampled_from([4, 6]), seeds)
def test_jacobian_is_the_derivative(text: str, order: Order, damping: Literal[4, 6], seed: int) -> None:
    equation = CustomEquation(text, source="-0.3*u + d2(u)*u + sin(x)*d1(u)**2")
    scheme = CentralScheme(order, grid_viscosity=0.03, viscosity_order=damping)
    system = scheme.discretize(equation, Grid(length=10, size=31))
    state = random_state(seed, 1, 31)
    state += 0.1 * np.sign(state)
    matrix = analytic_jacobian(system, state)
    assert np.allclose(matrix, difference_jacobian(system, state), atol=1e-6 * np.abs(matrix).max())


@given(polynomials, st.sampled_from([2, 4]), seeds)
def test_jacobian_and_mass_of_formulas_at_random(text: str, order: Order, seed: int) -> None:
    grid = Grid(length=30, size=97)
    system = CentralScheme(order).discretize(CustomEquation(text), grid)
    state = 0.5 * random_state(seed, 1, grid.size)
    rate = right_hand_side(system, state)
    assert abs(rate.sum()) <= 1e-13 * (np.abs(rate).sum() + grid.size)
    matrix = analytic_jacobian(system, state)
    assert np.allclose(matrix, difference_jacobian(system, state), atol=1e-6 * np.abs(matrix).max() + 1e-9)


@given(orders, seeds)
def test_jacobian_of_a_two_way_equation(order: Order, seed: int) -> None:
    equation = CustomEquation("u**2 + v*d2(u**2) + v**3", "-0.1*v + u*d2(v) + d1(u*d1(v))", two_way=True)
    system = CentralScheme(order, viscosity=0.01).discretize(equation, Grid(length=10, size=19))
    state = random_state(seed, 2, 19)
    matrix = analytic_jacobian(system, state)
    assert np.allclose(matrix, difference_jacobian(system, state), atol=1e-7 * np.abs(matrix).max())


@given(st.sampled_from(ONE_WAY), orders, seeds)
def test_mass_is_conserved_to_round_off(text: str, order: Order, seed: int) -> None:
    system = CentralScheme(order, grid_viscosity=0.1).discretize(CustomEquation(text), Grid(length=10, size=31))
    rate = right_hand_side(system, random_state(seed, 1, 31))
    assert abs(rate.sum()) <= 1e-13 * np.abs(rate).sum()


@given(st.sampled_from(["3*u**2 + d2(u)", "u**3 + u*d2(u**2)", "sin(u) + cos(u)*d2(sin(u))"]), st.booleans(), orders, seeds)
def test_energy_is_conserved_by_the_semi_discretisation(text: str, two_way: bool, order: Order, seed: int) -> None:
    """dH/dt along the flow, by a central difference of the reported energy."""
    system = CentralScheme(order).discretize(CustomEquation(text, two_way=two_way), Grid(length=10, size=24))
    state = random_state(seed, 2 if two_way else 1, 24)
    rate = right_hand_side(system, state)
    step = 1e-5 / np.abs(rate).max()
    ahead, behind = system.invariants(state + step * rate), system.invariants(state - step * rate)
    scale = abs(system.invariants(state)["energy"]) + 1
    assert abs(ahead["energy"] - behind["energy"]) <= 1e-9 * scale


@given(st.sampled_from(["u**3 + u*d2(u**2)", ONE_WAY[2], "sin(u) + d2(u)*cos(u)"]), orders, seeds, st.integers(0, 30))
def test_symmetries_of_odd_formulas(text: str, order: Order, seed: int, shift: int) -> None:
    """u -> -u to the last bit, and a shift to round-off."""
    system = CentralScheme(order, grid_viscosity=0.03).discretize(CustomEquation(text), Grid(length=10, size=31))
    state = random_state(seed, 1, 31)
    rate = right_hand_side(system, state)
    assert np.array_equal(right_hand_side(system, -state), -rate)
    scale = np.abs(rate).max()
    assert np.allclose(right_hand_side(system, np.roll(state, shift)), np.roll(rate, shift), atol=1e-12 * scale)


@pytest.mark.parametrize("order", [2, 4, 6])
def test_order_on_a_manufactured_solution(order: Order) -> None:
    """u = 2 + sin(x - t) solves u_t + (u^2 + u u_xx)_x = cos(x - t)."""
    equation = CustomEquation("u**2 + u*d2(u)", source="cos(x - t)")
    sizes, errors, t = [24, 36, 54], [], 0.7
    for size in sizes:
        grid = Grid(length=2 * np.pi, size=size)
        rate = np.empty((1, size))
        CentralScheme(order).discretize(equation, grid).rhs(t, (2 + np.sin(grid.x - t))[None], rate)
        errors.append(float(np.abs(rate[0] + np.cos(grid.x - t)).max()))
    assert fitted_order(sizes, errors) == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize("order", [2, 4, 6])
def test_order_in_two_way_form(order: Order) -> None:
    """u = 2 + sin(x - c t), v = c sin(x - c t) solve v_t + (u^2 / 2 - d2(u))_x = s."""
    equation = CustomEquation(
        "u**2/2 - d2(u)", "(3 - c**2 + sin(x - c*t))*cos(x - c*t) + k*(c*sin(x - c*t) - v)", {"c": 1.5, "k": 2}, two_way=True
    )
    sizes, errors, t, c = [24, 36, 54], [], 0.7, 1.5
    for size in sizes:
        grid = Grid(length=2 * np.pi, size=size)
        phase = grid.x - c * t
        rate = np.empty((2, size))
        CentralScheme(order).discretize(equation, grid).rhs(t, np.array([2 + np.sin(phase), c * np.sin(phase)]), rate)
        errors.append(float(np.abs(rate + np.array([c * np.cos(phase), c**2 * np.cos(phase)])).max()))
    assert fitted_order(sizes, errors) == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize("integrator", [IDA(rtol=1e-6), CVODE(rtol=1e-6)])
def test_a_run_with_a_source_follows_the_manufactured_solution(integrator: Any) -> None:
    grid = Grid(length=2 * np.pi, size=48)
    equation = CustomEquation("u**2 + u*d2(u)", "cos(x - t) + mu*(2 + sin(x - t) - u)", {"mu": 0.5})
    result = final(equation, grid, 2 + np.sin(grid.x), 2.0, CentralScheme(6), integrator=integrator)
    assert relative_error(result.u.values[-1], 2 + np.sin(grid.x - 2)) < 5e-7


def test_a_loss_takes_the_mass_away_at_its_rate() -> None:
    """With s = -nu u the mass is m exp(-nu t), whatever the flux."""
    grid = Grid(length=40, size=200)
    start = Compacton(1, 10).values(RosenauHyman(2, 2), grid)
    result = final(CustomEquation("u**2 + d2(u**2)", "-nu*u", {"nu": 0.3}), grid, start, 4.0)
    mass = result.mass.values
    assert mass[-1] == pytest.approx(mass[0] * np.exp(-0.3 * 4), rel=1e-5)
    assert result.mass.attrs["role"] == "diagnostic"


def soliton(x: Array, speed: float) -> Array:
    """The soliton of u_t + 6 u u_x + u_xxx = 0."""
    return np.asarray(speed / 2 / np.cosh(np.sqrt(speed) / 2 * x) ** 2)


def test_an_absorbing_layer_takes_a_wave_out() -> None:
    grid = Grid(length=40, size=200)
    equation = CustomEquation("3*u**2 + d2(u)", "exp(-((x - 30)/4)**2)*(d2(u) - u)")
    result = final(equation, grid, soliton(grid.x - 10, 1.0), 40.0, integrator=CVODE(rtol=1e-3))
    assert np.abs(result.u.values[-1]).max() < 0.1 * np.abs(result.u.values[0]).max()


def test_kdv_carries_its_soliton() -> None:
    grid = Grid(length=60, size=240, left=-20)
    result = final(KDV, grid, soliton(grid.x, 1.0), 20.0, CentralScheme(6))
    assert relative_error(result.u.values[-1], soliton(grid.x - 20, 1.0)) < 1e-3
    assert abs(result.mass.values[-1] / result.mass.values[0] - 1) < 1e-12
    assert result.energy.values[-1] == pytest.approx(result.energy.values[0], rel=1e-5)


def test_gardner_carries_its_soliton() -> None:
    """u_t + 6 u u_x - 6 a u^2 u_x + u_xxx = 0 has u = c / (1 + sqrt(1 - a c) cosh(sqrt(c) (x - c t)))."""

    def exact(x: Array) -> Array:
        return np.asarray(1 / (1 + np.sqrt(1 - a) * np.cosh(x)))

    a, grid = 0.8, Grid(length=60, size=240, left=-20)
    equation = CustomEquation("3*u**2 - 2*a*u**3 + d2(u)", parameters={"a": a})
    result = final(equation, grid, exact(grid.x), 20.0, CentralScheme(6))
    assert relative_error(result.u.values[-1], exact(grid.x - 20)) < 1e-3


def test_the_formula_of_k22_carries_its_compacton() -> None:
    grid = Grid(length=40, size=400)
    equation, wave = RosenauHyman(2, 2), Compacton(1, 10)
    result = final(CustomEquation("u**2 + d2(u**2)"), grid, wave.values(equation, grid), 10.0)
    assert relative_error(result.u.values[-1], wave.values(equation, grid, 10.0)[0]) < 1e-4


def peak(grid: Grid, u: Array) -> float:
    """The place of the highest point, between the grid points by trigonometric interpolation."""
    fine = np.fft.irfft(np.fft.rfft(u), n=64 * u.size)
    top = int(np.argmax(fine))
    left, middle, right = fine[top - 1], fine[top], fine[top + 1]
    return float(grid.left + grid.spacing / 64 * (top + 0.5 * (left - right) / (left - 2 * middle + right)))


def test_two_solitons_of_kdv_pass_each_other_with_the_exact_shifts() -> None:
    """Speeds 1 and 1/4: the fast one gains log(3) / k with k = 1/2, the slow one loses log(3) / k with k = 1/4."""
    grid, t_end = Grid(length=180, size=450, left=-60), 110.0
    start = soliton(grid.x + 30, 1.0) + soliton(grid.x, 0.25)
    (u,) = final(KDV, grid, start, t_end, CentralScheme(6), integrator=CVODE(rtol=1e-4)).u.values[-1:]
    between = -30 + t_end - 15
    fast = peak(grid, np.where(grid.x > between, u, 0))
    slow = peak(grid, np.where(grid.x < between, u, 0))
    assert fast - (-30 + t_end) == pytest.approx(2 * np.log(3), rel=0.01)
    assert slow - 0.25 * t_end == pytest.approx(-4 * np.log(3), rel=0.01)


@pytest.mark.parametrize("equation", [GranularCompacton(2), RosenauHyman(3, 3), Nesterenko(3)])
def test_it_takes_the_equations_that_are_built_in(equation: Equation) -> None:
    """Without exact derivatives the reach is measured, and the Jacobian made by differences."""
    grid = Grid(length=10, size=25)
    system = CentralScheme(4).discretize(equation, grid)
    assert system.reach == 4
    state = 1 + 0.3 * random_state(0, len(equation.variables), 25)
    matrix = analytic_jacobian(system, state)
    assert np.allclose(matrix, difference_jacobian(system, state), atol=1e-6 * np.abs(matrix).max())


def test_it_takes_a_class_of_ones_own() -> None:
    """log-KdV has the Gaussian exp(1/2 + c - x^2 / 4) of any speed c, here 1; as a class and as a formula alike."""
    grid = Grid(length=30, size=120, left=-15)
    gauss = np.exp(0.5 + 1 - grid.x**2 / 4)
    equations = (LogKdV(), CustomEquation("u*log(abs(u) + 1e-300) + d2(u)"))
    systems = [CentralScheme(6).discretize(equation, grid) for equation in equations]
    rates = [right_hand_side(system, gauss[None]) for system in systems]
    np.testing.assert_allclose(rates[0], rates[1], atol=1e-12)
    np.testing.assert_allclose(rates[0][0], grid.x / 2 * gauss, atol=2e-3)
    assert best_scheme(LogKdV(), Grid(10, 100), 1.0) == CentralScheme(4, viscosity_order=6)


def test_a_flux_that_is_not_local_is_refused() -> None:
    class Mean(LogKdV):
        def local_flux(self, t: float, x: Array, state: Array, derivative: Derivative) -> Array:
            return np.asarray(state[0] * state[0].mean())

    with pytest.raises(InputError, match="couples points 48 apart; CentralScheme takes a local flux only"):
        CentralScheme().discretize(Mean(), Grid(length=10, size=200))


def test_the_reach_is_measured_through_all_derivatives() -> None:
    equation = CustomEquation("d1(u*d2(u))", source="d3(d3(u))")
    stencils = {k: central(k, 4).scaled(0.1) for k in (1, 2, 3)}
    assert equation.linearized(stencils).reach == measured_reach(equation, Grid(10, 100), stencils) == 6


def test_what_is_taken_where_nothing_is_said() -> None:
    """No damping where ripples disperse at rest; else one in proportion to the speed, larger where the flux is not odd."""
    grid = Grid(10, 100)
    for formula, amount in (("3*u**2 + d2(u)", 0), ("u**2 + d2(u**2) + 0.1*d2(u)", 0), ("u**3 + u*d2(u**2)", 0.06)):
        assert best_scheme(CustomEquation(formula), grid, 2.0).viscosities == pytest.approx((0, amount))
    for formula in ("u**2 + d2(u**2)", "u + u**2 + d2(u**2)", "u**2"):
        assert best_scheme(CustomEquation(formula), grid, 2.0).viscosities == pytest.approx((0, 2 * 0.01 / 0.1**2))
    assert best_scheme(CustomEquation("u**2 + u*d2(u)", background=1), grid, 2.0) == CentralScheme(4, viscosity_order=6)
    check = CompactScheme().independent_alternative(KDV, grid)
    assert isinstance(check, CentralScheme)
    assert CentralScheme().label == "CentralScheme(order=4)"


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match="must not be negative"):
        CentralScheme(viscosity=-1e-3)
    with pytest.raises(InputError, match="one of 2, 4, 6"):
        CentralScheme(order=3)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"grid.size = 8 is too small: the central scheme of order 4 couples 9 neighbours"):
        CentralScheme().discretize(KDV, Grid(length=10, size=8))
    with pytest.raises(InputError, match="not for CustomEquation on a Lattice"):
        CentralScheme().discretize(KDV, Lattice(20))
    with pytest.raises(InputError, match="not positive at x = 0"):
        CentralScheme().discretize(CustomEquation("u**2", "log(x)*u"), Grid(length=10, size=20))
