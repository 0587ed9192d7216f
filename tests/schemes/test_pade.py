"""The four stencils of the literature for K(m, n): their tables, orders, conserved quantities, and what they are alike."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, Literal, get_args, get_type_hints

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.multipliers import sawtooth_speed
from mol_compactons import (
    Compacton,
    CompactScheme,
    ConservativeScheme,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    Lattice,
    PadeScheme,
    PowerContact,
    RosenauHyman,
    Rosenbrock,
    Simulation,
    run,
)
from mol_compactons.analysis.drift import drift
from mol_compactons.schemes.pade import PADE_STENCILS, THIRD
from tests.systems import (
    Array,
    analytic_jacobian,
    difference_jacobian,
    fitted_order,
    random_state,
    relative_error,
    right_hand_side,
)

Name = Literal["ismail_taha", "de_frutos", "pade_6", "pade_8"]
NAMES: tuple[Name, ...] = get_args(Name)

TABLE: dict[Name, tuple[list[str], list[str], int, int]] = {
    "ismail_taha": (["0", "0", "1", "0", "0"], ["0", "-1/2", "0", "1/2", "0"], 2, 2),
    "de_frutos": (
        ["1/120", "26/120", "66/120", "26/120", "1/120"],
        ["-1/24", "-10/24", "0", "10/24", "1/24"],
        6,
        4,
    ),
    "pade_6": (
        ["1/240", "56/240", "126/240", "56/240", "1/240"],
        ["-1/24", "-10/24", "0", "10/24", "1/24"],
        4,
        6,
    ),
    "pade_8": (["1/70", "16/70", "36/70", "16/70", "1/70"], ["-5/84", "-32/84", "0", "32/84", "5/84"], 8, 2),
}
"""A, h B, and the orders of u_x and u_xxx."""

C = ["-1/2", "1", "0", "-1", "1/2"]
"""h^3 C, the same for all."""


def moments(coefficients: list[str], count: int) -> list[Fraction]:
    """What a stencil on the offsets -2 to 2 makes of x^k / k! at 0, for h = 1."""
    found, factorial = [], 1
    for power in range(count):
        factorial *= max(power, 1)
        terms = (Fraction(c) * Fraction(offset) ** power for c, offset in zip(coefficients, range(-2, 3), strict=True))
        found.append(sum(terms, Fraction(0)) / factorial)
    return found


def order_of(mass: list[str], stencil: list[str], derivative: int) -> int:
    """The order of A^-1 S by Taylor's expansion: the first power at which A u^(d) and S u differ, less d."""
    ours, theirs = moments(stencil, 16), moments(mass, 16)
    for power in range(16):
        wanted = theirs[power - derivative] if power >= derivative else Fraction(0)
        if ours[power] != wanted:
            return power - derivative
    raise AssertionError("no error up to the power 16")


@pytest.mark.parametrize("name", NAMES)
def test_the_table_is_that_of_the_literature_and_has_its_orders_by_taylor(name: Name) -> None:
    mass, first, first_order, third_order = TABLE[name]
    member = PADE_STENCILS[name]
    assert member.mass.coefficients == pytest.approx([float(Fraction(c)) for c in mass], abs=1e-16)
    assert member.first.coefficients == pytest.approx([float(Fraction(c)) for c in first], abs=1e-16)
    assert THIRD.coefficients == pytest.approx([float(Fraction(c)) for c in C], abs=0)
    assert order_of(mass, first, 1) == first_order == member.first.order
    assert order_of(mass, C, 3) == third_order == member.third_order
    assert member.order == min(first_order, third_order) == PadeScheme(name).formal_order


def test_every_name_that_is_offered_is_one_of_the_four() -> None:
    assert set(get_args(get_type_hints(PadeScheme)["stencil"])) == set(PADE_STENCILS) == set(NAMES)


