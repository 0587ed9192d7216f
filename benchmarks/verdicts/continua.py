"""Exact waves of continuous equations, under settings that suit them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.verdicts.known import Known, Truth, exact_norm, of_free_waves, one
from mol_compactons import (
    CVODE,
    CentralScheme,
    Compacton,
    CompactScheme,
    ConservativeScheme,
    CustomEquation,
    Family,
    Formula,
    FourierScheme,
    GranularCompacton,
    Grid,
    Midpoint,
    Nesterenko,
    PeriodicWave,
    RosenauHyman,
    Rosenbrock,
    Simulation,
)
from mol_compactons.integrators.base import Integrator

UNDAMPED = (ConservativeScheme(order=4), CompactScheme("wide"))
DAMPED = (ConservativeScheme(order=4, viscosity_order=6), CompactScheme("five_point", viscosity_order=6))
"""The default of the granular equation, and a scheme of another kind that costs less than the Fourier scheme."""


def hertz() -> Known:
    """One compacton of n = 3/2, whose edge is smooth."""
    return of_free_waves(
        one(GranularCompacton(1.5), 40, 320, 4, scheme=UNDAMPED[0], integrator=CVODE(rtol=1e-4)), Family(schemes=UNDAMPED)
    )


def quadratic() -> Known:
    """One compacton of n = 2."""
    return of_free_waves(
        one(GranularCompacton(2), 30, 320, 4, scheme=UNDAMPED[0], integrator=CVODE(rtol=1e-4)), Family(schemes=UNDAMPED)
    )


def rational() -> Known:
    """One compacton of n = 7/3, neither of the exponents with code of their own."""
    return of_free_waves(
        one(GranularCompacton(7 / 3), 30, 320, 4, scheme=UNDAMPED[0], integrator=CVODE(rtol=1e-4)), Family(schemes=UNDAMPED)
    )


def cubic() -> Known:
    """One compacton of n = 3, with a kink at its edge."""
    return of_free_waves(
        one(GranularCompacton(3), 30, 400, 4, scheme=UNDAMPED[0], integrator=CVODE(rtol=1e-4)), Family(schemes=UNDAMPED)
    )


def cusp() -> Known:
    """One compacton of n = 5, with an infinite slope at its edge, at an accuracy of 5 %."""
    return of_free_waves(one(GranularCompacton(5), 30, 320, 2), Family(schemes=DAMPED, accuracy=0.05))


def defaults() -> Known:
    """One compacton of n = 2 with nothing said: default scheme, integrator and family."""
    return of_free_waves(one(GranularCompacton(2), 30, 320, 4))


def dark() -> Known:
    """A dark compacton of n = 2."""
    return of_free_waves(one(GranularCompacton(2), 30, 320, 4, sign=-1), Family(schemes=DAMPED))


def slow() -> Known:
    """A compacton of n = 3 with c = 1e-4, a hundredth as high as that of c = 1."""
    return of_free_waves(one(GranularCompacton(3), 30, 400, 4e4, speed=1e-4), Family(schemes=DAMPED))


def fast() -> Known:
    """A compacton of n = 2 with c = 1e4."""
    return of_free_waves(one(GranularCompacton(2), 30, 320, 4e-4, speed=1e4), Family(schemes=DAMPED))


def k22() -> Known:
    """One compacton of the classical K(2, 2)."""
    return of_free_waves(one(RosenauHyman(2, 2), 30, 320, 4))


def k22_absolute() -> Known:
    """One dark compacton of |K|(2, 2), which moves to the right."""
    return of_free_waves(one(RosenauHyman(2, 2, absolute=True), 30, 320, 4, sign=-1))


def k33() -> Known:
    """One compacton of K(3, 3), with a kink at its edge."""
    return of_free_waves(one(RosenauHyman(3, 3), 24, 400, 4))


def periodic_cubic() -> Known:
    """The smooth wave sqrt(1 + cos(x - t) / 2) of n = 3, by the conservative and the Fourier scheme."""
    schemes = (ConservativeScheme(order=4), FourierScheme())
    return _periodic(3, 1.5**0.5, Family(sizes=(24, 48, 96), schemes=schemes, tolerances=(1e-3, 1e-4)), CVODE(rtol=1e-4))


def periodic_hertz() -> Known:
    """A smooth wave of n = 3/2 near its compacton, whose troughs are flat."""
    return _periodic(1.5, 1.5, Family(sizes=(32, 64, 128)), CVODE(rtol=1e-5))


def _periodic(n: float, crest: float, family: Family, integrator: Integrator) -> Known:
    wave, equation = PeriodicWave(speed=1, crest=crest), GranularCompacton(n)
    size = max(family.sizes)
    grid = Grid(wave.period(equation), size)
    simulation = Simulation(
        equation, grid, [wave], t_end=2, frames=31, scheme=ConservativeScheme(order=4), integrator=integrator
    )
    truths = {"height 0": crest, "speed 0": 1.0, "position 0": 2.0, "profile": exact_norm(simulation, family)}
    return Known(simulation, family, {name: Truth(value) for name, value in truths.items()})


def kdv_soliton() -> Known:
    """The soliton of Korteweg-de Vries, whose tails are exponential."""
    truths = {"height 0": 0.5, "speed 0": 1.0, "position 0": 21.0}
    return _kdv("1 / cosh((x - 15) / 2)**2 / 2", 40, 320, 6, truths)


def kdv_two_solitons() -> Known:
    """Two solitons of Korteweg-de Vries: the fast one gains 2 log 3, the slow one loses 4 log 3, and nothing is left."""
    return _kdv_pair(t_end=60)


def kdv_too_early() -> Known:
    """The same two, seen soon after they have passed through each other: crests that are still drawn together."""
    return _kdv_pair(t_end=46)


def _kdv_pair(t_end: float) -> Known:
    """The exact wave of two solitons, c = 1 and 1/4, that come through each other at x = 45 and t = 28."""
    meeting, gain, loss = 28, 2 * np.log(3), -4 * np.log(3)
    above = "3 + 4 * cosh((x - 45) / 2 + 7 / 2) + cosh(x - 45 + 28)"
    below = "3 * cosh((x - 45) / 4 + 49 / 4) + cosh(3 * (x - 45) / 4 + 63 / 4)"
    start = f"3 / 4 * ({above}) / ({below})**2"
    return _kdv(start, 120, 480, t_end, {
        "height 0 after": 0.5, "speed 0 after": 1.0, "phase shift 0": gain,
        "position 0": 45 + t_end - meeting + gain / 2,
        "height 1 after": 0.125, "speed 1 after": 0.25, "phase shift 1": loss,
        "position 1": 45 + (t_end - meeting) / 4 + loss / 2,
    })  # fmt: skip


def _kdv(start: str, length: float, size: int, t_end: float, truths: dict[str, float]) -> Known:
    """u_t + 6 u u_x + u_xxx = 0 has the solitons c/2 sech^2(sqrt(c) (x - c t) / 2)."""
    simulation = Simulation(
        CustomEquation("3*u**2 + d2(u)"),
        Grid(length, size),
        [Formula(start)],
        t_end,
        scheme=CentralScheme(4),
        frames=101,
        integrator=Rosenbrock(rtol=1e-4),
    )
    family = Family(schemes=(CentralScheme(4), CompactScheme("five_point")))
    return Known(simulation, family, {name: Truth(value) for name, value in truths.items()})


def airy() -> Known:
    """Linear dispersion, u_t + u_xxx = 0: 1 + cos(3 x) / 2 moves with the speed -9."""
    simulation = Simulation(
        CustomEquation("d2(u)"),
        Grid(2 * np.pi, 96),
        [Formula("1 + cos(3*x) / 2")],
        t_end=0.25,
        scheme=CentralScheme(2),
        integrator=CVODE(rtol=1e-6),
    )
    family = Family(schemes=(CentralScheme(2), CompactScheme("five_point")))
    return Known(simulation, family, {"profile": Truth(np.sqrt(2 * np.pi * (1 + 1 / 8)))})


def advection() -> Known:
    """u_t + u_x = 0 carries a Gaussian along that the coarsest grid barely resolves."""
    simulation = Simulation(
        CustomEquation("u"),
        Grid(20, 160),
        [Formula("exp(-(x - 5)**2)")],
        t_end=8,
        scheme=CentralScheme(2),
        integrator=CVODE(rtol=1e-6),
    )
    family = Family(schemes=(CentralScheme(2), CompactScheme("five_point")))
    truths = {"height 0": 1.0, "speed 0": 1.0, "position 0": 13.0, "profile": (np.pi / 2) ** 0.25}
    return Known(simulation, family, {name: Truth(value) for name, value in truths.items()})


def nesterenko() -> Known:
    """The compacton of Nesterenko's equation, n = 3, on grids so coarse and for a time so short that growth is small."""
    return of_free_waves(one(Nesterenko(3), 24, 96, 0.3), Family(sizes=(24, 48, 96), accuracy=0.05))


