from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mol_compactons import (
    Compacton,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Simulation,
    SolitaryWave,
    Symplectic,
    run,
)
from mol_compactons.analysis.collisions import first_collision
from mol_compactons.analysis.tracking import track
from mol_compactons.chain.solitary_wave import solitary_profile


@pytest.mark.parametrize("speed", [1e-4, 1.0, 1e4])
@pytest.mark.parametrize("n", [1.5, 2, 3, 4])
def test_residual_and_virial_ratio(n: float, speed: float) -> None:
    profile = solitary_profile(GranularChain(PowerContact(n)), speed)
    assert profile.residual < 1e-13
    energy = profile.kinetic_energy + profile.potential_energy
    assert profile.kinetic_energy / energy == pytest.approx((n + 1) / (n + 3), abs=1e-9)


@given(st.floats(1.3, 6), st.floats(0.2, 5), st.floats(0.2, 5))
@settings(max_examples=15)
def test_height_and_speed_scale(n: float, speed: float, strength: float) -> None:
    """V^2 = A r^(n-1) for a wave r times as high as that of V = A = 1."""
    unit = solitary_profile(GranularChain(PowerContact(n)), speed=1)
    other = solitary_profile(GranularChain(PowerContact(n, strength=strength)), speed=speed)
    r = (speed**2 / strength) ** (1 / (n - 1))
    assert other.amplitude == pytest.approx(r * unit.amplitude, rel=1e-10)
    assert other.half_width == pytest.approx(unit.half_width, rel=1e-10)
    assert other.total_stress == pytest.approx(r * unit.total_stress, rel=1e-10)


def test_it_solves_the_equation_of_the_chain() -> None:
    """V^2 R'' = F(R_(-1)) - 2 F(R) + F(R_1), with R'' from the cosine series."""
    chain = GranularChain(PowerContact(1.5))
    profile = solitary_profile(chain, speed=1.3)
    z = np.linspace(-3, 3, 41)
    wavenumbers = np.pi / profile.half_length * np.arange(profile.spectrum.size)
    second = -np.cos(np.multiply.outer(z, wavenumbers)) @ (wavenumbers**2 * profile.spectrum)
    before, here, after = (chain.law.force(profile(z + shift), np.ones(1)) for shift in (-1, 0, 1))
    pushes = before - 2 * here + after
    assert np.abs(1.3**2 * second - pushes).max() < 1e-9


def test_it_approaches_the_compacton_of_the_continuum_for_small_exponents() -> None:
    def distance(n: float) -> float:
        chain, z = GranularChain(PowerContact(n)), np.linspace(-8, 8, 161)
        compacton = chain.compacton(1.0)
        return float(np.abs(solitary_profile(chain, 1.0)(z) - compacton(z)).max() / compacton.amplitude)

    assert distance(1.1) < distance(1.5) < distance(3) < 0.2
    assert distance(1.1) < 0.02


@pytest.mark.parametrize(("form", "component"), [("stresses", "R"), ("displacements", "Q")])
def test_the_chain_carries_it_over_200_sites(form: str, component: str) -> None:
    chain = GranularChain(PowerContact(1.5), ends="free", form=form)  # type: ignore[arg-type]
    wave = SolitaryWave(speed=1, center=20)
    simulation = Simulation(
        equation=chain,
        grid=Lattice(size=260),
        scheme=NearestNeighbours(),
        initial=[wave],
        t_end=200,
        frames=3,
        integrator=Symplectic(step=0.02),
    )
    final = run(simulation)[component].values[-1]
    exact = wave.values(chain, simulation.grid, 200)[0]
    assert np.abs(final - exact).max() < 1e-5 * np.abs(exact).max()


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("linear", [0.0, 1.0])
def test_it_travels_to_the_left_too_with_a_linear_term_too(sign: int, linear: float) -> None:
    chain, wave = GranularChain(PowerContact(3, linear=linear)), SolitaryWave(speed=-1.4, center=60, sign=sign)
    simulation = Simulation(
        equation=chain,
        grid=Lattice(size=90),
        scheme=NearestNeighbours(),
        initial=[wave],
        t_end=20,
        frames=41,
        integrator=Symplectic(step=0.01),
    )
    dataset = run(simulation)
    assert np.abs(dataset.R.values[-1] - wave.values(chain, simulation.grid, 20)[0]).max() < 1e-6
    tracks = track(dataset)
    assert float(tracks.position[-1, 0]) == pytest.approx(60 - 28, abs=0.05)


def test_a_compressed_chain_has_one() -> None:
    chain = GranularChain(PowerContact(1.5, kind="one_sided"), compression=0.5, ends="free")
    sound = np.sqrt(1.5 * 0.5 ** (1 / 3))
    wave = SolitaryWave(speed=1.2 * sound, center=60)
    simulation = Simulation(
        equation=chain,
        grid=Lattice(size=160),
        scheme=NearestNeighbours(),
        initial=[wave],
        t_end=30,
        frames=2,
        integrator=Symplectic(step=0.02),
    )
    final = run(simulation).R.values[-1]
    assert np.abs(final - wave.values(chain, simulation.grid, 30)[0]).max() < 1e-6 * final.max()


