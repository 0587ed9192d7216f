from __future__ import annotations

from collections.abc import Callable
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
