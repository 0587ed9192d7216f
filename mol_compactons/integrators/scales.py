"""How large the components of a state are, and on how much of the grid: what tolerances are relative to.

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

SHORTEST_TIME = 2.0**-200
"""Where the search for the time in which a state changes begins, relative to the length of the run."""


def component_scales(system: SemiDiscretization, state: Array, t_end: float) -> Array:
    """The largest size of each component, shape (components,).

    A component that is zero at first, like the momenta of a chain at rest, is given the size that its rate brings in the time
    in which the state changes: the shortest for which an Euler step changes a rate by what turns the state over.

    Parameters
    ----------
    system : SemiDiscretization
        The system.
    state : array, shape (components, N)
        The state at t = 0.
    t_end : float
        The length of the run.
    """
    sizes = np.abs(state).max(axis=1)
    if (sizes > 0).all() or not (sizes > 0).any():
        return np.asarray(np.where(sizes > 0, sizes, 1.0))
    rate = system.rate(0.0, state)
    time = SHORTEST_TIME * t_end
    with np.errstate(over="ignore", invalid="ignore"):
        while time < t_end:
            change = np.abs(system.rate(0.0, state + time * rate) - rate).max(axis=1)
            if ((change * time >= sizes) & (sizes > 0)).any():
                break
            time *= 2
    moved = time * np.abs(rate).max(axis=1)
    return np.asarray(np.where(sizes > 0, sizes, np.where(moved > 0, moved, sizes.max())))


def absolute_tolerances(system: SemiDiscretization, state: Array, t_end: float, rtol: float) -> Array:
    """The default absolute tolerance of each component, shape (components,)."""
    return ABSOLUTE_SHARE * rtol * component_scales(system, state, t_end)


def occupied_share(state: Array) -> float:
    """The part of the grid that a state occupies, in (0, 1]: of each component (Sum y^2 / N) / max y^2, the largest."""
    largest = np.abs(state).max(axis=1)
    known = largest > 0
    if not known.any():
        return 1.0
    parts = state[known] / largest[known, None]
    return float(np.max(np.mean(parts * parts, axis=1)))
