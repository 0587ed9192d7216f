from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mol_compactons import (
    CVODE,
    Compacton,
    CompactScheme,
    GranularChain,
    GranularCompacton,
    Grid,
    Impact,
    InputError,
    IntegrationError,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Ripple,
    Samples,
    Simulation,
    SolitaryWave,
    Symplectic,
    Uniform,
    run,
)
from mol_compactons.analysis.drift import drift
from mol_compactons.semidiscrete import SemiDiscretization
from tests.systems import Array, analytic_jacobian, difference_jacobian, fitted_order, random_state, right_hand_side

SIZE = 12


@st.composite
def chains(draw: st.DrawFn) -> GranularChain:
    """Chains of every law, end and form, equal or not, compressed or not."""
    law: Any = draw(st.sampled_from(["odd", "one_sided", "power", "rarefaction"]))
    form: Any = draw(st.sampled_from(["stresses", "displacements"]))
    ends: Any = draw(st.sampled_from(["periodic", "fixed", "free"] + (["held"] if form == "stresses" else [])))
    n = draw(st.sampled_from({"power": [2, 3], "rarefaction": [2, 4]}.get(law, [1.5, 2, 2.7, 3])))
    linear = draw(st.sampled_from([0.0, 0.4])) if law != "one_sided" else 0.0
    compression = draw(st.sampled_from([0.0, 0.7])) if law != "rarefaction" else 0.0
    chain = GranularChain(
        PowerContact(n, strength=1.3, linear=linear, kind=law), ends=ends, form=form, compression=compression
    )
    if draw(st.booleans()):
        seed = np.random.default_rng(draw(st.integers(0, 100)))
        masses = tuple(seed.uniform(0.5, 2, chain.grain_count(SIZE)))
        strengths = tuple(seed.uniform(0.5, 2, chain.contact_count(SIZE)))
        chain = replace(chain, masses=masses, strengths=strengths)
    return chain


def system_of(chain: GranularChain, size: int = SIZE) -> SemiDiscretization:
    return NearestNeighbours().discretize(chain, Lattice(size))


def a_state(chain: GranularChain, seed: int) -> Array:
    """A random state that fits the ends."""
    state = random_state(seed, 2, SIZE)
    if chain.form == "stresses" and chain.ends in ("periodic", "fixed"):
        state[1] -= state[1].mean()
        if chain.ends == "fixed":
            state[0] -= state[0].mean()
    return state


@given(chains(), st.integers(0, 1000))
def test_what_is_conserved_does_not_change(chain: GranularChain, seed: int) -> None:
    system, state = system_of(chain), a_state(chain, seed)
    rate, step = right_hand_side(system, state), 1e-6
    ahead, behind = system.invariants(state + step * rate), system.invariants(state - step * rate)
    for name in ahead:
        if name != "energy" or chain.ends != "held":
            assert abs(ahead[name] - behind[name]) / (2 * step) < 1e-5 * (1 + abs(ahead["energy"])), name


@given(chains(), st.integers(0, 1000))
def test_jacobian_is_the_derivative(chain: GranularChain, seed: int) -> None:
    system, state = system_of(chain), a_state(chain, seed)
    static = chain.static_stress(SIZE)
    stress = state[0] if chain.form == "stresses" else np.diff(state[0])
    assume(np.abs(np.abs(stress) - static.min()).min() > 1e-3)
    assume(np.abs(stress).min() > 1e-3)
    assert np.allclose(analytic_jacobian(system, state), difference_jacobian(system, state, 1e-7), atol=1e-4)


@given(chains(), st.integers(0, 1000))
def test_stresses_and_displacements_are_the_same_chain(chain: GranularChain, seed: int) -> None:
    """R_k = Q_(k-1) - Q_k holds for the accelerations too; free ends, which have a grain more than contacts."""
    in_stresses = replace(chain, form="stresses", ends="free", masses=(), strengths=())
    if chain.masses:
        in_stresses = replace(in_stresses, masses=(*chain.masses, 1.5, 2.5)[: SIZE + 1])
    assume(len(in_stresses.masses) in (0, SIZE + 1))
    in_displacements = replace(in_stresses, form="displacements")
    grains = random_state(seed, 2, SIZE + 1)
    inverse = 1 / np.array(in_stresses.masses) if in_stresses.masses else np.ones(SIZE + 1)
    stresses = np.array([-np.diff(grains[0]), -np.diff(grains[1] * inverse)])
    by_stress = right_hand_side(system_of(in_stresses), stresses)[1]
    by_grain = right_hand_side(system_of(in_displacements, SIZE + 1), grains)[1]
    assert np.allclose(by_stress, -np.diff(by_grain * inverse), atol=1e-12)


