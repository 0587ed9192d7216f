from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from mol_compactons import (
    IDA,
    Compacton,
    CompactScheme,
    Grid,
    InputError,
    Nesterenko,
    Ripple,
    Simulation,
    Uniform,
    run,
)
from tests.systems import analytic_jacobian, difference_jacobian, random_state


@pytest.mark.parametrize("n", [1.5, 3])
@pytest.mark.parametrize("periods", [2, 3, 4])
def test_a_uniform_state_grows_at_the_rate_of_linear_theory(n: float, periods: int) -> None:
    """A ripple of k = 2, 3, 4 on S = 1 with a = 3, beyond k^2 = 12 / a^2, grows like cosh(sigma t), here within 1 %."""
    equation = Nesterenko(n, grain_distance=3)
    rate = np.sqrt(-equation.frequency_squared(periods, 1.0))
    simulation = Simulation(
        equation=equation,
        grid=Grid(length=2 * np.pi, size=8 * periods),
        scheme=CompactScheme("five_point", viscosity=0),
        initial=[Uniform(1), Ripple(1e-6, periods)],
        t_end=2 / rate,
        frames=3,
        integrator=IDA(rtol=1e-6, atol=1e-14),
    )
    first, *_, last = (abs(np.fft.rfft(frame)[periods]) for frame in run(simulation).S.values)
    assert np.arccosh(last / first) / simulation.t_end == pytest.approx(rate, rel=0.01)


def test_a_long_ripple_oscillates_at_the_frequency_of_linear_theory() -> None:
    equation = Nesterenko(n=2, grain_distance=0.5, prestress=2)
    frequency = np.sqrt(equation.frequency_squared(1.0, 1.0))
    simulation = Simulation(
        equation=equation,
        grid=Grid(length=2 * np.pi, size=20),
        scheme=CompactScheme("five_point", viscosity=0),
        initial=[Uniform(1), Ripple(1e-5, 1)],
        t_end=np.pi / frequency,
        frames=3,
        integrator=IDA(rtol=1e-6, atol=1e-14),
    )
    transforms = [np.fft.rfft(frame)[1].real for frame in run(simulation).S.values]
    assert transforms[1] == pytest.approx(0, abs=0.01 * transforms[0])
    assert transforms[2] == pytest.approx(-transforms[0], rel=1e-3)


def test_the_two_way_jacobian_is_the_derivative() -> None:
    system = CompactScheme("five_point", 1e-3).discretize(Nesterenko(2, 1.2, 0.7, 0.5), Grid(length=10, size=17))
    state = random_state(2, 2, 17)
    state[0] = 1 + 0.3 * np.tanh(state[0])
    matrix = analytic_jacobian(system, state)
    assert np.allclose(matrix, difference_jacobian(system, state), atol=1e-7 * np.abs(matrix).max())


