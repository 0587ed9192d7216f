from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mol_compactons import (
    ChainCompacton,
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
from mol_compactons.analysis.chain_and_continuum import compare, continuum_of, lattice_scale, on_lattice, two_way_continuum_of


def chain(strength: float = 1.0, n: float = 1.5) -> Simulation:
    return Simulation(
        equation=GranularChain(PowerContact(n, strength=strength)),
        grid=Lattice(40),
        scheme=NearestNeighbours(),
        initial=[Compacton(speed=strength**0.5, center=10.3), Compacton(speed=0.5 * strength**0.5, center=30, sign=-1)],
        t_end=4,
        frames=41,
        integrator=Symplectic(step=0.02),
    )


@pytest.mark.parametrize("strength", [1.0, 2.5])
@pytest.mark.parametrize("n", [1.5, 3])
def test_both_start_from_the_same_data(strength: float, n: float) -> None:
    simulation = replace(chain(strength, n), t_end=0.4, frames=5)
    smooth = run(continuum_of(simulation))
    comparison = compare(run(simulation), smooth)
    assert float(comparison.distance[0]) < 1e-3
    assert comparison.continuum_position.values[0] == pytest.approx([10.3, 30], abs=1e-3)
    assert comparison.continuum.shape == comparison.R.shape


@pytest.mark.parametrize("two_way", [False, True])
@pytest.mark.parametrize(("strength", "n"), [(2.5, 1.5), (0.6, 3)])
def test_place_height_width_and_profile_are_those_of_the_chain(strength: float, n: float, two_way: bool) -> None:
    """In sites, whatever the units of the continuum: at first all are those of the compacton, at last all have moved."""
    speed = strength**0.5
    equation = GranularChain(PowerContact(n, strength=strength), ends="held")
    simulation = replace(chain(strength, n), equation=equation, initial=[ChainCompacton(speed, 12.3)], t_end=1)
    shape = equation.compacton(speed)
    continuum = two_way_continuum_of(simulation) if two_way else continuum_of(simulation)
    comparison = compare(run(simulation), run(continuum))
    first, last = comparison.isel(t=0, wave=0), comparison.isel(t=-1, wave=0)
    # A grid of one point for each site holds the wave as it stands, and no more.
    coarse = 0.15 if two_way else 2e-3
    assert float(first.continuum_position) == pytest.approx(12.3, abs=coarse)
    assert float(first.continuum_height) == pytest.approx(shape.amplitude, rel=coarse)
    assert float(first.continuum_width) == pytest.approx(shape.half_width, rel=coarse)
    # The chain's own wave has another shape, and for n = 3 few points.
    assert float(first.position) == pytest.approx(12.3, abs=0.1)
    assert float(first.height) == pytest.approx(shape.amplitude, rel=0.15)
    assert float(first.width) == pytest.approx(shape.half_width, rel=0.2)
    assert comparison.continuum.values[0] == pytest.approx(shape(np.arange(40.0) - 12.3), abs=3e-3 * shape.amplitude)
    assert float(last.continuum_position) == pytest.approx(12.3 + speed, abs=0.15 if two_way else 0.01)
    assert float(last.position) == pytest.approx(12.3 + speed, abs=0.4)
    norm = np.linalg.norm(comparison.R.values, axis=1)
    expected = np.linalg.norm(comparison.R.values - comparison.continuum.values, axis=1) / norm
    assert comparison.distance.values == pytest.approx(expected)
    assert float(comparison.distance[0]) < 5e-3 < float(comparison.distance[-1])


def test_a_continuum_is_as_long_and_runs_as_long_as_the_chain() -> None:
    """In units of sqrt(beta) and sqrt(beta / A): beta = n / (6 (n+1)) is 1/10 for n = 3/2."""
    simulation = chain(strength=2.5)
    continuum = continuum_of(simulation, points_per_site=8)
    assert continuum.grid.length == pytest.approx(40 * 10**0.5)
    assert (continuum.grid.size, continuum.frames) == (320, simulation.frames)
    assert continuum.t_end == pytest.approx(4 * 25**0.5)
    waves = [(wave.speed, wave.center, wave.sign) for wave in continuum.initial]  # type: ignore[attr-defined]
    assert waves == [pytest.approx((1, 10.3 * 10**0.5, 1)), pytest.approx((0.25, 30 * 10**0.5, -1))]
    simulation = replace(simulation, initial=simulation.initial[:1])
    own = two_way_continuum_of(simulation)
    assert (own.grid.length, own.grid.size, own.t_end, own.frames) == (40, 40, 4, simulation.frames)
    assert own.initial == simulation.initial


@pytest.mark.parametrize("strength", [1.0, 2.5])
def test_speeds_agree_for_c_1_only(strength: float) -> None:
    """The chain at sqrt(c A), the continuum at c sqrt(A)."""
    simulation = chain(strength)
    comparison = compare(run(simulation), run(continuum_of(simulation)))
    own = (comparison.position[-1] - comparison.position[0]).values / 4 / np.sqrt(strength)
    other = (comparison.continuum_position[-1] - comparison.continuum_position[0]).values / 4 / np.sqrt(strength)
    assert own == pytest.approx([1, 0.5], abs=0.04)
    assert other == pytest.approx([1, 0.25], abs=0.001)


def test_nesterenko_has_the_speed_of_the_chain() -> None:
    simulation = replace(chain(), initial=[Compacton(0.5, 10)])
    comparison = compare(run(simulation), run(two_way_continuum_of(simulation)))
    assert float(comparison.continuum_position[-1, 0]) == pytest.approx(12, abs=0.05)
    assert float(comparison.distance[-1]) < 0.2


def test_the_scale_is_the_width_of_the_compacton() -> None:
    equation = GranularChain(PowerContact(1.5))
    ratio = equation.compacton(1.0).width / GranularCompacton(1.5).compacton(1.0).width
    assert lattice_scale(equation) == pytest.approx(ratio)


@pytest.mark.parametrize(
    ("attempt", "words"),
    [
        (lambda: continuum_of(replace(chain(), initial=[SolitaryWave(1, 20)])), "nothing but compactons"),
        (
            lambda: continuum_of(replace(chain(), equation=GranularChain(PowerContact(3, linear=0.1)))),
            "with a linear term does not follow",
        ),
        (lambda: continuum_of(replace(chain(), initial=[Compacton(-1, 20)])), "waves to the right only"),
        (lambda: continuum_of(replace(chain(), initial=[Compacton(1, 10), Compacton(-1, 30)])), "waves to the right only"),
        (
            lambda: two_way_continuum_of(replace(chain(), equation=GranularChain(PowerContact(1.5), compression=0.5))),
            "without compression",
        ),
        (lambda: compare(run(chain()), wave(40 * 10**0.5, left=-30)), "begins at x = -9.48683"),
        (
            lambda: compare(run(replace(chain(), initial=[Compacton(1, 10), Compacton(0.5, 30)])), wave(40 * 10**0.5)),
            "The chain has 2 waves and the continuum 1",
        ),
        (lambda: continuum_of(continuum_of(chain())), "that of a GranularChain, not of GranularCompacton"),
        (lambda: compare(wave(30), wave(30)), "must be of a GranularChain in stresses"),
        (lambda: compare(run(chain()), wave(30)), "sites long, and the chain 40"),
    ],
)
def test_results_that_do_not_belong_together(attempt: Callable[[], Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        attempt()


def wave(length: float, left: float = 0) -> xr.Dataset:
    grid = Grid(length, 200, left)
    return run(Simulation(equation=GranularCompacton(1.5), grid=grid, initial=[Compacton(1, 20)], t_end=0.1, frames=5))


def test_on_lattice_is_for_equations_of_the_chain() -> None:
    from mol_compactons import RosenauHyman

    other = run(Simulation(equation=RosenauHyman(2, 2), grid=Grid(40, 90), initial=[Compacton(1, 10)], t_end=0.1, frames=3))
    with pytest.raises(InputError, match="with GranularCompacton or Nesterenko, not with RosenauHyman"):
        on_lattice(other, chain().to_json())


def test_the_order_of_dimensions_changes_nothing() -> None:
    simulation = chain(1.0)
    discrete, smooth = run(simulation), run(continuum_of(simulation))
    comparison = compare(discrete, smooth)
    assert float(comparison.distance[-1]) > 0.01
    xr.testing.assert_identical(compare(discrete.transpose("k", "t"), smooth.transpose("x", "t")), comparison)
