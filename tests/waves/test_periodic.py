import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from mol_compactons import GranularCompacton, Grid, InputError, PeriodicWave, RosenauHyman


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_for_n_3_it_is_the_closed_form(speed: float, share: float) -> None:
    """W = sqrt(c + A cos(x - c t)) with period 2 pi."""
    amplitude = share * speed
    wave = PeriodicWave(speed, crest=float(np.sqrt(speed + amplitude)), center=1.0)
    equation, grid = GranularCompacton(3), Grid(length=4 * np.pi, size=80)
    exact = np.sqrt(speed + amplitude * np.cos(grid.x - 1.0 - speed * 0.7))
    assert np.abs(wave.values(equation, grid, 0.7)[0] - exact).max() < 1e-13
    assert wave.period(equation) == pytest.approx(2 * np.pi, rel=1e-14)
    assert wave.trough(equation) == pytest.approx(np.sqrt(speed - amplitude), rel=1e-12)
    assert wave.amplitude(equation) == pytest.approx((wave.crest - wave.trough(equation)) / 2)


@pytest.mark.parametrize("n", [1.5, 2, 4])
def test_small_waves_have_the_period_of_linear_theory(n: float) -> None:
    """About phi = 1, phi'' = -(1 - (3-n)/(n+1)) phi: the wavenumber is sqrt(2 (n-1) / (n+1))."""
    period = PeriodicWave(1, crest=1 + 1e-5).period(GranularCompacton(n))
    assert period == pytest.approx(2 * np.pi / np.sqrt(2 * (n - 1) / (n + 1)), rel=1e-8)


@pytest.mark.parametrize("n", [1.5, 2, 2.5, 4])
@pytest.mark.parametrize("distance", [1e-4, 1e-6, 1e-9])
def test_what_is_too_near_to_the_compacton_is_refused(n: float, distance: float) -> None:
    equation = GranularCompacton(n)
    with pytest.raises(InputError, match="is too near to"):
        PeriodicWave(1, crest=equation.compacton(1).amplitude * (1 - distance)).period(equation)


@pytest.mark.parametrize("n", [1.5, 2, 2.5, 4])
@pytest.mark.parametrize("distance", [0.2, 0.1, 0.03])
def test_the_period_is_that_of_an_adaptive_quadrature(n: float, distance: float) -> None:
    """T = 2 Int dphi / phi', with the square roots at both ends taken out."""
    equation = GranularCompacton(n)
    crest = equation.compacton(1).amplitude * (1 - distance)
    period = PeriodicWave(1, crest=crest).period(equation)
    power = 4 / (n + 1)

    def potential(phi: float) -> float:
        return float((n + 1) / 2 * phi**power - phi**2)

    high = crest ** ((n + 1) / 2)
    low = brentq(lambda phi: potential(phi) - potential(high), 0, 1, xtol=1e-16)

    def integrand(theta: float) -> float:
        phi = (high + low) / 2 + (high - low) / 2 * np.cos(theta)
        return float((high - low) / 2 * np.sin(theta) / np.sqrt(potential(phi) - potential(high)))

    middle = quad(integrand, 1e-3, np.pi - 1e-3, epsabs=1e-9, limit=500)[0]
    ends = 1e-3 * (integrand(1e-3) + integrand(np.pi - 1e-3))
    assert period == pytest.approx(2 * (middle + ends), rel=1e-5)


def test_the_dark_wave_is_the_mirror_image() -> None:
    equation = GranularCompacton(2)
    wave = PeriodicWave(1, crest=1.2)
    grid = Grid(length=wave.period(equation), size=50)
    assert np.array_equal(PeriodicWave(1, crest=1.2, sign=-1).values(equation, grid), -wave.values(equation, grid))


def test_bad_input_is_named() -> None:
    equation = GranularCompacton(3)
    with pytest.raises(InputError, match=r"must lie between 1, the flat wave, and 1\.41421, the compacton"):
        PeriodicWave(1, crest=1.5).period(equation)
    with pytest.raises(InputError, match=r"is 1.5 periods of the wave; make it a whole multiple of 6.283"):
        PeriodicWave(1, crest=1.2).values(equation, Grid(length=3 * np.pi, size=50))
    with pytest.raises(InputError, match="is a wave of GranularCompacton, not of RosenauHyman"):
        PeriodicWave(1, crest=1.2).values(RosenauHyman(2, 2), Grid(length=3 * np.pi, size=50))
    with pytest.raises(InputError, match="not of RosenauHyman"):
        PeriodicWave(1, crest=1.2).period(RosenauHyman(2, 2))
    with pytest.raises(InputError, match="speed = -1 must be positive"):
        PeriodicWave(-1, crest=1.2)


@pytest.mark.parametrize("n", [1.5, 2, 4])
def test_the_profile_solves_the_equation_once_integrated(n: float) -> None:
    """phi'' = c phi^((3-n)/(n+1)) - phi with spectral derivatives; crest and trough are where and as high as they are said."""
    equation, wave = GranularCompacton(n), PeriodicWave(0.7, crest=0.93 * GranularCompacton(n).compacton(0.7).amplitude)
    grid = Grid(length=2 * wave.period(equation), size=512)
    profile = wave.values(equation, grid)[0]
    phi = profile ** ((n + 1) / 2)
    second = np.fft.irfft(-(grid.wavenumbers**2) * np.fft.rfft(phi), n=512)
    assert np.abs(second - 0.7 * phi ** ((3 - n) / (n + 1)) + phi).max() < 1e-8
    assert profile[0] == profile[256] == profile.max() == pytest.approx(wave.crest, rel=1e-12)
    assert profile[128] == profile.min() == pytest.approx(wave.trough(equation), rel=1e-9)
    with pytest.raises(InputError, match="sign = 2 must be 1 or -1"):
        PeriodicWave(1, crest=1.2, sign=2)