def rates(name: Name, m: float, n: float, size: int) -> tuple[Array, Array]:
    """U_t of a smooth positive wave by the scheme, and the same exactly, from the Fourier series of u^m and u^n."""
    equation, grid = RosenauHyman(m, n), Grid(2 * np.pi, size)
    u = 2 + np.cos(grid.coordinates)
    found = PadeScheme(name).discretize(equation, grid).rate(0.0, u[None])[0]
    wave = 1j * np.fft.rfftfreq(size, 1 / size)
    exact = -np.fft.irfft(wave * np.fft.rfft(u**m) + wave**3 * np.fft.rfft(u**n), n=size)
    return found, exact


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("which", ["first", "third"])
def test_observed_orders_of_the_two_derivatives(name: Name, which: str) -> None:
    """The difference of K(m, n) and K(m', n) is u^m - u^m' convected, that of K(m, n) and K(m, n') dispersed."""
    sizes, errors = [24, 48, 96], []
    for size in sizes:
        (one, exact_one), (other, exact_other) = (
            rates(name, 2, 1, size),
            rates(name, *((3, 1) if which == "first" else (2, 2)), size),
        )
        errors.append(relative_error(one - other, exact_one - exact_other))
    expected = TABLE[name][2 if which == "first" else 3]
    assert fitted_order(sizes, errors) == pytest.approx(expected, abs=0.25)


@pytest.mark.parametrize("name", NAMES)
def test_observed_order_on_a_compacton_of_smooth_edge(name: Name) -> None:
    """K(5/4, 5/4) has an edge so smooth that the lower order of the two is seen."""
    equation, sizes, errors = RosenauHyman(1.25, 1.25, absolute=True), [96, 192], []
    for size in sizes:
        simulation = Simulation(equation, Grid(40, size), [Compacton(1, 18)], 0.5, PadeScheme(name), 2, Rosenbrock(rtol=1e-9))
        exact = simulation.initial[0].values(equation, simulation.grid, 0.5)
        final = run(simulation).u.values[-1]
        assert np.linalg.norm(final - simulation.initial_state()[0]) > 0.05 * np.linalg.norm(exact)
        errors.append(relative_error(final, exact[0]))
    assert fitted_order(sizes, errors) > PadeScheme(name).formal_order - 0.3


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("viscosity", [0.0, 0.3])
@pytest.mark.parametrize(("m", "n"), [(2, 2), (3, 2), (3, 3)])
def test_the_jacobian_is_the_derivative(name: Name, viscosity: float, m: int, n: int) -> None:
    for order in (4, 6):
        scheme = PadeScheme(name, viscosity=viscosity, viscosity_order=order)
        system = scheme.discretize(RosenauHyman(m, n), Grid(10, 17))
        state = random_state(3, 1, 17)
        ours, theirs = analytic_jacobian(system, state), difference_jacobian(system, state)
        assert np.abs(ours - theirs).max() < 1e-7 * np.abs(theirs).max()


@pytest.mark.parametrize("name", NAMES)
@given(seed=st.integers(0, 1000), size=st.integers(8, 40), m=st.sampled_from([2, 3]), n=st.sampled_from([2, 3]))
def test_mass_is_conserved_for_any_state_and_energy_where_m_is_n(name: Name, seed: int, size: int, m: int, n: int) -> None:
    """The derivative of the sum of u^(n+1) / (n+1) is the sum of u^n u', and A^-1 (B + C) is skew."""
    equation = RosenauHyman(m, n)
    state = random_state(seed, 1, size)
    rate = PadeScheme(name).discretize(equation, Grid(size * 0.3, size)).rate(0.0, state)
    scale = float(np.abs(rate).sum())
    assert abs(float(rate.sum())) < 1e-12 * scale
    power = float((state**n * rate).sum())
    sizes = float(np.abs(state**n * rate).sum())
    if m == n:
        assert abs(power) < 1e-12 * sizes
    else:
        assert abs(power) > 1e-9 * sizes


@pytest.mark.parametrize("name", NAMES)
def test_a_run_keeps_them_while_the_wave_moves(name: Name) -> None:
    equation = RosenauHyman(2, 2, absolute=True)
    simulation = Simulation(equation, Grid(20, 100), [Compacton(1, 8)], 1, PadeScheme(name), 3, Rosenbrock(rtol=1e-9))
    dataset = run(simulation)
    exact = simulation.initial[0].values(equation, simulation.grid, 1)
    assert relative_error(dataset.u.values[-1], exact[0]) < 0.02
    assert relative_error(dataset.u.values[-1], dataset.u.values[0]) > 0.2
    changes = drift(dataset)
    assert {str(key) for key in changes.data_vars} == {"mass", "energy"}
    assert float(abs(changes.mass).max()) < 1e-13
    assert float(abs(changes.energy).max()) < 1e-7


