from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    CVODE,
    Compacton,
    GranularChain,
    InputError,
    Lattice,
    PowerContact,
    Ripple,
    Samples,
    SolitaryWave,
    Uniform,
    run,
)
from mol_compactons.analysis.drift import drift
from tests.chain.chains import SIZE, chains, ring, system_of


def test_a_small_ripple_oscillates_with_the_sine_of_the_lattice() -> None:
    """At the shortest wave, where Nesterenko's equation has long been unstable: omega = 2 sqrt(F')."""
    equation = GranularChain(PowerContact(n=1.5))
    frequency = np.sqrt(equation.frequency_squared(np.pi, 1.0))
    simulation = ring(
        equation=equation,
        grid=Lattice(size=16),
        initial=[Uniform(1), Ripple(1e-5, 8)],
        t_end=2 * np.pi / frequency,
        integrator=CVODE(rtol=1e-9, atol=1e-14, max_order=5),
    )
    ripples = [np.fft.rfft(frame)[8].real for frame in run(simulation).R.values]
    assert frequency == pytest.approx(2 * np.sqrt(1.5))
    assert ripples[1] == pytest.approx(-ripples[0], rel=1e-3)
    assert ripples[2] == pytest.approx(ripples[0], rel=1e-3)


def test_compression_makes_sound() -> None:
    """A compressed chain in displacements rings at the frequency of its static stiffness."""
    equation = GranularChain(PowerContact(n=1.5, kind="one_sided"), form="displacements", compression=0.3, ends="fixed")
    delta = 0.3 ** (1 / 1.5)
    frequency = np.sqrt(equation.frequency_squared(np.pi / 8, delta))
    mode = 1e-6 * np.sin(np.pi / 8 * (np.arange(7) + 1))
    samples = Samples((*mode, *np.zeros(7)))
    simulation = ring(equation=equation, grid=Lattice(7), initial=[samples], t_end=np.pi / frequency)
    assert run(simulation).Q.values[-1] == pytest.approx(-mode, abs=1e-10)


@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_a_pulse_between_two_sites_conserves_everything_too(n: float) -> None:
    solver = CVODE(rtol=1e-9, max_order=5, linear_solver="sparse")
    changes = drift(run(ring(n, initial=[Compacton(speed=1, center=10.3)], t_end=20, integrator=solver)))
    assert float(abs(changes.mass).max()) < 1e-10
    assert float(abs(changes.energy).max()) < 1e-5


