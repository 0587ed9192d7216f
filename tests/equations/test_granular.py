import numpy as np
import pytest
from scipy.integrate import quad

from mol_compactons import GranularCompacton, InputError


@pytest.mark.parametrize("n", [1.0, 0.5, -2])
def test_n_must_exceed_one(n: float) -> None:
    with pytest.raises(InputError, match="must be larger than 1"):
        GranularCompacton(n)


def test_speed_must_be_positive() -> None:
    with pytest.raises(InputError, match="sign=-1 gives a dark one"):
        GranularCompacton(3).compacton(-1)


@pytest.mark.parametrize("n", [1.5, 2, 2.5, 3, 4])
@pytest.mark.parametrize("speed", [0.25, 1.0, 2.0])
def test_the_compacton_solves_the_equation(n: float, speed: float) -> None:
    """phi'' = c phi^((3-n)/(n+1)) - phi on the support, which is -c W + F = 0 divided by psi."""
    shape = GranularCompacton(n).compacton(speed)
    z = np.linspace(-0.45, 0.45, 7) * shape.width
    step = 1e-3

    def phi(points: np.ndarray) -> np.ndarray:
        return np.asarray(shape(points) ** ((n + 1) / 2))

    second = (-phi(z + 2 * step) + 16 * phi(z + step) - 30 * phi(z) + 16 * phi(z - step) - phi(z - 2 * step)) / (12 * step**2)
    assert np.allclose(second, speed * phi(z) ** ((3 - n) / (n + 1)) - phi(z), atol=1e-7 * phi(z).max())


@pytest.mark.parametrize(
    ("n", "mass", "momentum", "energy"),
    [(2, 9 * np.pi / 4, 81 * np.pi / 64, -27 * np.pi / 32), (3, 4 * np.sqrt(2), np.pi, -np.pi / 2)],
)
def test_invariants_of_a_compacton_have_their_closed_forms(n: float, mass: float, momentum: float, energy: float) -> None:
    shape = GranularCompacton(n).compacton(1)
    half = shape.width / 2

    def energy_density(z: float) -> float:
        step = 1e-4
        w = float(shape(np.array(z)))
        slope = float(shape(np.array(z + step)) - shape(np.array(z - step))) / (2 * step)
        return float((n + 1) / 4 * w ** (n - 1) * slope**2 - w ** (n + 1) / (n + 1))

    assert quad(lambda z: float(shape(np.array(z))), -half, half)[0] == pytest.approx(mass, rel=1e-9)
    assert quad(lambda z: 0.5 * float(shape(np.array(z))) ** 2, -half, half)[0] == pytest.approx(momentum, rel=1e-9)
    assert quad(energy_density, -half + 1e-3, half - 1e-3)[0] == pytest.approx(energy, rel=1e-5)


@pytest.mark.parametrize("n", [1.2, 1.5, 2, 3, 4.5])
@pytest.mark.parametrize("speed", [1e-3, 0.25, 1.0, 7.0])
def test_the_speed_that_belongs_to_a_height_is_the_one_that_made_it(n: float, speed: float) -> None:
    equation = GranularCompacton(n)
    assert equation.compacton_speed(equation.compacton(speed).amplitude) == pytest.approx(speed, rel=1e-11)


def test_mass_momentum_and_energy_of_a_smooth_state() -> None:
    """W = 2 + cos x, n = 3: Int W = 4 pi, Int W^2 / 2 = 9 pi / 2, Int W^2 W_x^2 = 17 pi / 4, Int W^4 / 4 = 227 pi / 16."""
    x = 2 * np.pi * np.arange(64) / 64
    wave, wavenumbers = 2 + np.cos(x), np.arange(33)
    found = GranularCompacton(3).invariants(
        wave[None], 2 * np.pi / 64, lambda values: np.fft.irfft(-(wavenumbers**2) * np.fft.rfft(values))
    )
    assert found == pytest.approx(
        {"mass": 4 * np.pi, "momentum": 4.5 * np.pi, "energy": (17 / 4 - 227 / 16) * np.pi}, rel=1e-13
    )


@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_a_dark_wave_has_the_mass_of_its_mirror_image_with_the_other_sign(n: float) -> None:
    x = 2 * np.pi * np.arange(64) / 64
    equation, wave = GranularCompacton(n), (2 + np.cos(x))[None]
    bright, dark = (equation.invariants(state, 0.1, lambda values: -values) for state in (wave, -wave))
    assert bright["mass"] > 1
    assert dark == {"mass": -bright["mass"], "momentum": bright["momentum"], "energy": bright["energy"]}
