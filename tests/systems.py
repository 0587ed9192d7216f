"""Small systems and helpers that several tests share."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.orders import fitted_rate
from benchmarks.orders import relative_error as relative_error
from mol_compactons import Compacton, CompactScheme, GranularCompacton, Grid, Simulation
from mol_compactons.integrators import CVODE, IDA, GaussLegendre, Midpoint, Rosenbrock
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.stencils import Stencil

Array = NDArray[np.float64]
SecondDifference = Literal["wide", "nearest", "five_point"]
fitted_order = fitted_rate


def random_state(seed: int, components: int, size: int) -> Array:
    """A random state of both signs."""
    return np.random.default_rng(seed).normal(size=(components, size))


def right_hand_side(system: SemiDiscretization, state: Array) -> Array:
    out = np.empty_like(state)
    system.rhs(0.0, state, out)
    return out


def difference_jacobian(system: SemiDiscretization, state: Array, step: float = 1e-6) -> Array:
    """df/dy in folded order by central differences, dense."""
    columns = []
    for index in range(system.unknowns):
        unit = np.zeros(system.unknowns)
        unit[index] = step
        ahead = right_hand_side(system, system.unfold(system.fold(state) + unit))
        behind = right_hand_side(system, system.unfold(system.fold(state) - unit))
        columns.append(system.fold(ahead - behind) / (2 * step))
    return np.array(columns).T


def analytic_jacobian(system: SemiDiscretization, state: Array) -> Array:
    """df/dy in folded order from the analytic diagonals, dense."""
    diagonals = np.empty_like(system.mass_diagonals)
    system.jacobian(0.0, state, diagonals)
    matrix = system.sparsity.copy()
    matrix.data = system.csc_values(diagonals)
    return np.asarray(matrix.toarray())


def dense_stencil(stencil: Stencil, size: int, spacing: float) -> Array:
    """A stencil on a periodic grid as a dense matrix."""
    matrix = np.zeros((size, size))
    for offset, coefficient in zip(range(-2, 3), stencil.scaled(spacing), strict=True):
        matrix += coefficient * np.roll(np.eye(size), offset, axis=1)
    return matrix


def one_compacton(
    *,
    n: float = 3,
    length: float = 30,
    size: int = 150,
    t_end: float = 1,
    frames: int = 3,
    second_difference: SecondDifference = "wide",
    viscosity: float = 1e-3,
    integrator: IDA | CVODE | GaussLegendre | Midpoint | Rosenbrock | None = None,
    sign: int = 1,
) -> Simulation:
    """One compacton of speed 1."""
    return Simulation(
        equation=GranularCompacton(n=n),
        grid=Grid(length=length, size=size),
        scheme=CompactScheme(second_difference=second_difference, viscosity=viscosity),
        initial=[Compacton(speed=1, center=length / 3, sign=sign)],
        t_end=t_end,
        frames=frames,
        integrator=integrator or IDA(),
    )
