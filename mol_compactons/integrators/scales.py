"""What a tolerance is relative to, and which tolerance of the local error makes the error of a run follow the one asked for.

An equation that is invariant under W -> r W has no absolute tolerance: it must be relative to the size of the state. And a
norm that is an average over the grid must not count an empty background, or one and the same tolerance would be looser in a
longer box.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]

ABSOLUTE_SHARE = 0.01
"""The default absolute tolerance of a component, relative to rtol times its largest value."""

LOOSE = 1e-3
"""The tolerance at which the local error may be as large as the error of the run; below, it must fall faster."""

RIPPLE_LIFETIME = 0.25
"""The lifetime of a ripple, in the time in which a state changes, at which it counts half."""

ORDERS_BY_DAMPING = ((0.3, 5), (0.0, 2))
"""The largest BDF order by the least ratio of the damping of f at the grid scale to the largest row sum of |df/dy|, both at
the initial state. Orders 3 to 5 are unstable for a nearly imaginary spectrum: order 5 needs five times the steps of order 2
at a ratio of 0.15 (`universal_pair`) and order 3 twice at 0.04 (`rosenau_hyman_collision`), while order 2 is never far
behind."""

SHORTEST_TIME, LONGEST_TIME = 2.0**-300, 2.0**300
"""Between what the time in which a state changes is looked for."""

BISECTIONS = 8
"""How often a factor of two is halved in that search."""


def time_scale(state: Array, rate: Array) -> float:
    """The time in which a state changes: its size over that of its rate, the least of all components.

    Parameters
    ----------
    state, rate : array, shape (components, N)
        The state at t = 0, and its time derivative.
    """
    sizes, rates = np.abs(state).max(axis=1), np.abs(rate).max(axis=1)
    moving = (sizes > 0) & (rates > 0)
    return float((sizes[moving] / rates[moving]).min()) if moving.any() else np.inf


def component_scales(system: SemiDiscretization, state: Array) -> Array:
    """The largest size of each component, shape (components,).

    A component that is zero at first, like the momenta of a chain at rest, is given the size that its rate brings in the time
    in which the state changes: the shortest for which an Euler step changes a rate by what turns the state over.

    Parameters
    ----------
    system : SemiDiscretization
        The system.
    state : array, shape (components, N)
        The state at t = 0.
    """
    sizes = np.abs(state).max(axis=1)
    if (sizes > 0).all() or not (sizes > 0).any():
        return np.asarray(np.where(sizes > 0, sizes, 1.0))
    rate = system.rate(0.0, state)
    moved = _turning_time(system, state, rate, sizes) * np.abs(rate).max(axis=1)
    return np.asarray(np.where(sizes > 0, sizes, np.where(moved > 0, moved, sizes.max())))


def _turning_time(system: SemiDiscretization, state: Array, rate: Array, sizes: Array) -> float:
    """The shortest time for which an Euler step changes a rate by what turns the state over; 0 without one."""

    def turns(time: float) -> bool:
        change = np.abs(system.rate(0.0, state + time * rate) - rate).max(axis=1)
        return bool(((change * time >= sizes) & (sizes > 0)).any())

    time = SHORTEST_TIME
    with np.errstate(over="ignore", invalid="ignore"):
        while not turns(time):
            time *= 2
            if time > LONGEST_TIME:
                return 0.0
        for halving in range(1, BISECTIONS + 1):
            shorter = time / 2 ** (0.5**halving)
            time = shorter if turns(shorter) else time
    return time


def absolute_tolerances(system: SemiDiscretization, state: Array, rtol: float) -> Array:
    """The default absolute tolerance of each component, shape (components,)."""
    return ABSOLUTE_SHARE * rtol * component_scales(system, state)


def occupied_share(state: Array) -> float:
    """The part of the grid that a state occupies, in (0, 1]: of each component (Sum y^2 / N) / max y^2, the largest."""
    largest = np.abs(state).max(axis=1)
    known = largest > 0
    if not known.any():
        return 1.0
    parts = state[known] / largest[known, None]
    return float(np.max(np.mean(parts * parts, axis=1)))


def damping_ratio(system: SemiDiscretization, state: Array) -> float:
    """How fast f damps a ripple of the grid, relative to the largest row sum of |df/dy| at a state; 0 without damping."""
    if not system.damping:
        return 0.0
    diagonals = np.empty_like(system.mass_diagonals)
    system.jacobian(0.0, state, diagonals)
    fastest = float(np.abs(diagonals).sum(axis=(1, 2)).max())
    return system.damping / fastest if fastest > 0 else np.inf


def order_for_damping(ratio: float) -> int:
    """The largest BDF order for a system of a `damping_ratio`."""
    return next(order for least, order in ORDERS_BY_DAMPING if ratio >= least)


def ripple_persistence(system: SemiDiscretization, state: Array, rate: Array) -> float:
    """How long ripples of the grid last in the time in which a state changes, from 0, where they die at once, to 1.

    An edge that crosses the cells sheds ripples with each. A step that does not resolve their periods loses them; each
    loss is small enough to pass the control of the local error, but what lasts adds up. An oscillator, whose fastest
    periods are those of its own waves, has none.

    Parameters
    ----------
    system : SemiDiscretization
        The system.
    state, rate : array, shape (components, N)
        The state at t = 0, and its time derivative.
    """
    if system.split_steps is not None:
        return 0.0
    if not system.damping:
        return 1.0
    return 1 / (1 + RIPPLE_LIFETIME * system.damping * time_scale(state, rate))


def steepened(rtol: float, power: float) -> float:
    """A tolerance times (rtol / LOOSE)^power, where it is below LOOSE."""
    return float(rtol * min(1.0, rtol / LOOSE) ** power)