@given(chains(), st.integers(0, 1000))
def test_equal_and_varying_chains_are_stepped_alike(chain: GranularChain, seed: int) -> None:
    """The loops for equal grains against those for any, to which the same masses and strengths are given one by one."""
    chain = replace(chain, masses=(), strengths=())
    varying = replace(chain, masses=(1.0,) * chain.grain_count(SIZE), strengths=(1.0,) * chain.contact_count(SIZE))
    state = a_state(chain, seed)
    one, other = (Symplectic(0.05).start(system_of(each), 0.1 * state, 0.5).advance(0.5) for each in (chain, varying))
    assert np.allclose(one, other, rtol=1e-11, atol=1e-12)


@given(st.sampled_from(["periodic", "free", "held"]), st.sampled_from([1.5, 3]), st.integers(0, 100))
def test_mirror_and_scaling(ends: Any, n: float, seed: int) -> None:
    """R_k -> R_(-k) and R -> r R, t -> r^((1-n)/2) t."""
    chain = GranularChain(PowerContact(n), ends=ends)
    system, state = system_of(chain), a_state(chain, seed)
    rate = right_hand_side(system, state)
    assert np.allclose(right_hand_side(system, state[:, ::-1]), rate[:, ::-1], atol=1e-13)
    slow = 4.0 ** ((n - 1) / 2)
    scaled = right_hand_side(system, np.array([4 * state[0], 4 * slow * state[1]]))
    assert np.allclose(scaled, [4 * slow * rate[0], 4 * slow**2 * rate[1]], rtol=1e-12, atol=1e-12)


def ring(n: float = 3, **fields: Any) -> Simulation:
    defaults: dict[str, Any] = {
        "equation": GranularChain(PowerContact(n)),
        "grid": Lattice(size=60),
        "scheme": NearestNeighbours(),
        "initial": [SolitaryWave(speed=1, center=20)],
        "t_end": 10,
        "frames": 3,
        "integrator": Symplectic(step=0.05),
    }
    return Simulation(**defaults | fields)


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


def test_the_corrected_velocity_moves_the_pulse_to_the_right() -> None:
    dataset = run(ring(1.5, initial=[Compacton(speed=1, center=20)], t_end=20))
    assert dataset.R.dims == ("t", "k")
    assert abs(int(np.argmax(dataset.R.values[-1])) - 40) <= 2
    assert float(dataset.energy[-1] / dataset.energy[0]) == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("n", [1.5, 3])
def test_cvode_and_the_splitting_agree(n: float) -> None:
    adams = CVODE(rtol=1e-10, atol=1e-12, method="Adams")
    pulse = [Compacton(speed=1, center=20)]
    final = run(ring(n, initial=pulse, integrator=adams)).R.values[-1]
    assert np.abs(final - run(ring(n, initial=pulse, integrator=Symplectic(step=0.02))).R.values[-1]).max() < 1e-7


@pytest.mark.parametrize("order", [2, 4, 6])
def test_the_splitting_has_its_order(order: Literal[2, 4, 6]) -> None:
    reference = run(ring(integrator=Symplectic(step=0.005, order=6), t_end=4)).R.values[-1]
    counts = [80, 160] if order < 6 else [16, 32]
    errors = [
        float(np.abs(run(ring(integrator=Symplectic(step=4 / count, order=order), t_end=4)).R.values[-1] - reference).max())
        for count in counts
    ]
    assert fitted_order(counts, errors) == pytest.approx(order, abs=0.4)


@pytest.mark.parametrize(
    "chain", [GranularChain(PowerContact(3)), GranularChain(PowerContact(1.5, kind="one_sided"), compression=1)]
)
def test_the_energy_error_stays_bounded_for_long(chain: GranularChain) -> None:
    """Over t = 10^4 the energy error of the last tenth is no larger than twice that of the first, or 1e-9."""
    wave = SolitaryWave(speed=1.6, center=10)
    simulation = ring(equation=chain, initial=[wave], t_end=10_000, frames=2001, integrator=Symplectic(step=0.05))
    errors = np.abs(drift(run(simulation)).energy)
    assert float(errors.max()) < 1e-5
    assert float(errors[-200:].max()) < 2 * float(errors[:200].max()) + 1e-9


def test_the_energy_error_of_a_hertz_chain_without_compression_wanders() -> None:
    """Ripples cross zero, where the force is not smooth: the error is no longer periodic, but wanders."""
    simulation = ring(1.5, t_end=10_000, frames=2001, integrator=Symplectic(step=0.02))
    errors = drift(run(simulation)).energy.values
    assert np.abs(errors).max() < 3e-5


def test_the_energy_error_of_a_hundred_collisions() -> None:
    """For n = 3 it is bounded too; for n = 3/2, where the force is not smooth at zero, it wanders, and falls with the step."""

    def worst(n: float, step: float) -> float:
        pulses = [Compacton(speed=1, center=10), Compacton(speed=0.6, center=30)]
        simulation = ring(n, initial=pulses, t_end=2000, frames=401, integrator=Symplectic(step=step))
        return float(np.abs(drift(run(simulation)).energy).max())

    assert worst(3, 0.05) < 1e-5
    coarse, fine = worst(1.5, 0.1), worst(1.5, 0.02)
    assert fine < 1e-5
    assert fine < 0.2 * coarse