def test_two_that_meet_head_on_leave_something_behind() -> None:
    """Not solitons: each comes out shifted, and secondary waves are born; by symmetry both fare alike."""
    simulation = Simulation(
        equation=GranularChain(PowerContact(1.5)),
        grid=Lattice(size=200),
        scheme=NearestNeighbours(),
        initial=[SolitaryWave(1, 50.5), SolitaryWave(-1, 100.5)],
        t_end=60,
        frames=241,
        integrator=Symplectic(step=0.02),
    )
    dataset = run(simulation)
    assert np.allclose(dataset.R.values, np.roll(dataset.R.values[:, ::-1], 152, axis=1), atol=1e-10)
    collision = first_collision(track(dataset))
    assert collision.phase_shift.values[0] == pytest.approx(-collision.phase_shift.values[1], abs=1e-3)
    assert 1e-3 < float(collision.momentum_left) < 0.02
    assert float(collision.phase_shift[0]) == pytest.approx(0.36, abs=0.03)


@pytest.mark.parametrize(
    ("chain", "speed", "sign", "words"),
    [
        (GranularChain(PowerContact(3, linear=1)), 0.5, 1, "speed = 0.5 is not faster than sound, 1"),
        (GranularChain(PowerContact(3, linear=1)), 1.00001, 1, "too near to that of sound"),
        (GranularChain(PowerContact(3)), 1e-300, 1, "must lie between 1e-06 and 1e"),
        (GranularChain(PowerContact(1.001)), 1, 1, "n = 1.001 is too near to 1"),
        (GranularChain(PowerContact(2, kind="rarefaction", linear=1)), 2, 1, "do not resist compression"),
        (GranularChain(PowerContact(2, kind="one_sided")), 1, -1, "do not resist tension"),
        (GranularChain(PowerContact(2), masses=(1, 2, 3)), 1, 1, "a chain of equal grains"),
        (GranularChain(PowerContact(3), compression=1), 3, -1, "no exact solitary wave of rarefaction"),
    ],
)
def test_waves_that_do_not_exist_are_refused(chain: GranularChain, speed: float, sign: int, words: str) -> None:
    with pytest.raises(InputError, match=words):
        solitary_profile(chain, speed, sign)


def test_it_is_a_wave_of_the_chain_alone() -> None:
    with pytest.raises(InputError, match="SolitaryWave is a wave of GranularChain, not of GranularCompacton"):
        Simulation(equation=GranularCompacton(3), grid=Grid(30, 100), initial=[SolitaryWave(1, 10)], t_end=1)
    with pytest.raises(InputError, match="sign = 2 must be 1"):
        SolitaryWave(1, 1, 2)
    assert Compacton(1, 10).outline(GranularCompacton(3))[1] == pytest.approx(2 * np.pi)


HERTZ: Any = PowerContact(1.5, strength=1.3)
CASES = [
    GranularChain(HERTZ),
    GranularChain(PowerContact(3, strength=0.7)),
    GranularChain(PowerContact(3, strength=0.7, linear=0.6)),
    GranularChain(PowerContact(2, linear=0.4, kind="power")),
    GranularChain(replace(HERTZ, kind="one_sided"), compression=0.4),
    GranularChain(PowerContact(3, linear=0.5), compression=0.4),
]


@pytest.mark.parametrize("chain", CASES)
@pytest.mark.parametrize("form", ["stresses", "displacements"])
@pytest.mark.parametrize("center", [30.0, 30.37])
def test_its_energies_are_those_of_the_chain_that_carries_it(chain: GranularChain, form: Any, center: float) -> None:
    """Wherever its centre lies between the sites the sum is the same, and so is the momentum, V times the shortening."""
    ends: Any = "held" if form == "stresses" else "free"
    own, wave = replace(chain, form=form, ends=ends), SolitaryWave(1.9, center)
    state, profile = wave.values(own, Lattice(61)), wave.profile(own)
    system = NearestNeighbours().discretize(own, Lattice(61))
    found = system.invariants(state) | system.diagnostics(state)
    assert min(profile.kinetic_energy, profile.potential_energy) > 0.05
    assert found["energy"] == pytest.approx(profile.kinetic_energy + profile.potential_energy, rel=1e-8)
    if form == "displacements":
        assert found["momentum"] == pytest.approx(1.9 * profile.total_stress, rel=1e-9)
        assert state[0, 0] == pytest.approx(profile.total_stress, rel=1e-9)
        assert (state[1] ** 2).sum() > 0.05


@pytest.mark.parametrize("chain", CASES)
def test_the_kinetic_part_is_the_mean_over_the_places_between_the_sites(chain: GranularChain) -> None:
    places = 30 + np.arange(8) / 8
    own = replace(chain, form="displacements", ends="free")
    momenta = [SolitaryWave(1.9, center).values(own, Lattice(61))[1] for center in places]
    kinetic = SolitaryWave(1.9, 30).profile(own).kinetic_energy
    assert np.mean([0.5 * p @ p for p in momenta]) == pytest.approx(kinetic, rel=1e-8)


@pytest.mark.parametrize("chain", CASES)
def test_its_widths_are_where_it_has_a_half_and_a_thousandth_of_its_height(chain: GranularChain) -> None:
    profile = solitary_profile(chain, 1.9)
    z = np.array([0, profile.half_width / 2, profile.width / 2, -profile.width / 2])
    assert profile(z) == pytest.approx(profile.amplitude * np.array([1, 0.5, 1e-3, 1e-3]), rel=1e-9)
    assert SolitaryWave(1.9, 5).outline(chain) == (profile.amplitude, profile.width)
    assert profile.amplitude > profile(np.array([1e-3]))[0] > 0
