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