@given(st.integers(0, 1000))
def test_ismail_taha_is_the_conservative_scheme_of_second_order_where_m_is_n(seed: int) -> None:
    equation, grid, state = RosenauHyman(2, 2, absolute=True), Grid(9, 30), random_state(seed, 1, 30)
    one, other = (scheme.discretize(equation, grid) for scheme in (PadeScheme("ismail_taha"), ConservativeScheme(2)))
    ours, theirs = right_hand_side(one, state), right_hand_side(other, state)
    assert np.abs(ours - theirs).max() < 1e-12 * np.abs(theirs).max()
    assert np.abs(theirs).max() > 0


def test_no_two_of_the_four_are_the_same_and_none_is_the_compact_scheme() -> None:
    equation, grid, state = RosenauHyman(2, 2), Grid(9, 30), random_state(1, 1, 30)
    seconds: tuple[Literal["wide", "nearest", "five_point"], ...] = ("wide", "nearest", "five_point")
    schemes: list[Any] = [*map(PadeScheme, NAMES), *(CompactScheme(second, viscosity=0) for second in seconds)]
    found = [scheme.discretize(equation, grid).rate(0.0, state) for scheme in schemes]
    for index, one in enumerate(found):
        for other in found[:index]:
            assert np.abs(one - other).max() > 0.01 * np.abs(one).max()


@given(st.integers(0, 100), st.sampled_from(NAMES))
def test_mirror_images_of_the_absolute_equation_move_the_same_way(seed: int, name: Name) -> None:
    system = PadeScheme(name).discretize(RosenauHyman(2, 2, absolute=True), Grid(9, 30))
    state = random_state(seed, 1, 30)
    assert np.array_equal(right_hand_side(system, -state), -right_hand_side(system, state))


@pytest.mark.parametrize("name", NAMES)
def test_sawteeth_travel_at_the_speed_that_follows_from_the_mass_matrix(name: Name) -> None:
    """C is 4 d/dx of the envelope on a sawtooth, and A its symbol at pi; the wide difference moves them not at all."""
    symbol = PADE_STENCILS[name].mass.symbol(np.array([np.pi]))[0].real
    equation = RosenauHyman(2, 2)
    assert sawtooth_speed(PadeScheme(name), equation) == pytest.approx(4 / symbol, rel=2e-3)
    assert abs(sawtooth_speed(CompactScheme("wide", viscosity=0), equation)) < 1e-3
    assert sawtooth_speed(ConservativeScheme(4), equation) == pytest.approx(16 / 3, rel=2e-3)


def test_viscosity_damps() -> None:
    grid, state = Grid(9, 30), random_state(1, 1, 30)
    plain = PadeScheme("pade_8").discretize(RosenauHyman(2, 2), grid)
    for order in (4, 6):
        damped = PadeScheme("pade_8", grid_viscosity=0.1, viscosity_order=order).discretize(RosenauHyman(2, 2), grid)
        assert damped.damping > 0 == plain.damping
        taken = (right_hand_side(damped, state) - right_hand_side(plain, state)) * state
        assert float(taken.sum()) < -0.1 * float((state**2).sum())


@pytest.mark.parametrize(
    ("equation", "grid"),
    [
        (GranularCompacton(2), Grid(10, 30)),
        (GranularChain(PowerContact(2)), Lattice(30)),
    ],
)
def test_what_is_no_k_m_n_is_refused(equation: Any, grid: Any) -> None:
    assert PadeScheme().suits(equation) == 0
    with pytest.raises(InputError, match=rf"PadeScheme is for RosenauHyman .* not for {type(equation).__name__}"):
        PadeScheme().discretize(equation, grid)


def test_bad_settings_are_named() -> None:
    with pytest.raises(InputError, match=r"grid\.size = 4 is too small: the scheme couples 5 neighbours"):
        PadeScheme().discretize(RosenauHyman(2, 2), Grid(10, 4))
    with pytest.raises(InputError, match=r"grid\.size = 6 is too small: the scheme couples 7 neighbours"):
        PadeScheme(viscosity=1, viscosity_order=6).discretize(RosenauHyman(2, 2), Grid(10, 6))
    with pytest.raises(InputError, match="stencil = 'pade_7' must be one of"):
        PadeScheme("pade_7")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="viscosity = -1 must not be negative"):
        PadeScheme(viscosity=-1)


def test_it_says_how_well_it_suits_and_checks_others_with_their_order_of_damping() -> None:
    equation, grid = RosenauHyman(2, 2), Grid(10, 30)
    assert 0 < PadeScheme().suits(equation) < ConservativeScheme().suits(equation)
    assert PadeScheme.as_check_of(CompactScheme(viscosity_order=6), equation, grid) == (0.4, PadeScheme(viscosity_order=6))
