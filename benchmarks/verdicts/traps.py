"""Exact waves under settings that invite a bar that is too small."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from benchmarks.verdicts.known import Known, free_waves, of_free_waves, one
from mol_compactons import (
    CVODE,
    IDA,
    Compacton,
    CompactScheme,
    ConservativeScheme,
    Family,
    GranularCompacton,
    Grid,
    RosenauHyman,
    Rosenbrock,
    Simulation,
)

FOURTH, WIDE = ConservativeScheme(order=4), CompactScheme("wide")


def loose() -> Known:
    """A wave of n = 3 at the tolerances 1e-2 and 1e-3, so that the error of time is larger than that of the grid."""
    return of_free_waves(_cubic(integrator=CVODE(rtol=1e-3)), Family(schemes=(FOURTH, WIDE), tolerances=(1e-2, 1e-3)))


def loose_hertz() -> Known:
    """A wave of n = 3/2 at the tolerances 1e-2 and 1e-3 of IDA, whose error need not follow them."""
    simulation = one(GranularCompacton(1.5), 40, 320, 10, scheme=FOURTH, integrator=IDA(rtol=1e-3))
    return of_free_waves(simulation, Family(schemes=(FOURTH, WIDE), tolerances=(1e-2, 1e-3)))


def loose_rosenbrock() -> Known:
    """A wave of n = 2 at the tolerances 1e-2 and 1e-3 of `Rosenbrock`."""
    simulation = one(GranularCompacton(2), 30, 320, 10, scheme=FOURTH, integrator=Rosenbrock(rtol=1e-3))
    return of_free_waves(simulation, Family(schemes=(FOURTH, WIDE), tolerances=(1e-2, 1e-3)))


def coarse_absolute() -> Known:
    """A wave of n = 2 with an absolute tolerance of 1e-2, which hides the relative one."""
    return of_free_waves(_quadratic(integrator=CVODE(rtol=1e-5, atol=1e-2)), Family(schemes=(FOURTH, WIDE)))


def near_tolerances() -> Known:
    """Two loose tolerances that differ by a hundredth: their difference says nothing of the error of time."""
    family = Family(schemes=(FOURTH, WIDE), tolerances=(1.01e-3, 1e-3))
    return of_free_waves(_quadratic(t_end=10, integrator=CVODE(rtol=1e-3)), family)


def near_steps() -> Known:
    """Sizes that differ by a twenty-fifth: their differences are small, whatever the error is."""
    return of_free_waves(_quadratic(t_end=8), Family(sizes=(100, 104, 108), schemes=(FOURTH, WIDE)))


def near_steps_cubic() -> Known:
    """The same for n = 3, where the position of the kink between the points is most of the difference."""
    return of_free_waves(_cubic(t_end=8), Family(sizes=(150, 152, 154), schemes=(FOURTH, WIDE)))


def near_viscosities() -> Known:
    """Two strong viscosities in grid units that differ by a hundredth."""
    schemes = (ConservativeScheme(order=4, viscosity_order=6), CompactScheme("five_point", viscosity_order=6))
    return of_free_waves(_cubic(), Family(sizes=(60, 90, 120), schemes=schemes, grid_viscosities=(1.01, 1.0)))


def near_fixed_viscosities() -> Known:
    """Two fixed viscosities that differ by a hundredth, h -> 0 before eps -> 0."""
    family = Family(sizes=(120, 240, 480), schemes=(FOURTH, CompactScheme("five_point")), viscosities=(2.02e-3, 2e-3))
    return of_free_waves(_quadratic(), family)


def three_turns() -> Known:
    """A wave of n = 2, three times round a ring that is little longer than the wave, at the tolerances 1e-3 and 1e-4."""
    simulation = one(GranularCompacton(2), 14, 128, 42, scheme=FOURTH, frames=211, integrator=CVODE(rtol=1e-4))
    return of_free_waves(simulation, Family(schemes=(FOURTH, WIDE)))


def three_turns_few_frames() -> Known:
    """A wave of n = 3, three times round a ring that is seen four times only, 1.1 rings apart."""
    simulation = one(GranularCompacton(3), 10, 128, 33, scheme=FOURTH, frames=4, integrator=CVODE(rtol=1e-4))
    return of_free_waves(simulation, Family(schemes=(FOURTH, WIDE)))


def short_ring() -> Known:
    """A wave of n = 3/2 in a ring of its own length, where nothing is clear of the wave."""
    return of_free_waves(
        one(GranularCompacton(1.5), 15.75, 160, 6, scheme=FOURTH, integrator=CVODE(rtol=1e-4)), Family(schemes=(FOURTH, WIDE))
    )


def one_scheme() -> Known:
    """A wave of n = 2 with no second scheme to compare with."""
    return of_free_waves(_quadratic(), Family(schemes=(FOURTH,)))


def relatives() -> Known:
    """A wave of n = 2 by two members of one class of schemes, which share their faults."""
    return of_free_waves(_quadratic(), Family(schemes=(ConservativeScheme(order=2), FOURTH)))


def viscous() -> Known:
    """A wave of n = 2 with viscosities fixed while h -> 0, and then to zero; the wave is worn down on its way."""
    family = Family(
        sizes=(160, 320, 640),
        schemes=(FOURTH, CompactScheme("five_point")),
        viscosities=(4e-3, 2e-3, 1e-3),
        tolerances=(1e-4, 1e-5),
    )
    return of_free_waves(_quadratic(integrator=CVODE(rtol=1e-5)), family)


def viscous_cubic() -> Known:
    """The same for n = 3, where the error goes like a power of eps below 1."""
    family = Family(
        sizes=(160, 320, 640),
        schemes=(FOURTH, CompactScheme("five_point")),
        viscosities=(4e-3, 2e-3, 1e-3),
        tolerances=(1e-4, 1e-5),
    )
    return of_free_waves(_cubic(integrator=CVODE(rtol=1e-5)), family)


def dies_when_fine() -> Known:
    """A wave of n = 2, given so few steps that the second scheme ends on coarse grids only."""
    simulation = _quadratic(t_end=6, frames=7, integrator=CVODE(rtol=1e-4, max_steps=950))
    return of_free_waves(simulation, Family(schemes=(FOURTH, WIDE)))


def touching() -> Known:
    """Two compactons of n = 2 and one speed whose supports touch."""
    width = GranularCompacton(2).compacton(1.0).width
    waves = [Compacton(1, 8), Compacton(1, 8 + width * (1 + 1e-9))]
    simulation = Simulation(
        GranularCompacton(2), Grid(40, 320), waves, t_end=4, frames=31, scheme=FOURTH, integrator=CVODE(rtol=1e-4)
    )
    family = Family(schemes=(FOURTH, WIDE))
    truths = {name: truth for name, truth in free_waves(simulation, family).items() if not name.endswith("left")}
    return Known(simulation, family, truths)


def before_they_meet() -> Known:
    """Two compactons of K(3, 3), stopped when the fast one is about to touch the slow one."""
    waves = [Compacton(1, 8), Compacton(0.25, 18.5)]
    simulation = Simulation(RosenauHyman(3, 3), Grid(36, 480), waves, t_end=1.3, frames=31, integrator=CVODE())
    return of_free_waves(simulation, Family(schemes=(replace(FOURTH, viscosity_order=6), WIDE), grid_viscosities=(0.02, 0.01)))


def _quadratic(t_end: float = 4, **settings: Any) -> Simulation:
    settings = {"scheme": FOURTH, "integrator": CVODE(rtol=1e-4)} | settings
    return one(GranularCompacton(2), 30, 320, t_end, **settings)


def _cubic(t_end: float = 4, **settings: Any) -> Simulation:
    settings = {"scheme": FOURTH, "integrator": CVODE(rtol=1e-4)} | settings
    return one(GranularCompacton(3), 30, 320, t_end, **settings)


FAMILIES: tuple[Callable[[], Known], ...] = (
    loose, loose_hertz, loose_rosenbrock, coarse_absolute, near_tolerances, near_steps, near_steps_cubic, near_viscosities,
    near_fixed_viscosities, three_turns, three_turns_few_frames, short_ring, one_scheme, relatives, viscous, viscous_cubic,
    dies_when_fine, touching, before_they_meet,
)  # fmt: skip