def nesterenko_hertz() -> Known:
    """The same for n = 3/2, under a viscosity that holds the growth of short waves."""
    return of_free_waves(one(Nesterenko(1.5), 30, 120, 1), Family(sizes=(30, 60, 120), accuracy=0.05))


def midpoint() -> Known:
    """A compacton of n = 2 by the midpoint rule, whose ladder in time is one of steps."""
    simulation = one(GranularCompacton(2), 30, 240, 3, scheme=UNDAMPED[0], integrator=Midpoint(step=0.02))
    return of_free_waves(simulation, Family(schemes=UNDAMPED))


def two_apart() -> Known:
    """A bright and a dark compacton of one speed, which never meet; their masses cancel."""
    waves = [Compacton(1, 8), Compacton(1, 24, sign=-1)]
    simulation = Simulation(GranularCompacton(2), Grid(36, 320), waves, t_end=4, frames=31)
    return of_free_waves(simulation, Family(schemes=DAMPED))


FAMILIES: tuple[Callable[[], Known], ...] = (
    hertz, quadratic, rational, cubic, cusp, defaults, dark, slow, fast, k22, k22_absolute, k33, periodic_cubic,
    periodic_hertz, kdv_soliton, kdv_two_solitons, kdv_too_early, airy, advection, nesterenko, nesterenko_hertz,
    midpoint, two_apart,
)  # fmt: skip
