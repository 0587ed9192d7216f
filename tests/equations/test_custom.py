from __future__ import annotations

import pickle
from typing import Any

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
    Midpoint,
    PowerLaw,
    PowerLawEquation,
    Rosenbrock,
    Samples,
    Simulation,
    Uniform,
    run,
)
from mol_compactons.assignment import assign
from mol_compactons.equations.base import Equation
from mol_compactons.equations.custom import CustomEquation
from mol_compactons.stencils import central
from tests.systems import analytic_jacobian, difference_jacobian, random_state, right_hand_side

GRANULAR = {
    1.5: "abs(W)**0.5*W + abs(W)**0.25*d2(abs(W)**0.25*W)",
    2: "abs(W)*W + sqrt(abs(W))*d2(sqrt(abs(W))*W)",
    3: "W**3 + W*d2(W**2)",
}
"""The granular compacton equation as a formula."""


def difference(values: Any, order: int) -> Any:
    return central(order, 4).apply(np.ascontiguousarray(values), 0.25)


def kdv(**changes: Any) -> CustomEquation:
    return CustomEquation(**{"flux": "3*u**2 + d2(u)", **changes})


def test_it_is_stored_sent_and_compared() -> None:
    equation = CustomEquation("W**p + W*d2(W**2)", "-nu*W", {"nu": 0.1, "p": 3}, variable="W")
    simulation = Simulation(equation=equation, grid=Grid(10, 40), initial=[Samples((0.5,) * 40)], t_end=1)
    again = Simulation.from_json(simulation.to_json())
    assert again == simulation
    assert again.equation == pickle.loads(pickle.dumps(equation)) == equation
    assert hash(again.equation) == hash(equation)
    assert equation != CustomEquation("W**p + W*d2(W**2)", "-nu*W", {"nu": 0.2, "p": 3}, variable="W")
    changed: Any = assign(simulation, {"equation.source": "-nu*W + 0*x", "equation.parameters.nu": "0.3"}).equation
    assert (changed.source, changed.parameters["nu"], changed.flux) == ("-nu*W + 0*x", 0.3, equation.flux)


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ({"flux": "u**2 + q"}, "CustomEquation.flux = .*'q', there is an unknown name"),
        ({"source": "-nu*u"}, "CustomEquation.source = .*'nu', there is an unknown name"),
        ({"source": "v"}, "CustomEquation.source = .*'v', there is an unknown name"),
        ({"flux": ""}, "CustomEquation.flux is empty"),
        ({"parameters": {"nu": 1}}, "has 'nu', which stands in no formula; take it out"),
        ({"parameters": {"u": 1}}, "the name 'u' is given twice"),
        ({"parameters": {"x": 1}}, "the name 'x' is given twice"),
        ({"parameters": {"lambda": 1}}, "'lambda' has a meaning in formulas already; choose another, such as lambda0"),
        ({"parameters": {"e": 1}}, "'e' has a meaning in formulas already"),
        ({"parameters": {"a b": 1}}, "must consist of letters, digits and underscores"),
        ({"parameters": {"nu": "x"}}, "CustomEquation.parameters = .* must be names, each with a number"),
        ({"variable": "sin"}, "'sin' has a meaning in formulas already"),
        ({"variable": "v", "two_way": True, "flux": "v"}, "the name 'v' is given twice"),
        ({"flux": "u**1.5"}, r"raises 'u', which is negative near the background u = 0.* write abs\(u\)\*\*1.5, or sign\(u\)"),
        ({"flux": "u**n", "parameters": {"n": 1.5}}, "'u[*][*]n' at character 1 raises 'u', which is negative"),
        ({"flux": "u**-1"}, "raises 'u', which is 0 near the background u = 0, to the power -1"),
        ({"flux": "abs(u)**(n - 1)", "parameters": {"n": 0.5}}, r"raises 'abs\(u\)', which is 0 near the background"),
        ({"flux": "u*log(abs(u))"}, "at character 3 takes the logarithm"),
        ({"flux": "d1(u)**2/u"}, "divides by 'u', which is 0 near the background u = 0"),
        ({"source": "sqrt(d1(u))"}, r"CustomEquation.source: .* raises 'd1\(u\)', which is negative"),
        ({"flux": "d2(1/u)"}, "'1/u' at character 4 divides"),
    ],
)
def test_what_cannot_be_is_refused_with_its_place(fields: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        kdv(**fields)


def test_formulas_that_are_regular_at_the_background_pass() -> None:
    for text in ("1/(1 + u**2)", "abs(u)**1.5", "log(abs(u) + 1e-9)*u", "sqrt(1 + u)", "u*tanh(u)", "1/cosh(d1(u))"):
        kdv(flux=text)
    shallow = CustomEquation("v**2/u + u**2/2", two_way=True, background=1)
    shallow.check_state(np.array([[1.0, 2.0], [0.0, 0.0]]))
    with pytest.raises(InputError, match=r"'v\*\*2/u' at character 1 divides by 'u', which is 0 where u = 0 in the state"):
        shallow.check_state(np.array([[1.0, 0.0], [0.0, 0.0]]))
    with pytest.raises(InputError, match="near the background u = 0"):
        CustomEquation("v**2/u + u**2/2", two_way=True)


def test_the_grid_is_checked_where_x_stands() -> None:
    equation = kdv(source="log(x)*exp(-t)")
    equation.check_grid(Grid(10, 40, left=1))
    with pytest.raises(InputError, match=r"CustomEquation.source: 'log.x.' .*, which is not positive at x = -5, t = 0"):
        equation.check_grid(Grid(10, 40, left=-5))


def test_what_depends_on_time_says_so() -> None:
    assert not kdv().depends_on_time
    assert kdv(source="sin(t)").depends_on_time
    assert kdv(flux="u**2*(1 + t)").depends_on_time
    assert kdv().local_source(0.0, np.zeros(8), np.zeros((1, 8)), difference) is None


@pytest.mark.parametrize(
    ("text", "kappa"),
    [
        ("3*u**2 + d2(u)", 1.0),
        ("u*(u + d2(u**2))", 0.5),
        ("u**2 + d2(u)*u*2 + u*d2(u)/4", None),
        ("u*d2(u**2) + d2(2*u*u)*3", None),
        ("d2(u**2) + 0.1*d2(u)", None),
        ("2*u*d2(u) - u*d2(u**2)/3", None),
        ("-(d2(sin(u))*cos(u)) + u", -1.0),
        ("u/(1 + u**2)*d2(u)", None),
        ("u**2", 0.0),
        ("abs(u)**1.5*sign(u) + abs(u)**0.25*d2(abs(u)**0.25*u)", 0.8),
    ],
)
def test_the_dispersive_form_is_found(text: str, kappa: float | None) -> None:
    equation = CustomEquation(text)
    flux = equation.dispersive_flux
    assert flux is not None
    u = random_state(3, 1, 40)
    b, g, a = np.empty((3, 40))
    flux.evaluate(u[0], b, g, a)
    expected = equation.local_flux(0.0, np.zeros(40), u, difference)
    np.testing.assert_allclose(a + b * difference(g, 2), expected, rtol=1e-12, atol=1e-11 * np.abs(expected).max())
    slopes, ahead, behind = np.empty((3, 3, 40))
    flux.slopes(u[0], *slopes)
    flux.evaluate(u[0] + 1e-6, *ahead)
    flux.evaluate(u[0] - 1e-6, *behind)
    np.testing.assert_allclose(slopes, (ahead - behind) / 2e-6, atol=1e-6 * (1 + np.abs(slopes).max()))
    assert flux.variational_constant == (None if kappa is None else pytest.approx(kappa))


@pytest.mark.parametrize(
    "text",
    [
        "d1(u)",
        "d2(u)**2",
        "d2(u)*d2(u**2)",
        "u*d2(u) + u**2*d2(u**2)",
        "d2(u*d2(u))",
        "d3(u)",
        "x*u",
        "u*t",
        "1/(1 + d2(u)**2)",
    ],
)
def test_other_forms_are_told_apart(text: str) -> None:
    assert CustomEquation(text).dispersive_flux is None


@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_the_granular_equation_by_formula_is_the_one_that_is_built_in(n: float) -> None:
    """The same rates, Jacobian and energy, and the same wave after a run."""
    formula, own = CustomEquation(GRANULAR[n], variable="W"), GranularCompacton(n)
    grid = Grid(length=30, size=120)
    scheme = CompactScheme(grid_viscosity=0.03)
    systems = [scheme.discretize(equation, grid) for equation in (formula, own)]
    state = random_state(1, 1, 120)
    rates = [right_hand_side(system, state) for system in systems]
    np.testing.assert_allclose(rates[0], rates[1], atol=1e-13 * np.abs(rates[1]).max())
    jacobians = [analytic_jacobian(system, state) for system in systems]
    np.testing.assert_allclose(jacobians[0], jacobians[1], atol=1e-9 * np.abs(jacobians[1]).max())
    assert systems[0].invariants(state)["energy"] == pytest.approx(systems[1].invariants(state)["energy"], rel=1e-12)
    assert systems[0].invariants(state)["mass"] == systems[1].invariants(state)["mass"]
    start = [Samples(tuple(Compacton(1, 10).values(own, grid)[0]))]
    waves = [run(Simulation(equation, grid, start, 2.0, scheme, frames=2)).W.values[-1] for equation in (formula, own)]
    np.testing.assert_allclose(waves[0], waves[1], atol=1e-8)


@given(st.sampled_from([1.5, 2, 3]), st.integers(0, 1000))
def test_the_energy_is_that_of_the_power_laws(n: float, seed: int) -> None:
    (u,) = random_state(seed, 1, 30)
    flux, own = CustomEquation(GRANULAR[n], variable="W").dispersive_flux, GranularCompacton(n).dispersive_flux
    assert flux is not None
    second = np.random.default_rng(seed).normal(size=30)
    np.testing.assert_allclose(flux.energy_parts(u, second), own.energy_parts(u, second), rtol=1e-11, atol=1e-13)


def test_integrals() -> None:
    """Conserved without a source, diagnostics with one; in two-way form the mass is conserved in any case."""
    state = random_state(0, 2, 16)
    second = lambda values: difference(values, 2)  # noqa: E731
    own = PowerLawEquation(PowerLaw(3, 2), PowerLaw(1, 0), PowerLaw(1, 1, odd=True), two_way=True)
    free, driven = kdv(two_way=True), kdv(two_way=True, source="-v")
    expected = own.invariants(state, 0.25, second)
    assert free.invariants(state, 0.25, second) == pytest.approx(expected, rel=1e-12)
    assert driven.invariants(state, 0.25, second) == {"mass": expected["mass"]}
    assert driven.diagnostics(state, 0.25) == {"momentum": expected["momentum"]}
    assert free.diagnostics(state, 0.25) == {}
    assert kdv(source="-u").invariants(state[:1], 0.25, second) == {}
    assert kdv(source="-u").diagnostics(state[:1], 0.25) == {"mass": expected["mass"]}
    assert set(CustomEquation("u*d1(u)").invariants(state[:1], 0.25, second)) == {"mass"}


def test_the_compact_scheme_takes_the_source() -> None:
    """M u' = -D1 F + M s: with a source that is a rate of its own, the rate is the sum."""
    grid = Grid(length=30, size=60)
    state = Compacton(1, 15).values(GranularCompacton(3), grid)
    rates = [
        CompactScheme().discretize(CustomEquation(GRANULAR[3], source, variable="W"), grid).rate(0.0, state)
        for source in ("", "-0.1*W + sin(x/5)")
    ]
    np.testing.assert_allclose(rates[1] - rates[0], [-0.1 * state[0] + np.sin(grid.x / 5)], atol=1e-12)


def test_the_jacobian_of_the_compact_scheme() -> None:
    equation = CustomEquation("sin(u) + u**2 + (1 + u**2)*d2(u + tanh(u))")
    system = CompactScheme(viscosity=1e-3).discretize(equation, Grid(length=10, size=17))
    state = random_state(5, 1, 17)
    matrix = analytic_jacobian(system, state)
    assert np.allclose(matrix, difference_jacobian(system, state), atol=1e-7 * np.abs(matrix).max())


def test_it_is_an_equation() -> None:
    assert issubclass(CustomEquation, Equation)
    assert kdv(two_way=True, flux="u + 0*v").variables == ("u", "v")
    with pytest.raises(InputError, match="no compacton of closed form"):
        kdv().compacton(1.0)


def test_the_linearization_is_the_derivative_of_flux_and_source() -> None:
    """Cell by cell and component by component, against differences by the state."""
    equation = CustomEquation("u*d1(u)**2 + d2(u)*d3(v) + x*v", "u*d2(v) - v", two_way=True)
    stencils = {order: central(order, 4) for order in (1, 2, 3)}
    coefficients = {order: stencil.scaled(0.25) for order, stencil in stencils.items()}
    x, state, size = np.linspace(-1, 1, 16), random_state(2, 2, 16), 16
    linear = equation.linearized(coefficients)
    for term, diagonals in (
        (equation.local_flux, linear.flux(0.0, x, state)),
        (equation.local_source, linear.source(0.0, x, state)),
    ):
        assert diagonals is not None
        reach = diagonals.shape[1] // 2
        assert reach <= linear.reach
        for component in range(2):
            for place in range(size):
                step = np.zeros((2, size))
                step[component, place] = 1e-6
                ahead, behind = (term(0.0, x, state + sign * step, difference) for sign in (1, -1))
                expected = np.zeros(size)
                for offset in range(-reach, reach + 1):
                    cell = (place - offset) % size
                    expected[cell] += diagonals[component, reach + offset, cell]
                np.testing.assert_allclose((np.asarray(ahead) - behind) / 2e-6, expected, atol=1e-6)
    assert kdv().linearized(coefficients).source(0.0, x, state[:1]) is None


@pytest.mark.parametrize("integrator", [IDA(rtol=1e-6), CVODE(rtol=1e-6), Rosenbrock(rtol=1e-6), Midpoint(step=0.01)])
def test_a_source_that_depends_on_the_time_alone_lifts_all_by_its_integral(
    integrator: IDA | CVODE | Rosenbrock | Midpoint,
) -> None:
    """u = 1 + sin(5 t) / 5, in as few steps as a smooth function of the time needs."""
    equation = CustomEquation("u", source="cos(5*t)")
    dataset = run(Simulation(equation, Grid(10, 20), [Uniform(1)], t_end=2, frames=9, integrator=integrator))
    exact = 1 + np.sin(5 * dataset.t.values) / 5
    assert dataset.u.values == pytest.approx(np.outer(exact, np.ones(20)), abs=5e-5)
    assert np.ptp(exact) > 0.3
    assert dataset.attrs["solver_steps"] < 400
