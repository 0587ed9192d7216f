from __future__ import annotations

import numpy as np
import pytest

from mol_compactons.chain.profile import profile_of_speed


@pytest.mark.parametrize("law", [(1.5, 1.0, 0.0, 0.0), (3.0, 2.0, 0.0, 0.0), (3.0, 1.0, 1.0, 0.0), (1.5, 1.0, 0.0, 0.6)])
def test_the_spline_is_the_series(law: tuple[float, float, float, float]) -> None:
    profile = profile_of_speed(*law, 2.3)
    z, step = np.linspace(0, 7, 501), 1e-4
    assert np.abs(profile.spline(z) - profile(z)).max() < 1e-10 * profile.amplitude
    slope = (profile(z + step) - profile(z - step)) / (2 * step)
    assert np.abs(profile.spline(z, 1) - slope).max() < 1e-7 * profile.amplitude


@pytest.mark.parametrize("n", [1.5, 3.0])
def test_the_velocity_is_the_mean_of_the_force_over_one_distance(n: float) -> None:
    """V times the velocity at z is the integral of F(R) from z - 1/2 to z + 1/2."""
    profile = profile_of_speed(n, 1.0, 0.0, 0.0, 1.4)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    for z in (0.0, 0.7, 1.9):
        mean = 0.5 * float(weights @ np.maximum(profile(z + nodes / 2), 0) ** n)
        assert float(profile.velocity(np.array([z]))[0]) == pytest.approx(mean / 1.4, rel=1e-9)
