import numpy as np
import pytest

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


@pytest.mark.parametrize("n", [1.5, 2])
def test_towards_the_compacton_the_profile_becomes_the_compacton(n: float) -> None:
    equation = GranularCompacton(n)
    shape = equation.compacton(1)
    wave = PeriodicWave(1, crest=shape.amplitude * (1 - 1e-7))
    z = np.linspace(0, 0.2 * shape.width, 5)
    grid = Grid(length=wave.period(equation), size=2000)
    profile = np.interp(z, grid.x, wave.values(equation, grid)[0])
    assert np.allclose(profile, shape(z), atol=1e-4)


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
    with pytest.raises(InputError, match="speed = -1 must be positive"):
        PeriodicWave(-1, crest=1.2)
