"""Linear systems on a ring, given by the cyclic diagonals of their Jacobian."""

from __future__ import annotations

import numpy as np

from mol_compactons.semidiscrete import SemiDiscretization
from tests.systems import Array


def system_with(jacobian: Array) -> SemiDiscretization:
    """y' = J y, with J given by its cyclic diagonals."""

    def write(t: float, state: Array, out: Array) -> None:
        out[:] = jacobian

    components, _, diagonals, size = jacobian.shape
    return SemiDiscretization(
        size=size,
        components=components,
        reach=(diagonals - 1) // 2,
        rhs=lambda t, state, out: None,
        jacobian=write,
        invariants=lambda state: {},
    )


def random_jacobian(seed: int, components: int, reach: int, size: int) -> Array:
    return np.random.default_rng(seed).normal(size=(components, components, 2 * reach + 1, size))