def test_mass_momentum_and_energy_are_conserved_by_the_semi_discretisation() -> None:
    system = CompactScheme("five_point", 0).discretize(Nesterenko(2.5, 1.2, 0.7, 0.5), Grid(length=10, size=24))
    state = random_state(3, 2, 24)
    state[0] = 1 + 0.3 * np.tanh(state[0])
    rate = system.rate(0.0, state)
    step = 1e-5 / np.abs(rate).max()
    ahead, behind = system.invariants(state + step * rate), system.invariants(state - step * rate)
    for name, value in system.invariants(state).items():
        assert abs(ahead[name] - behind[name]) < 1e-9 * (abs(value) + 1), name


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Nesterenko(1), "must be larger than 1"),
        (lambda: Nesterenko(2, strength=0), "strength = 0 must be positive"),
        (lambda: Nesterenko(2, prestress=-1), "must not be negative"),
        (lambda: Nesterenko(2, prestress=1).compacton(0.9), "not faster than sound, 1"),
    ],
)
def test_bad_input_is_named(make: Callable[[], object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        make()


def test_negative_stress_is_refused_where_it_has_no_force() -> None:
    def simulation(n: float) -> Simulation:
        return Simulation(
            equation=Nesterenko(n),
            grid=Grid(length=20, size=60),
            scheme=CompactScheme(),
            initial=[Compacton(1, 10, sign=-1)],
            t_end=0.1,
        )

    with pytest.raises(InputError, match=r"goes down to -1.\d+, but Nesterenko's equation with n = 1.5 has waves"):
        simulation(1.5)
    assert simulation(3).equation == Nesterenko(3)


@pytest.mark.parametrize("n", [1.5, 2, 3])
@pytest.mark.parametrize("prestress", [0.0, 0.7])
def test_the_compacton_solves_the_equation(n: float, prestress: float) -> None:
    """V^2 S = F[S] on the support, which is S_tt = F_xx integrated twice; here with an exact second derivative of g."""
    equation = Nesterenko(n, strength=1.3, grain_distance=0.4, prestress=prestress)
    shape, z, step = equation.compacton(1.7), np.linspace(-0.4, 0.4, 9), 1e-3
    z = z * shape.width

    def g(points: np.ndarray) -> np.ndarray:
        return np.asarray(shape(points) ** ((n + 1) / 2))

    steps = step * shape.width
    second = (-g(z + 2 * steps) + 16 * g(z + steps) - 30 * g(z) + 16 * g(z - steps) - g(z - 2 * steps)) / (12 * steps**2)
    stress = shape(z)
    force = equation.stiffness * (stress**n + equation.dispersion * stress ** ((n - 1) / 2) * second)
    force = force + equation.sound_speed**2 * stress
    assert np.allclose(force, 1.7**2 * stress, rtol=1e-7)


def test_the_coefficients_are_those_of_the_paper() -> None:
    equation = Nesterenko(n=3, strength=2.0, grain_distance=0.5, prestress=4.0)
    assert equation.stiffness == pytest.approx(2.0 * 0.5**4)
    assert equation.dispersion == pytest.approx(3 * 0.25 / 24)
    assert equation.sound_speed == pytest.approx(np.sqrt(4.0 * 0.5**6))


def test_mass_momentum_and_energy_of_a_smooth_state() -> None:
    """S = 2 + cos x, v = 1 + 3 sin x, n = 3: Int v^2 / 2 = 11 pi / 2, Int S^4 / 4 = 227 pi / 16, Int S^2 S_x^2 = 17 pi / 4."""
    equation = Nesterenko(n=3, strength=1.3, grain_distance=0.4, prestress=0.7)
    x, wavenumbers = 2 * np.pi * np.arange(64) / 64, np.arange(33)
    state = np.array([2 + np.cos(x), 1 + 3 * np.sin(x)])
    found = equation.invariants(state, 2 * np.pi / 64, lambda values: np.fft.irfft(-(wavenumbers**2) * np.fft.rfft(values)))
    stored = equation.stiffness * (227 / 16 - equation.dispersion * 17 / 4) + equation.sound_speed**2 * 9 / 2
    assert found == pytest.approx({"mass": 4 * np.pi, "momentum": 2 * np.pi, "energy": np.pi * (stored + 11 / 2)}, rel=1e-13)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_wave_of_either_sign_moves_either_way_with_the_height_of_its_speed(sign: int) -> None:
    """n = 3, c0 = 0.8: C M^2 / 2 = V^2 - c0^2."""
    equation = Nesterenko(n=3, strength=1.3, prestress=0.64)
    right, left = (equation.compacton(speed, sign) for speed in (1.7, -1.7))
    assert right == left
    assert sign * right.amplitude == pytest.approx(np.sqrt(2 * (1.7**2 - 0.64) / 1.3))
    with pytest.raises(InputError, match=r"speed = -0\.5 is not faster than sound, 0\.8"):
        equation.compacton(-0.5, sign)
