from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import GranularCompacton, InputError, Nesterenko, ScalingMap

maps = st.builds(
    ScalingMap,
    n=st.sampled_from([1.5, 2.0, 3.0, 4.0]),
    strength=st.floats(0.2, 5),
    grain_distance=st.floats(0.05, 2),
    prestress=st.floats(0.2, 5),
)


@given(maps, st.floats(0, 10), st.floats(-10, 10), st.floats(-3, 3))
def test_there_and_back(scaling: ScalingMap, t: float, x: float, stress: float) -> None:
    time, place, amplitude = scaling.to_dimensionless(t, x, stress)
    assert scaling.to_physical(time, place, amplitude) == pytest.approx((t, x, stress), rel=1e-9, abs=1e-9)


@given(maps, st.floats(0.2, 2), st.floats(0, 3))
def test_an_exact_compacton_goes_there_and_back(scaling: ScalingMap, speed: float, time: float) -> None:
    shape = GranularCompacton(scaling.n).compacton(speed)
    place = np.linspace(-1, 1, 11) * shape.width / 2 + speed * time
    amplitude = shape(place - speed * time)
    t, x, stress = scaling.to_physical(np.full_like(place, time), place, amplitude)
    assert np.allclose(
        np.array(scaling.to_dimensionless(t, x, stress)), np.array([np.full_like(place, time), place, amplitude])
    )
    center = scaling.physical_speed(speed) * t
    assert np.allclose((x - center) * scaling.length_factor / scaling.grain_distance, place - speed * time, atol=1e-8)


@given(maps, st.floats(0.01, 1))
def test_the_map_keeps_the_shape_and_gets_the_speed_to_second_order(scaling: ScalingMap, speed: float) -> None:
    """The mapped compacton is exactly one of the pre-stressed Nesterenko equation, which moves at another speed.

    c0 sqrt(1 + e) against c0 (1 + e / 2), with e = A a^2 c / gamma: they differ by c0 e^2 / 8 at most.
    """
    equation = Nesterenko(scaling.n, scaling.strength, scaling.grain_distance, scaling.prestress)
    excess = scaling.strength * scaling.grain_distance**2 * speed / scaling.prestress
    exact_speed = scaling.sound_speed * np.sqrt(1 + excess)
    mapped = GranularCompacton(scaling.n).compacton(speed)
    if exact_speed <= scaling.sound_speed * (1 + 1e-9):
        return
    exact = equation.compacton(float(exact_speed))
    assert exact.amplitude == pytest.approx(scaling.stress_factor * mapped.amplitude, rel=1e-5)
    assert exact.width == pytest.approx(mapped.width * scaling.grain_distance / scaling.length_factor, rel=1e-12)
    assert exact.width == pytest.approx(scaling.width(), rel=1e-12)
    difference = scaling.physical_speed(speed) / exact_speed - 1
    assert difference + 1e-12 >= 0
    assert difference <= excess**2 / 8 + 1e-12


def test_the_width_is_that_of_the_paper() -> None:
    assert ScalingMap(n=1.5, grain_distance=2).width() == pytest.approx(4.967 * 2, abs=1e-3)
    assert ScalingMap(n=1.5).width() == pytest.approx(np.pi * np.sqrt(2.5), rel=1e-14)


@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_the_exponent_of_the_paper_does_not_balance(n: float) -> None:
    """With S = a^r W the mapped compacton solves the pre-stressed equation for r = 4/(n-1), not for r = 5.

    F[S] = V^2 S at the crest, with the V that its own c gives; r = 5 puts another amplitude in.
    """
    scaling = ScalingMap(n, grain_distance=0.5)
    equation = Nesterenko(n, grain_distance=0.5, prestress=1)
    mapped = GranularCompacton(n).compacton(1)
    squared_speed = scaling.sound_speed**2 * (1 + scaling.grain_distance**2)
    curvature = -((mapped.wavenumber * scaling.length_factor / scaling.grain_distance) ** 2)

    def imbalance(exponent: float) -> float:
        stress = scaling.grain_distance**exponent * mapped.amplitude
        second = curvature * mapped.exponent * (n + 1) / 2 * stress ** ((n + 1) / 2)
        contact = equation.stiffness * (stress**n + equation.dispersion * stress ** ((n - 1) / 2) * second)
        return float(abs(contact + scaling.sound_speed**2 * stress - squared_speed * stress) / (squared_speed * stress))

    assert imbalance(4 / (n - 1)) < 1e-12
    assert imbalance(5) > 0.01


@pytest.mark.parametrize("name", ["strength", "grain_distance", "prestress"])
def test_bad_input_is_named(name: str) -> None:
    with pytest.raises(InputError, match=f"ScalingMap.{name} = 0 must be positive"):
        ScalingMap(n=3, **{name: 0})
    with pytest.raises(InputError, match="larger than 1"):
        ScalingMap(n=1)