def test_verlet_keeps_its_order_where_contacts_open() -> None:
    """A blow on a Hertz chain that parts: Verlet falls with the square of the step, and the fourth order with 5/2 at least."""

    def chain(order: Literal[2, 4, 6], step: float) -> Array:
        simulation = ring(
            equation=GranularChain(PowerContact(1.5, kind="one_sided"), form="displacements", ends="free"),
            grid=Lattice(12),
            initial=[Impact(velocity=1)],
            t_end=20,
            integrator=Symplectic(step=step, order=order),
        )
        return np.asarray(run(simulation).Q.values[-1])

    reference = chain(6, 1 / 1600)
    counts = [20, 40, 80, 160]
    verlet = [float(np.abs(chain(2, 1 / count) - reference).max()) for count in counts]
    fourth = [float(np.abs(chain(4, 1 / count) - reference).max()) for count in counts]
    assert fitted_order(counts, verlet) == pytest.approx(2, abs=0.2)
    assert fitted_order(counts, fourth) > 2.2
    assert fourth[-1] < 0.1 * verlet[-1]


def test_a_blow_on_a_chain_of_parted_grains_carries_the_momentum_away() -> None:
    """Exactly elastic: of two equal grains the first stops and the second takes its velocity."""
    two = GranularChain(PowerContact(1.5, kind="one_sided"), form="displacements", ends="free", masses=(1, 1, 1))
    gap = Samples((0.0, 1.0, 50.0, 1.0, 0.0, 0.0))
    final = run(ring(equation=two, grid=Lattice(3), initial=[gap], t_end=20)).p.values[-1]
    assert final == pytest.approx([0, 1, 0], abs=1e-5)


@pytest.mark.parametrize(
    ("attempt", "words"),
    [
        (lambda: GranularChain(PowerContact(1)), "n = 1 must be larger than 1"),
        (lambda: GranularChain(PowerContact(1.5, kind="power")), "'power' needs a whole exponent, not n = 1.5"),
        (lambda: GranularChain(PowerContact(3, kind="rarefaction")), "'rarefaction' needs an even exponent, not n = 3"),
        (lambda: GranularChain(PowerContact(2, linear=1, kind="one_sided")), "'one_sided' has no linear term"),
        (lambda: GranularChain(PowerContact(2), compression=-1), "compression = -1 must not be negative"),
        (lambda: GranularChain(PowerContact(2, kind="rarefaction"), compression=1), "compression is for laws that resist it"),
        (lambda: GranularChain(PowerContact(2), ends="held", form="displacements"), "'held' holds stresses"),
        (lambda: GranularChain(PowerContact(2), masses=(1, 0, 1)), "masses holds 0; all must be positive"),
        (lambda: system_of(GranularChain(PowerContact(2), masses=(1, 1))), "holds 2 numbers, but the chain has 12 grains"),
        (
            lambda: system_of(GranularChain(PowerContact(2), strengths=(1, 1), ends="free", form="displacements")),
            "the chain has 11 contacts",
        ),
        (lambda: Lattice(2), "between 3 and"),
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
        (lambda: ring(initial=[Impact(1)]), "Impact moves the grains of a GranularChain in displacements"),
        (
            lambda: ring(
                equation=GranularChain(PowerContact(2), form="displacements", ends="free"), initial=[Impact(1, 59, 2)]
            ),
            "up to number 60, but the chain has 60",
        ),
        (lambda: Impact(1, -1), "must not be negative"),
        (lambda: Symplectic(step=0), "step = 0 must be positive"),
        (
            lambda: GranularChain(PowerContact(2)).check_state(np.array([np.ones(5), np.ones(5)])),
            "add up to 5, but on a ring or between walls they must add up to 0",
        ),
        (
            lambda: CompactScheme().discretize(GranularChain(PowerContact(2)), Lattice(20)),
            "on a Grid, not for GranularChain on a Lattice",
        ),
        (
            lambda: NearestNeighbours().discretize(GranularCompacton(2), Grid(10, 20)),
            "is for a GranularChain on a Lattice, not for GranularCompacton",
        ),
        (
            lambda: Symplectic().check_system(CompactScheme().discretize(GranularCompacton(2), Grid(10, 20))),
            "Symplectic is for a GranularChain",
        ),
    ],
)
def test_bad_input_is_named(attempt: Callable[[], Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        attempt()


def test_a_step_that_is_too_long_says_so() -> None:
    with pytest.raises(IntegrationError, match=r"integrator\.step = 5 is too long for the stiffness"):
        run(ring(initial=[Compacton(speed=3, center=20)], t_end=500, integrator=Symplectic(step=5)))
