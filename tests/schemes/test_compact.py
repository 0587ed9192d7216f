import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import Compacton, CompactScheme, GranularCompacton, Grid, InputError, run, stencils
from mol_compactons.schemes import compact
from tests.systems import (
    SecondDifference,
    analytic_jacobian,
    dense_stencil,
    difference_jacobian,
    fitted_order,
    one_compacton,
    random_state,
    relative_error,
    right_hand_side,
)

kinds = st.sampled_from(["wide", "nearest", "five_point"])
seeds = st.integers(0, 10**6)


@given(st.sampled_from([1.5, 2, 2.3, 3, 4]), kinds, st.sampled_from([0.0, 1e-2]), seeds)
def test_jacobian_is_the_derivative(n: float, kind: SecondDifference, viscosity: float, seed: int) -> None:
    system = CompactScheme(kind, viscosity).discretize(GranularCompacton(n), Grid(length=10, size=17))
    state = random_state(seed, 1, 17)
    state += 0.1 * np.sign(state)
    matrix = analytic_jacobian(system, state)
    assert np.allclose(matrix, difference_jacobian(system, state), atol=1e-7 * np.abs(matrix).max())


@given(st.floats(1.1, 7), kinds, seeds)
def test_without_viscosity_energy_and_mass_are_conserved(n: float, kind: SecondDifference, seed: int) -> None:
    """<grad H, M^-1 f> = 0 and sum f = 0 to round-off, for random states of both signs; grad H is taken by hand."""
    grid = Grid(length=10, size=24)
    equation = GranularCompacton(n)
    system = CompactScheme(kind, 0.0).discretize(equation, grid)
    state = random_state(seed, 1, grid.size)
    rate = system.rate(0.0, state)[0]
    second = dense_stencil(compact.SECOND_DIFFERENCES[kind], grid.size, grid.spacing)
    psi = np.abs(state[0]) ** ((n - 1) / 2)
    phi = psi * state[0]
    gradient = -psi * (phi + second @ phi)
    if n == 3:
        gradient = -(state[0] ** 3 + state[0] * (second @ state[0] ** 2))
    scale = np.linalg.norm(gradient) * np.linalg.norm(rate)
    assert abs(gradient @ rate) <= 1e-13 * scale
    assert abs(rate.sum()) <= 1e-12 * np.abs(rate).sum()


@given(st.sampled_from([1.5, 2, 3]), kinds, seeds)
def test_the_energy_that_is_reported_is_the_one_conserved(n: float, kind: SecondDifference, seed: int) -> None:
    """dH/dt along the flow, by a central difference of the reported energy."""
    system = CompactScheme(kind, 0.0).discretize(GranularCompacton(n), Grid(length=10, size=24))
    state = random_state(seed, 1, 24)
    state += 0.2 * np.sign(state)
    rate = system.rate(0.0, state)
    step = 1e-5 / np.abs(rate).max()
    ahead, behind = system.invariants(state + step * rate), system.invariants(state - step * rate)
    scale = abs(system.invariants(state)["energy"]) + 1
    assert abs(ahead["energy"] - behind["energy"]) <= 1e-9 * scale
    assert abs(ahead["mass"] - behind["mass"]) <= 1e-11 * scale


@given(st.sampled_from([1.5, 2, 3, 3.7]), kinds, seeds, st.integers(0, 23))
def test_symmetries(n: float, kind: SecondDifference, seed: int, shift: int) -> None:
    """W -> -W exactly; a shift to round-off; and W -> s W, t -> s^(1-n) t by homogeneity."""
    system = CompactScheme(kind, 0.0).discretize(GranularCompacton(n), Grid(length=10, size=24))
    state = random_state(seed, 1, 24)
    rate = right_hand_side(system, state)
    scale = np.abs(rate).max()
    assert np.array_equal(right_hand_side(system, -state), -rate)
    assert np.allclose(right_hand_side(system, np.roll(state, shift)), np.roll(rate, shift), atol=1e-13 * scale)
    assert np.allclose(right_hand_side(system, 2 * state), 2**n * rate, atol=1e-13 * 2**n * scale)


@pytest.mark.parametrize(("kind", "order"), [("wide", 2), ("nearest", 2), ("five_point", 4)])
def test_order_on_the_smooth_periodic_wave(kind: SecondDifference, order: int) -> None:
    """For n = 3, W = sqrt(c + A cos(x - c t)) is an exact smooth wave: its W_t is -c W_x."""
    sizes, errors = [32, 64, 128], []
    for size in sizes:
        grid = Grid(length=2 * np.pi, size=size)
        wave = np.sqrt(1 + 0.5 * np.cos(grid.x))
        exact = 0.25 * np.sin(grid.x) / wave
        system = CompactScheme(kind, 0.0).discretize(GranularCompacton(3), grid)
        errors.append(float(np.abs(system.rate(0.0, wave[None])[0] - exact).max()))
    assert fitted_order(sizes, errors) == pytest.approx(order, abs=0.2)


def test_as_printed_the_scheme_destroys_the_compacton(monkeypatch: pytest.MonkeyPatch) -> None:
    """The paper divides by h^2 where (2h)^2 belongs: four times the dispersion. At t = 4 nothing is left of the wave."""
    errors = {}
    for label, factor in (("corrected", 1.0), ("printed", 4.0)):
        coefficients = tuple(factor * c for c in stencils.SECOND_WIDE.coefficients)
        monkeypatch.setitem(compact.SECOND_DIFFERENCES, "wide", stencils.Stencil(coefficients, 2, 2))
        simulation = one_compacton(size=600, t_end=4)
        exact = simulation.initial[0].values(simulation.equation, simulation.grid, 4)
        errors[label] = relative_error(run(simulation).W.values[-1], exact[0])
    assert errors["corrected"] < 0.03
    assert errors["printed"] > 0.8


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match="must not be negative"):
        CompactScheme(viscosity=-1e-3)
    with pytest.raises(InputError, match=r"grid.size = 8 is too small: .* at least 9 points"):
        CompactScheme().discretize(GranularCompacton(3), Grid(length=10, size=8))
    CompactScheme("nearest").discretize(GranularCompacton(3), Grid(length=10, size=7))
    with pytest.raises(InputError, match="one of 'wide', 'nearest', 'five_point'"):
        CompactScheme("narrow")  # type: ignore[arg-type]


def test_viscosity_damps() -> None:
    grid = Grid(length=10, size=24)
    state = Compacton(1, 5).values(GranularCompacton(3), grid)
    system = CompactScheme(viscosity=1e-2).discretize(GranularCompacton(3), grid)
    undamped = CompactScheme(viscosity=0).discretize(GranularCompacton(3), grid)
    assert float((state * (right_hand_side(system, state) - right_hand_side(undamped, state))).sum()) < 0
    assert system.damping > undamped.damping == 0
