from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    ChainCompacton,
    Compacton,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    Lattice,
    PowerContact,
    Simulation,
    run,
)
from mol_compactons.analysis.chain_and_continuum import continuum_of, two_way_continuum_of
from tests.chain.chains import ring
from tests.systems import Array

LATTICE = Lattice(40)
RATES: Any = ("derivative", "site_difference")


def held(n: float, **fields: Any) -> GranularChain:
    return GranularChain(PowerContact(n, strength=1.3), ends="held", **fields)


@given(
    st.sampled_from([1.5, 2, 2.5, 3]), st.floats(0.2, 3), st.sampled_from([1, -1]), st.sampled_from([1, -1]), st.floats(15, 25)
)
def test_the_derivative_is_the_rate_of_a_shape_that_moves_as_it_stands(
    n: float, speed: float, toward: int, sign: int, center: float
) -> None:
    """By central differences in t, at all sites but the ones that an edge is passing."""
    chain, wave, step = held(n), ChainCompacton(toward * speed, center, sign), 1e-4 / speed
    rate = wave.values(chain, LATTICE)[1]
    after, before = wave.values(chain, LATTICE, step)[0], wave.values(chain, LATTICE, -step)[0]
    shape = chain.compacton(speed)
    far = np.abs(np.abs(LATTICE.offset(center)) - shape.width / 2) > 0.02
    scale = speed * shape.amplitude * shape.wavenumber * shape.exponent
    assert np.abs(rate).max() > 0.1 * scale
    assert np.abs(rate - (after - before) / (2 * step))[far].max() < 1e-3 * scale


@given(st.sampled_from([1.5, 2, 3, 4]), st.floats(0.2, 3), st.floats(10, 25), st.sampled_from([1, -1]), st.floats(0, 3))
def test_the_site_difference_is_what_a_compacton_takes_bit_for_bit(
    n: float, speed: float, center: float, sign: int, t: float
) -> None:
    """The difference between the velocities V R of the grains left and right of each contact."""
    own, general = ChainCompacton(speed, center, sign, "site_difference"), Compacton(speed, center, sign)
    state = own.values(held(n), LATTICE, t)
    assert np.array_equal(state, general.values(held(n), LATTICE, t))
    velocity = speed * held(n).compacton(speed, sign)(np.arange(-0.5, 40) - center - speed * t)
    assert np.abs(velocity).max() > 0
    assert state[1] == pytest.approx(velocity[:-1] - velocity[1:], abs=1e-12)


def test_both_rates_come_together_for_wide_waves_alone() -> None:
    """The largest distance between the rates relative to the largest rate: a fifth at n = 1.5, nine tenths at n = 3."""

    def distance(n: float) -> float:
        chain, found = held(n), []
        for center in np.linspace(20, 21, 11):
            waves = [ChainCompacton(1, center, rate=rate) for rate in RATES]
            rates = [wave.values(chain, LATTICE)[1] for wave in waves]
            found.append(float(np.abs(rates[0] - rates[1]).max() / np.abs(rates[1]).max()))
        return max(found)

    assert distance(1.1) < 0.06
    assert distance(1.5) == pytest.approx(0.17, abs=0.01)
    assert distance(3) == pytest.approx(0.89, abs=0.05)


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("n", [1.5, 3])
def test_the_corrected_velocity_moves_the_pulse_to_the_right(n: float, rate: Any) -> None:
    """The printed sign, that of a negative speed, moves it to the left. For n = 3 the derivative sends a faster wave."""
    equation = GranularChain(PowerContact(n), ends="held")
    crests = []
    for speed in (1, -1):
        wave = ChainCompacton(speed, 30, rate=rate)
        dataset = run(ring(equation=equation, initial=[wave], t_end=15))
        crests.append(int(np.argmax(dataset.R.values[-1])))
        assert float(dataset.energy[-1] / dataset.energy[0]) == pytest.approx(1, abs=1e-4)
    assert crests[0] - 30 == pytest.approx(15, abs=6)
    assert crests[1] - 30 == pytest.approx(-15, abs=6)


def test_in_displacements_it_is_the_same_wave() -> None:
    """The grains have the velocities that make the rates, the last one is at rest, and the chain runs on alike."""
    masses = tuple(np.linspace(0.5, 2, 40))
    wave, results = ChainCompacton(1, 20.3), []
    forms: Any = ("stresses", "displacements")
    for form in forms:
        # N stresses lie between N + 1 grains.
        own = masses if form == "displacements" else (1.0, *masses)
        chain = GranularChain(PowerContact(3), ends="free", form=form, masses=own)
        results.append(run(ring(equation=chain, grid=LATTICE, initial=[wave], t_end=5)))
    stresses, grains = results
    velocities = grains.p.values / np.array(masses)
    assert velocities[0, -1] == 0
    assert -np.diff(velocities[0]) == pytest.approx(stresses.R_t.values[0, 1:], abs=1e-14)
    assert -np.diff(grains.Q.values[-1]) == pytest.approx(stresses.R.values[-1, 1:], abs=1e-9)
    assert np.abs(stresses.R.values[-1] - stresses.R.values[0]).max() > 0.5


def test_its_continua_start_from_the_compacton() -> None:
    simulation = ring(1.5, equation=GranularChain(PowerContact(1.5), ends="held"), initial=[ChainCompacton(1, 20.3, 1)])
    assert two_way_continuum_of(simulation).initial == (Compacton(1, 20.3, 1),)
    assert type(continuum_of(simulation).initial[0]) is Compacton
    assert Simulation.from_json(simulation.to_json()) == simulation


@pytest.mark.parametrize(
    ("attempt", "words"),
    [
        (
            lambda: ChainCompacton(1, 10).values(GranularCompacton(3), Grid(30, 90)),
            "not of GranularCompacton; choose Compacton",
        ),
        (lambda: ChainCompacton(1, 10).values(held(4), LATTICE), "has no bound at its edges; choose rate='site_difference'"),
        (lambda: ring(2, initial=[ChainCompacton(1, 20.3)]), "on a ring they must add up to 0; choose ends='held'"),
        (lambda: ChainCompacton(1, 10, rate="other"), "'derivative', 'site_difference'"),  # type: ignore[arg-type]
        (lambda: ChainCompacton(1, 10, 0), "sign = 0 must be 1 for a bright wave"),
    ],
)
def test_bad_input_is_named(attempt: Callable[[], Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        attempt()


def test_a_wide_one_fits_on_a_ring() -> None:
    """To a thousandth of its size, which the energy in the frame of zero momentum feels as little."""
    dataset = run(ring(1.5, initial=[ChainCompacton(1, 20.3)], t_end=20))
    rates: Array = dataset.R_t.values[0]
    assert 1e-5 < abs(rates.sum()) / np.abs(rates).sum() < 1e-3
    assert float(abs(dataset.energy / dataset.energy[0] - 1).max()) < 1e-3
    assert abs(int(np.argmax(dataset.R.values[-1])) - 40) <= 2
