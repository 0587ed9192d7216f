"""Travelling waves and their Floquet multipliers: symmetries of the spectrum, and values that others have found too."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any, Literal

import numpy as np
import pytest
import xarray as xr

from mol_compactons import (
    Compacton,
    CompactScheme,
    ConservativeScheme,
    GranularChain,
    GranularCompacton,
    Grid,
    Impact,
    InputError,
    Lattice,
    PadeScheme,
    PeriodicWave,
    PowerContact,
    RosenauHyman,
    Simulation,
    SolitaryWave,
    orbit,
)
from mol_compactons.analysis.orbits import Period, advance
from mol_compactons.analysis.wave_orbits import CHAIN_WINDOW, NARROWER, report_orbit, speed_of_wave, window

K22 = RosenauHyman(2, 2, absolute=True)


def wave(scheme: Any, size: int = 80, length: float = 16, **start: Any) -> Simulation:
    """The compacton of |K|(2, 2)."""
    start = {"speed": 1, "center": length / 2, **start}
    return Simulation(K22, Grid(length, size), [Compacton(**start)], 1, scheme)


def chain(law: Any, speed: float, size: int = 40, **fields: Any) -> Simulation:
    return Simulation(GranularChain(law, **fields), Lattice(size), [SolitaryWave(speed, size / 2)], 1)


def multipliers(dataset: xr.Dataset) -> Any:
    return (dataset.multiplier_real + 1j * dataset.multiplier_imag).values


def farthest(values: Any, others: Any) -> float:
    """The largest distance from one set to the other."""
    return float(np.abs(values[:, None] - others[None, :]).min(axis=1).max())


@cache
def ismail_taha() -> xr.Dataset:
    return orbit(wave(PadeScheme("ismail_taha")))


def test_the_wave_is_a_fixed_point_near_the_exact_one() -> None:
    dataset, start = ismail_taha(), wave(PadeScheme("ismail_taha")).initial_state()[0]
    assert dataset.attrs["residual"] < 1e-12
    assert 1e-6 < dataset.attrs["correction"] < 0.02
    assert np.abs(dataset.u.values - start).max() / start.max() == pytest.approx(dataset.attrs["correction"])
    assert dataset.u.dims == ("x",)


def test_multipliers_come_in_complex_pairs_and_where_the_scheme_is_hamiltonian_in_reciprocal_ones() -> None:
    found = multipliers(ismail_taha())
    assert found.size == 80
    assert farthest(found.conj(), found) < 1e-10
    assert np.abs(found[0]) > 1.01
    # Those of the double multiplier 1 are split by rounding.
    apart = found[np.abs(found - 1) > 1e-3]
    assert farthest(1 / apart, found) < 1e-8


def test_one_is_a_double_multiplier_within_its_bars() -> None:
    dataset = ismail_taha()
    distance = np.abs(multipliers(dataset) - 1)
    nearest = distance.argsort()[:2]
    assert (distance[nearest] <= dataset.error.values[nearest]).all()
    assert dataset.error.values[nearest].max() < 1e-4


def test_modes_are_eigenvectors_of_the_map_by_differences() -> None:
    dataset, simulation = ismail_taha(), wave(PadeScheme("ismail_taha"))
    system, period = simulation.discretize(), Period(0.2)
    state, mode = dataset.u.values[None], (dataset.mode_real + 1j * dataset.mode_imag).values[0]
    assert np.linalg.norm(mode) == pytest.approx(1)

    def pushed(direction: Any) -> Any:
        ahead, behind = (advance(system, state + sign * 1e-5 * direction, period) for sign in (1, -1))
        return (ahead - behind) / 2e-5

    found = pushed(mode.real) + 1j * pushed(mode.imag)
    assert np.linalg.norm(found - multipliers(dataset)[0] * mode) < 1e-3


@pytest.mark.parametrize(
    ("scheme", "largest"),
    [
        (PadeScheme("ismail_taha"), 1.026571),
        (PadeScheme("de_frutos"), 1.085904),
        (PadeScheme("pade_6"), 1.186294),
        (PadeScheme("pade_8"), 1.178496),
    ],
)
def test_the_largest_multipliers_of_the_four_stencils_on_a_coarse_grid(scheme: PadeScheme, largest: float) -> None:
    """N = 100, h = 0.16; those of the literature, at h = 0.02, take longer."""
    dataset = orbit(wave(scheme, size=100))
    assert float(dataset.modulus[0]) == pytest.approx(largest, abs=2e-6)
    assert dataset.attrs["verdict"] == "unstable"
    # Its mode is a sawtooth at the front edge, near to -1.
    assert np.real(multipliers(dataset)[0]) < -0.9
    mode = np.hypot(dataset.mode_real, dataset.mode_imag).values[0, 0]
    assert float(dataset.x[mode.argmax()]) == pytest.approx(8 + 2 * np.pi, abs=0.5)
    power = np.abs(np.fft.fft((dataset.mode_real + 1j * dataset.mode_imag).values[0, 0])) ** 2
    assert power[np.abs(np.fft.fftfreq(100)) > 1 / 3].sum() > 0.5 * power.sum()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scheme", "largest"),
    [
        (PadeScheme("ismail_taha"), 1.06712),
        (PadeScheme("de_frutos"), 1.13419),
        (PadeScheme("pade_6"), 1.15597),
        (PadeScheme("pade_8"), 1.14778),
        (ConservativeScheme(2), 1.06712),
    ],
)
def test_the_one_cell_multipliers_of_the_literature(scheme: Any, largest: float) -> None:
    """C = 1, L = 16, h = 0.02, ten steps of Gauss-Legendre 4 for each cell: 1.0671 for Ismail-Taha, the others above."""
    dataset = orbit(wave(scheme, size=800))
    assert float(dataset.modulus[0]) == pytest.approx(largest, abs=1e-5)
    assert dataset.attrs["residual"] < 1e-11


def test_the_conservative_scheme_of_second_order_is_ismail_taha_here_too() -> None:
    ours = orbit(wave(ConservativeScheme(2)))
    assert farthest(multipliers(ours)[:6], multipliers(ismail_taha())) < 1e-9
    assert ours.u.values == pytest.approx(ismail_taha().u.values, abs=1e-10)


def test_a_higher_wave_has_the_same_multipliers() -> None:
    """U -> r u, t -> t / r: a cell takes a time h / c that is as much shorter."""
    for speed in (1e-3, 50.0):
        other = orbit(wave(PadeScheme("ismail_taha"), speed=speed))
        assert float(other.modulus[0]) == pytest.approx(float(ismail_taha().modulus[0]), abs=1e-9)
        assert farthest(multipliers(other)[:4], multipliers(ismail_taha())) < 1e-8
        assert other.u.values == pytest.approx(speed * ismail_taha().u.values, rel=1e-6, abs=1e-8 * speed)


def test_a_dark_wave_has_those_of_the_bright_one() -> None:
    dark = orbit(wave(PadeScheme("ismail_taha"), sign=-1))
    assert dark.u.values == pytest.approx(-ismail_taha().u.values, abs=1e-10)
    assert farthest(multipliers(dark)[:6], multipliers(ismail_taha())) < 1e-9


def test_where_it_is_on_the_grid_does_not_matter() -> None:
    moved = orbit(wave(PadeScheme("ismail_taha"), center=9.2))
    assert np.roll(moved.u.values, -6) == pytest.approx(ismail_taha().u.values, abs=1e-10)
    assert farthest(multipliers(moved)[:6], multipliers(ismail_taha())) < 1e-9


def test_the_sixth_order_in_time_finds_the_same_within_the_bars() -> None:
    finer = orbit(wave(PadeScheme("ismail_taha")), order=6, steps=20)
    assert 0 < float(ismail_taha().step_error[0]) < 1e-4
    bar = 2 * float(ismail_taha().step_error[0] + ismail_taha().error[0])
    assert abs(float(finer.modulus[0] - ismail_taha().modulus[0])) < bar


@pytest.mark.parametrize(
    ("order", "n"),
    [(2, 3), (4, 2), *(pytest.param(order, n, marks=pytest.mark.slow) for order, n in [(2, 2), (4, 3), (6, 2), (6, 3)])],
)
def test_the_conservative_scheme_of_the_granular_equation_is_stable(n: float, order: Literal[2, 4, 6]) -> None:
    """1.0000 on the ring, where a compact scheme that keeps no momentum is far outside."""
    length = 20 if n == 2 else 12
    simulation = Simulation(GranularCompacton(n), Grid(length, 100), [Compacton(1, length / 2)], 1, ConservativeScheme(order))
    dataset = orbit(simulation)
    assert float(dataset.modulus.max()) < 1 + 5e-5
    other = orbit(replace(simulation, scheme=CompactScheme("nearest", viscosity=0)))
    assert float(other.modulus[0]) > 1.05
    assert dataset.attrs["correction"] > 1e-4
    found = multipliers(dataset)
    assert farthest(found.conj(), found) < 1e-10


@pytest.mark.parametrize(
    ("law", "speed"),
    [(PowerContact(1.5), 1), (PowerContact(2), -1), (PowerContact(3), 2), (PowerContact(2, linear=1), 1.3)],
)
def test_the_wave_of_a_chain_has_no_multiplier_outside_the_circle(law: Any, speed: float) -> None:
    dataset = orbit(chain(law, speed))
    assert dataset.attrs["around"] == "window"
    outside = dataset.modulus.values - 1
    bars = (dataset.error + dataset.step_error + dataset.window_error).values
    assert (outside[:6] <= bars[:6]).all()
    pair = np.abs(multipliers(dataset) - 1).argsort()[:2]
    assert set(pair) == {0, 1}
    assert bars[:2].max() < 1e-5
    assert np.abs(multipliers(dataset)[pair] - 1).max() < 1e-3
    assert outside[2] < -0.1
    assert dataset.attrs["verdict"] == "stable"
    assert dataset.attrs["correction"] < 1e-4


def test_the_multipliers_of_a_chain_do_not_depend_on_its_length_nor_on_the_side() -> None:
    short, long = (orbit(chain(PowerContact(1.5), speed, size)) for speed, size in ((1.0, 40), (-1.0, 70)))
    assert short.modulus.values[2:5] == pytest.approx(long.modulus.values[2:5], abs=1e-6)


def test_around_the_ring_a_change_meets_the_wave_again_and_the_longer_the_ring_the_later() -> None:
    largest = [float(orbit(chain(PowerContact(1.5), 1, size), around="ring").modulus[0]) for size in (30, 60)]
    assert 1.02 < largest[1] < largest[0]
    # A factor for each round.
    assert 30 * np.log(largest[0]) == pytest.approx(60 * np.log(largest[1]), rel=0.3)


@pytest.mark.parametrize("around", ["ring", "window"])
def test_the_dataset_says_what_it_is_and_goes_through_a_file(around: Literal["ring", "window"], tmp_path: Any) -> None:
    simulation = wave(PadeScheme("pade_8"), size=60, length=20)
    dataset = orbit(simulation, around=around)
    dataset.to_netcdf(tmp_path / "orbit.nc")
    with xr.open_dataset(tmp_path / "orbit.nc") as read:
        assert report_orbit(read) == report_orbit(dataset)
        assert Simulation.from_json(read.attrs["simulation"]) == simulation
        xr.testing.assert_equal(read.load(), dataset)
    assert bool((dataset.window_error == 0).all()) == (around == "ring")
    assert (np.diff(dataset.modulus.values) <= 1e-12).all()
    lines = report_orbit(dataset)
    assert f"followed around the {around}" in lines[-8]
    assert lines[-7].startswith(f"  {float(dataset.modulus[0]):.8f} +- ")
    assert lines[-1].startswith(f"verdict: {dataset.attrs['verdict']}: ")


def test_a_window_lies_about_the_wave_and_a_share_of_it_within() -> None:
    simulation = chain(PowerContact(3), 1)
    cells, fewer = window(simulation), window(simulation, NARROWER)
    places = simulation.grid.coordinates[cells]
    width = SolitaryWave(1, 0).outline(simulation.equation)[1]
    assert places.mean() == 20
    assert np.abs(places - 20).max() == np.floor(CHAIN_WINDOW * width)
    assert fewer.sum() <= cells.sum()
    assert not (fewer & ~cells).any()


def test_a_periodic_wave_goes_without_a_window() -> None:
    smooth = Simulation(
        GranularCompacton(3), Grid(2 * np.pi, 32), [PeriodicWave(speed=2, crest=1.7)], 1, ConservativeScheme(4)
    )
    assert orbit(smooth).attrs["verdict"] == "stable"
    with pytest.raises(InputError, match="around='window' is for one wave with a place and a width"):
        orbit(smooth, around="window")


STRUCK = Simulation(GranularChain(PowerContact(2), form="displacements", ends="free"), Lattice(20), [Impact(1.0)], 1)


def test_what_has_no_orbit_is_refused_in_a_sentence() -> None:
    one = wave(PadeScheme())
    with pytest.raises(InputError, match=r"set scheme\.viscosity=0 and scheme\.grid_viscosity=0"):
        orbit(replace(one, scheme=CompactScheme(viscosity=1e-3)))
    with pytest.raises(InputError, match="initial holds 2 waves; an orbit is that of one"):
        speed_of_wave(replace(wave(PadeScheme(), length=40), initial=[Compacton(1, 8), Compacton(1, 30)]))
    with pytest.raises(InputError, match="Impact does not know the speed at which it travels; give the speed"):
        orbit(STRUCK)
    with pytest.raises(InputError, match=r"speed = 0 must not be 0"):
        orbit(one, speed=0)
    with pytest.raises(InputError, match="around = 'box' must be 'ring' or 'window'"):
        orbit(one, around="box")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="does not fit in the ring of length 14; choose a longer one"):
        orbit(wave(PadeScheme(), length=14), around="window")
    with pytest.raises(InputError, match="steps = 0 must lie between"):
        orbit(one, steps=0)


def test_the_speed_of_a_wave_is_its_own() -> None:
    assert speed_of_wave(wave(PadeScheme(), speed=2.5)) == 2.5
