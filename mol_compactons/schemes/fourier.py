"""The Fourier pseudo-spectral scheme, in a form that keeps the momentum whatever the aliasing does."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft

from mol_compactons.equations.base import Equation
from mol_compactons.equations.flux import PowerLaw
from mol_compactons.equations.granular import GranularCompacton
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.schemes.base import Scheme
from mol_compactons.schemes.conservative import ConservativeScheme
from mol_compactons.schemes.viscosity import ViscousScheme, coefficient, damping_order
from mol_compactons.semidiscrete import SemiDiscretization

Array = NDArray[np.float64]
Spectrum = NDArray[np.complex128]

BEST_CHECK = 10.0
"""By what its merit as a check rises where the viscosity is tied to the grid."""


@dataclass(frozen=True)
class FourierScheme(ViscousScheme):
    r"""Pseudo-spectral differences for the granular compacton equation, skew-symmetric as they stand.

    With D the Fourier derivative and a = |W|^(n-1),

        W' = -n/(n+1) [D (a W) + a D W] - (n+1)/4 D [D (a D W) + a D D W] - viscosity

    Both brackets are skew-symmetric, so that the momentum is conserved to round-off with or without de-aliasing; the mass is
    conserved up to aliasing. On smooth waves the error falls exponentially, at the edge of a compacton algebraically. The
    Jacobian is dense: CVODE with linear_solver="krylov" takes its product with a vector, and the banded LU of the
    conservative scheme of sixth order as a preconditioner.

    Parameters
    ----------
    dealias : bool
        Whether the upper third of the wavenumbers is removed from W and from W'.
    viscosity : float
        The coefficient eps >= 0 of the damping -eps (-1)^(p/2) D^p W, nondimensional.
    grid_viscosity : float
        The same in grid units: nu >= 0 adds nu h^(p-1) to the viscosity, so that it vanishes with the grid.
    viscosity_order : int
        The even order p >= 2.

    Raises
    ------
    InputError
        If a value is out of range, or the equation is another one.

    Notes
    -----
    The split of the convective part is the classical one of skew-symmetric schemes (Tadmor, SIAM J. Numer. Anal. 21 (1984)
    742, doi:10.1137/0721049); that of the dispersive part is our own.
    """

    dealias: bool = True
    viscosity: float = 0.0
    grid_viscosity: float = 0.0
    viscosity_order: int = 4

    def __post_init__(self) -> None:
        super().__post_init__()
        require(
            2 <= self.viscosity_order <= 16 and self.viscosity_order % 2 == 0,
            f"scheme.viscosity_order = {self.viscosity_order} must be an even number from 2 to 16.",
        )

    @classmethod
    def default_for(cls, equation: Equation, grid: Grid | Lattice, speed: float) -> FourierScheme | None:
        """None: its dense Jacobian is not for the default integrator."""
        return None

    @classmethod
    def as_check_of(cls, scheme: Scheme, equation: Equation, grid: Grid | Lattice) -> tuple[float, Scheme]:
        """The best check where the viscosity vanishes with the grid, which the compact scheme does not stand."""
        own = cls(dealias=False, viscosity_order=damping_order(scheme))
        return (BEST_CHECK if scheme.viscosities[1] else 1.0) * own.suits(equation), own

    @property
    def formal_order(self) -> float:
        """On smooth waves the error falls exponentially, for which a study takes 6."""
        return 6.0

    def suits(self, equation: Equation) -> float:
        """The granular compacton equation; slow, and best on smooth waves."""
        return 0.3 if isinstance(equation, GranularCompacton) and not equation.has_source else 0.0

    def discretize(self, equation: Equation, grid: Grid | Lattice) -> SemiDiscretization:
        """The semi-discretisation of the granular compacton equation on a grid."""
        if not isinstance(equation, GranularCompacton) or equation.has_source or isinstance(grid, Lattice):
            raise InputError(
                f"FourierScheme is for GranularCompacton without a source on a Grid, not for {type(equation).__name__} on a "
                f"{type(grid).__name__}; choose CompactScheme, or NearestNeighbours for a chain."
            )
        kernel = _FourierKernel(equation.n, grid, self)
        companion = ConservativeScheme(
            order=6,
            viscosity=coefficient(self, grid.spacing) if self.viscosity_order == 4 else 0,
        ).discretize(equation, grid)
        return SemiDiscretization(
            size=grid.size,
            components=1,
            reach=companion.reach,
            rhs=kernel.rhs,
            jacobian=companion.jacobian,
            invariants=lambda state: equation.invariants(state, grid.spacing, kernel.second_difference),
            magnitudes=lambda state: equation.magnitudes(state, grid.spacing, kernel.second_difference),
            damping=float(kernel.decay[-1]),
            jacobian_vector=kernel.jacobian_vector,
            companion=companion,
        )


class _Linearization(threading.local):
    """What products with the Jacobian at one state have in common, the latest state of each thread."""

    state: Array | None = None
    factors: tuple[Array, ...] = ()


class _FourierKernel:
    """The right-hand side and its linearisation."""

    def __init__(self, n: float, grid: Grid, scheme: FourierScheme) -> None:
        wavenumbers = grid.wavenumbers
        self._n, self._size = n, grid.size
        self._law = PowerLaw(1, n - 1)
        self._kept = np.ones(wavenumbers.size)
        if scheme.dealias:
            self._kept[np.arange(wavenumbers.size) > grid.size // 3] = 0
        self._first = 1j * wavenumbers
        if grid.size % 2 == 0:
            self._first[-1] = 0
        self._latest = _Linearization()
        self.decay = coefficient(scheme, grid.spacing) * wavenumbers**scheme.viscosity_order

    def _values(self, spectrum: Spectrum) -> Array:
        return np.asarray(irfft(spectrum, n=self._size))

    def _slopes(self, u: Array) -> tuple[Spectrum, Array, Array, Array]:
        """The kept spectrum of u; u, D u and D D u from it."""
        spectrum = self._kept * rfft(u)
        slope = self._first * spectrum
        return spectrum, self._values(spectrum), self._values(slope), self._values(self._first * slope)

    def _rate(self, spectrum: Spectrum, product: Array, slope_product: Array, second_product: Array) -> Array:
        """W' from the spectrum of W and from a W, a D W and a D D W."""
        n, slope_spectrum = self._n, rfft(slope_product)
        convective = n / (n + 1) * (self._first * rfft(product) + slope_spectrum)
        dispersive = (n + 1) / 4 * self._first * (self._first * slope_spectrum + rfft(second_product))
        return self._values(-self._kept * (convective + dispersive) - self.decay * spectrum)

    def rhs(self, t: float, state: Array, out: Array) -> None:
        """Write W'."""
        spectrum, w, slope, second = self._slopes(state[0])
        a = self._law(w)
        out[0] = self._rate(spectrum, a * w, a * slope, a * second)

    def jacobian_vector(self, t: float, state: Array, vector: Array, out: Array) -> None:
        """Write the derivative of `rhs` along a vector."""
        # A Krylov solver asks for many products at one state.
        latest = self._latest
        if latest.state is None or not np.array_equal(state[0], latest.state):
            _, w, slope, second = self._slopes(state[0])
            latest.state = state[0].copy()
            latest.factors = self._law(w), self._law.derivative()(w), slope, second
        a, law_slope, slope, second = latest.factors
        spectrum, v, v_slope, v_second = self._slopes(vector[0])
        change = law_slope * v
        out[0] = self._rate(spectrum, self._n * a * v, change * slope + a * v_slope, change * second + a * v_second)

    def second_difference(self, values: Array) -> Array:
        """The second derivative with which the energy is reported."""
        return self._values(self._first**2 * rfft(values))
