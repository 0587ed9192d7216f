from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mol_compactons import GranularChain, InputError, PowerContact
from mol_compactons.chain.solitary_wave import solitary_profile

HERTZ = GranularChain(PowerContact(1.5))
CUBIC = GranularChain(PowerContact(3, strength=2.5))
SPRINGS = GranularChain(PowerContact(3, linear=1))
COMPRESSED = GranularChain(PowerContact(1.5, kind="one_sided"), compression=0.5)


@pytest.mark.parametrize("chain", [HERTZ, CUBIC, SPRINGS, COMPRESSED])
@given(speed=st.floats(1.25, 20))
@settings(max_examples=5)
def test_the_wave_of_a_height_is_that_of_its_speed(chain: GranularChain, speed: float) -> None:
    exact, z = solitary_profile(chain, speed), np.linspace(-9, 9, 601)
    found, shape = chain.solitary_speed(exact.amplitude), chain.solitary_shape(exact.amplitude)
    assert found == pytest.approx(speed, rel=1e-9)
    assert shape is not None
    assert np.abs(shape(z) - exact(z)).max() < 3e-9 * exact.amplitude
    assert shape.amplitude == pytest.approx(exact.amplitude, rel=1e-12)
    assert [shape.width, shape.half_width] == pytest.approx([exact.width, exact.half_width], rel=1e-7)


@pytest.mark.parametrize("chain", [HERTZ, CUBIC, SPRINGS])
def test_a_wave_of_tension_is_the_mirror_image(chain: GranularChain) -> None:
    z = np.linspace(-5, 5, 101)
    bright, dark = chain.solitary_shape(1.3, 1), chain.solitary_shape(1.3, -1)
    assert bright is not None
    assert dark is not None
    assert float(bright(np.zeros(1))[0]) == pytest.approx(1.3, rel=1e-9)
    assert np.array_equal(dark(z), -bright(z))
    assert np.array_equal(dark.slope(z), -bright.slope(z))
    assert bright.slope(z[10:11]) == pytest.approx((bright(z[10:11] + 1e-4) - bright(z[10:11] - 1e-4)) / 2e-4, rel=1e-6)
    assert chain.solitary_speed(1.3, 1) == chain.solitary_speed(1.3, -1)


@given(st.floats(0.3, 30), st.floats(0.3, 30))
@settings(max_examples=10)
def test_higher_waves_are_faster(one: float, other: float) -> None:
    for chain in (HERTZ, SPRINGS, COMPRESSED):
        speeds = [chain.solitary_speed(height) or 0.0 for height in sorted((one, other))]
        assert speeds[0] <= speeds[1]


@pytest.mark.parametrize(
    ("chain", "height", "sign"),
    [
        (GranularChain(PowerContact(1.5, kind="one_sided")), 1.0, -1),
        (GranularChain(PowerContact(2, kind="rarefaction", linear=1)), 1.0, 1),
        (COMPRESSED, 1.0, -1),
        (GranularChain(PowerContact(2), masses=(1, 2, 1, 2)), 1.0, 1),
        (SPRINGS, 1e-4, 1),
        (SPRINGS, 1e12, 1),
    ],
)
def test_where_there_is_no_wave_there_is_no_shape(chain: GranularChain, height: float, sign: int) -> None:
    assert chain.solitary_shape(height, sign) is None
    assert chain.solitary_speed(height, sign) is None


def test_heights_are_positive() -> None:
    with pytest.raises(InputError, match="The height of a solitary wave is positive, not -1"):
        HERTZ.solitary_shape(-1)
