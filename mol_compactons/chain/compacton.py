"""The compactons of the continuum as initial data of a chain, which has none of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from mol_compactons.chain.chain import LARGEST_EXCESS, GranularChain
from mol_compactons.equations.base import CosinePower, Equation
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.waves.base import Array
from mol_compactons.waves.compacton import Compacton


@dataclass(frozen=True)
class ChainCompacton(Compacton):
    r"""The compacton of Nesterenko's equation as initial data of a chain, with the rate of the stress of the paper or another.

    The stress is R_k = M cos^gamma(K z), z = k - center, where \|K z\| < pi / 2. Its rate is one of two:

    - "derivative", the paper's: that of a shape that moves as it stands,
      R_t = -V dR/dk = V M K gamma cos^(gamma-1)(K z) sin(K z).
    - "site_difference": each grain has the velocity of the continuum at its place, V R(k + 1/2), and R_t is the difference
      between neighbours, V [R(k - 1/2) - R(k + 1/2)]. `Compacton` takes the same.

    A wave that is wide for a grain hardly sees the difference. For n = 3, where it is 2.2 sites wide and has kinks at its
    edges, the rates differ by up to nine tenths of their size. A derivative does not add up to zero over the sites, which is
    what the rates on a ring have to do: from about n = 2 on it needs ends.

    Parameters
    ----------
    speed : float
        The speed V, sites for each unit of time; positive to the right.
    center : float
        Where its centre is at t = 0, a coordinate on the lattice.
    sign : {1, -1}
        Compression or rarefaction.
    rate : {"derivative", "site_difference"}
        Which rate the stress has.

    Raises
    ------
    InputError
        If the equation is no chain or has no compacton of this speed, if the derivative has no bound, for n > 3, or if it
        does not fit on a ring.

    Notes
    -----
    All quantities are nondimensional. Source: Vladimirov and Skurativskyi (2015), the initial conditions of the discrete
    system; the printed R_t has the wrong sign and lacks the factor K, docs/theory.md, misprint 9.

    Examples
    --------
    >>> from mol_compactons import PowerContact
    >>> chain, wave = GranularChain(PowerContact(n=3), ends="held"), ChainCompacton(speed=1, center=2.5)
    >>> wave.values(chain, Lattice(size=6))[1, 2:4].round(3)  # V M K = 2 at the kinks
    array([-1.299,  1.299])
    """

    rate: Literal["derivative", "site_difference"] = "derivative"

    def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> Array:
        """The wave at time t, shape (2, size)."""
        if not isinstance(equation, GranularChain):
            raise InputError(f"ChainCompacton is a wave of GranularChain, not of {type(equation).__name__}; choose Compacton.")
        if self.rate == "site_difference":
            return super().values(equation, grid, t)
        shape = equation.compacton(self.speed, self.sign)
        self._check_bound(shape)
        z = grid.offset(self.center + self.speed * t)
        state = equation.travelling_state(shape, z, self.speed, rate=lambda places: -self.speed * shape.slope(places))
        total, size = float(state[1].sum()), float(np.abs(state[1]).sum())
        require(
            equation.ends != "periodic" or abs(total) <= LARGEST_EXCESS * size,
            f"The rates of a ChainCompacton with rate = 'derivative' add up to {total:.4g}, but on a ring they must add up to "
            "0; choose ends='held' or 'free', or rate='site_difference'.",
        )
        return state

    def _check_bound(self, shape: CosinePower) -> None:
        require(
            shape.exponent >= 1,
            f"The derivative of a compacton cos^{shape.exponent:.3g} has no bound at its edges; choose "
            "rate='site_difference', or an exponent n of at most 3.",
        )