@pytest.mark.parametrize(
    ("attempt", "words"),
    [
        (lambda: GranularChain(PowerContact(2), compression=-1), "compression = -1 must not be negative"),
        (lambda: GranularChain(PowerContact(2, kind="rarefaction"), compression=1), "compression is for laws that resist it"),
        (lambda: GranularChain(PowerContact(2), ends="held", form="displacements"), "'held' holds stresses"),
        (lambda: GranularChain(PowerContact(2), masses=(1, 0, 1)), "masses holds 0; all must be positive"),
        (lambda: system_of(GranularChain(PowerContact(2), masses=(1, 1))), "holds 2 numbers, but the chain has 12 grains"),
        (
            lambda: system_of(GranularChain(PowerContact(2), strengths=(1, 1), ends="free", form="displacements")),
            "the chain has 11 contacts",
        ),
        (
            lambda: ring(equation=GranularChain(PowerContact(3), ends="free"), initial=[Compacton(1, 1)]),
            "The pulse does not fit in the chain",
        ),
        (
            lambda: ring(equation=GranularChain(PowerContact(3), ends="free"), initial=[SolitaryWave(1, 70)]),
            "lies outside the chain",
        ),
        (lambda: ring(grid=Lattice(3)), "does not fit in the box"),
        (lambda: ring(initial=[SolitaryWave(1, 20), SolitaryWave(2, 22)]), "overlap"),
        (
            lambda: ring(equation=GranularChain(PowerContact(1.5, kind="one_sided")), initial=[Compacton(1, 20, -1)]),
            "do not resist tension; choose sign=1",
        ),
        (lambda: ring(equation=GranularChain(PowerContact(3), ends="fixed")), "The stresses add up to"),
        (
            lambda: ring(equation=GranularChain(PowerContact(3), form="displacements")),
            "does not fit on a ring in displacements",
        ),
        (
            lambda: GranularChain(PowerContact(2)).check_state(np.array([np.ones(5), np.ones(5)])),
            "add up to 5, but on a ring or between walls they must add up to 0",
        ),
    ],
)
def test_bad_input_is_named(attempt: Callable[[], Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        attempt()


@given(chains(), st.integers(0, 100))
def test_masses_and_strengths_stand_where_their_grains_and_contacts_are(chain: GranularChain, seed: int) -> None:
    """Every chain has one more grain than contacts, a ring as many; walls are no grains, and contacts with them count."""
    grains, contacts = chain.grain_count(SIZE), chain.contact_count(SIZE)
    more = {"periodic": 0, "fixed": -1, "free": 1, "held": 1}[chain.ends]
    assert grains - contacts == more
    if chain.masses:
        inverse = chain.inverse_masses(SIZE)
        kept = inverse[1:] if chain.form == "stresses" and chain.ends == "periodic" else inverse[inverse > 0]
        assert 1 / kept == pytest.approx(chain.masses)
    if chain.strengths:
        factors = chain.contact_strengths(SIZE)
        bare = chain.form == "stresses" or chain.ends == "fixed"
        # In displacements a contact has a place at both ends: on a ring it is one contact, and no contact at a free end.
        assert factors[0 if bare or chain.ends == "periodic" else 1 :][:contacts] == pytest.approx(chain.strengths)
        assert factors.size == SIZE + (0 if chain.form == "stresses" else 1)
        if chain.form == "displacements" and chain.ends == "periodic":
            assert factors[-1] == factors[0]


def test_a_pulse_in_displacements_has_the_stresses_and_velocities_of_the_pulse() -> None:
    shape = GranularChain(PowerContact(3)).compacton(1.0)
    chain = GranularChain(PowerContact(3), form="displacements", ends="free", masses=tuple(np.linspace(1, 2, 40)))
    z = np.linspace(-18.3, 20.7, 40)
    displacement, momentum = chain.travelling_state(shape, z, 1.5)
    assert -np.diff(displacement) == pytest.approx(shape(z[1:]), abs=1e-14)
    assert momentum == pytest.approx(np.linspace(1, 2, 40) * 1.5 * shape(z + 0.5))
    assert displacement[-1] == 0


def test_the_static_stress_holds_the_push() -> None:
    chain = GranularChain(PowerContact(1.5), compression=0.3, strengths=tuple(np.linspace(1, 3, SIZE)))
    stress = chain.static_stress(SIZE)
    assert chain.law.force(stress, np.linspace(1, 3, SIZE)) == pytest.approx(np.full(SIZE, 0.3), rel=1e-14)
    assert stress[0] > stress[-1] > 0


def test_a_law_in_the_fields_of_the_chain_is_that_of_the_first_format() -> None:
    old = {"n": 1.5, "law": "one_sided", "strength": 2.0, "ends": "free"}
    new = GranularChain.from_earlier(old)
    assert new == {"ends": "free", "law": {"type": "PowerContact", "kind": "one_sided", "n": 1.5, "strength": 2.0}}
    assert GranularChain.from_earlier(new) == new


@pytest.mark.parametrize(("form", "last"), [("stresses", 59), ("displacements", 59)])
def test_a_pulse_has_to_end_before_the_chain_does_on_both_sides(form: Any, last: int) -> None:
    """A millionth of its height may stand at the first and the last contact, and no more."""
    chain = GranularChain(PowerContact(3), ends="free", form=form)
    half = chain.compacton(1).width / 2
    for center in (half + 1e-9, last - half - 1e-9):
        assert np.abs(Compacton(1, center).values(chain, Lattice(60))[0]).max() > 1
    for center in (half - 1e-3, last - half + 1e-3):
        with pytest.raises(
            InputError, match=r"does not fit in the chain: at its ends the stress is .*; move the pulse inside"
        ):
            Compacton(1, center).values(chain, Lattice(60))


@pytest.mark.parametrize("ends", ["fixed", "free"])
def test_a_wave_may_stand_at_any_site_and_at_none_beyond(ends: Any) -> None:
    chain = GranularChain(PowerContact(3), ends=ends)
    for center in (0.0, 17.3, 59.0):
        chain.check_center(center, Lattice(60))
        GranularChain(PowerContact(3)).check_center(center - 200, Lattice(60))
    for center in (-1e-6, 59.001):
        with pytest.raises(InputError, match="lies outside the chain, which reaches from 0 to 59; move it inside"):
            chain.check_center(center, Lattice(60))


@pytest.mark.parametrize("ends", ["periodic", "fixed"])
def test_rates_that_do_not_add_up_are_refused_whatever_their_sign(ends: Any) -> None:
    """On a ring and between walls; a thousandth of their sizes is round-off of a run, two thousandths are not."""
    chain = GranularChain(PowerContact(3), ends=ends)
    rates = np.where(np.arange(40) % 2, 1.0, -1.0)
    for sign in (1, -1):
        chain.check_state(np.array([0 * rates, rates + sign * 0.9e-3]))
        with pytest.raises(InputError, match="The rates R_t add up to"):
            chain.check_state(np.array([0 * rates, rates + sign * 2e-3]))
        for other in ("free", "held"):
            replace(chain, ends=other).check_state(np.array([rates, rates + sign]))
        state = np.array([rates + sign * 2e-3, 0 * rates])
        if ends == "periodic":
            chain.check_state(state)
        else:
            with pytest.raises(InputError, match="between walls, which do not move, they must add up to 0"):
                chain.check_state(state)


def test_small_waves_have_the_frequency_of_a_ring_of_springs() -> None:
    """omega^2 = F'(R0) 4 sin^2(k/2): sound at long waves, 2 sqrt(F') at the shortest."""
    chain = GranularChain(PowerContact(3, strength=2, linear=0.5))
    stiffness = 6 * 0.7**2 + 0.5
    assert chain.frequency_squared(np.pi, 0.7) == pytest.approx(4 * stiffness)
    assert chain.frequency_squared(1e-4, 0.7) == pytest.approx(stiffness * 1e-8, rel=1e-6)
    assert chain.frequency_squared(2 * np.pi / 3, 0.7) == pytest.approx(3 * stiffness)
