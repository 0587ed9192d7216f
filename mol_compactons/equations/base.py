"""What an equation is to the rest of the program, and the shape of the compactons of the known families."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import Settings
from mol_compactons.errors import InputError, require
from mol_compactons.stencils import difference, stencils_of

if TYPE_CHECKING:
    from mol_compactons.equations.flux import DispersiveFlux
    from mol_compactons.grid import Grid

Array = NDArray[np.float64]

SecondDifference = Callable[[Array], Array]
"""Maps the values of a function on the grid to an approximation of its second derivative there."""


CORE = 0.9
"""The part of the support of a compacton with which profiles are compared."""

LARGEST_MISMATCH = 1e-6
"""How far the height of a compacton may be from that whose speed it has, relative to it."""


class Derivative(Protocol):
    """The differences that a scheme takes for derivatives in space."""

    def __call__(self, values: Array, order: int) -> Array:
        """The derivative of an order, 1 to 3, of a function given by its values on the grid, shape (N,)."""


class Linearization(Protocol):
    """The derivatives of the flux F and the source s of an equation by its state, with the differences of a scheme in them."""

    @property
    def reach(self) -> int:
        """The farthest neighbour on which F or s depends."""

    def flux(self, t: float, x: Array, state: Array) -> Array:
        """The cyclic diagonals of dF/dy, shape (components, 2 R + 1, N).

        ``[c, R + d, j]`` is the derivative of F in cell j by component c in cell j + d; R may be less than `reach`.
        """

    def source(self, t: float, x: Array, state: Array) -> Array | None:
        """The same for the source, with a reach of its own; None for none."""


class SolitaryShape(Protocol):
    """The shape of a solitary wave, even about its centre: the shape of a compacton, or the exact wave of a chain."""

    @property
    def amplitude(self) -> float:
        """The height at the centre, negative for a dark wave."""

    @property
    def width(self) -> float:
        """The length of the support or, where there is none, the distance between the thousandths of the height."""

    @property
    def half_width(self) -> float:
        """The width at half the height."""

    @property
    def core(self) -> float:
        """The length around the centre on which profiles are compared with it: the width, less edges that are not smooth."""

    def __call__(self, z: Array) -> Array:
        """The profile at the distances z from the centre, same shape."""

    def slope(self, z: Array) -> Array:
        """Its derivative, same shape."""


class Equation(Settings):
    r"""A conservation law with a source, one-way or two-way, on a line.

    .. math::  u_t + F_x = s,   or in two-way form   u_t + v_x = 0,  v_t + F_x = s

    A subclass is a frozen dataclass whose fields are the parameters. It has to name its `variables` and to give its flux: as
    `local_flux`, in any form, or as `dispersive_flux`, in the form a(u) + b(u) g(u)_xx that the compact scheme takes. All
    else is refined where it is known: compactons, what is conserved, which states have a meaning, the names.
    """

    two_way: bool = False
    """Whether there is a second component v."""

    long_names: ClassVar[Mapping[str, str]] = {}
    """What the variables, the conserved quantities and the diagnostics are called in a result."""

    reference: ClassVar[str] = ""
    """The publication that the equation comes from."""

    background: float = 0.0
    """The value of u where nothing moves."""

    depends_on_time: bool = False
    """Whether the flux or the source depends on t as such."""

    @property
    @abstractmethod
    def variables(self) -> tuple[str, ...]:
        """The names of the components, ("u",) or ("u", "v")."""

    @property
    def dispersive_flux(self) -> DispersiveFlux | None:
        """The flux in the form a(u) + b(u) g(u)_xx, or None where it has another."""
        return None

    @property
    def has_local_flux(self) -> bool:
        """Whether `local_flux` gives a flux."""
        return self.dispersive_flux is not None or type(self).local_flux is not Equation.local_flux

    def local_flux(self, t: float, x: Array, state: Array, derivative: Derivative) -> Array:
        """F at the grid points.

        Parameters
        ----------
        t : float
            The time.
        x : array, shape (N,)
            The grid points.
        state : array, shape (components, N)
            The state.
        derivative : callable
            ``derivative(values, order)`` is the difference that the scheme takes for a derivative in space.

        Returns
        -------
        array, shape (N,)
        """
        flux = self.dispersive_flux
        if flux is None:
            raise InputError(f"{type(self).__name__} has no flux; give it a method local_flux, or a property dispersive_flux.")
        b, g, a = np.empty((3, x.size))
        flux.evaluate(state[0], b, g, a)
        return np.asarray(a + b * derivative(g, 2))

    def local_source(self, t: float, x: Array, state: Array, derivative: Derivative) -> Array | None:
        """The source s at the grid points, shape (N,); None for none. With a source nothing is taken for conserved."""
        return None

    @property
    def has_source(self) -> bool:
        """Whether `local_source` gives one."""
        return type(self).local_source is not Equation.local_source

    def linearized(self, stencils: Mapping[int, Array]) -> Linearization | None:
        """The exact derivatives of the flux and the source, for a Jacobian; None where they are not known.

        Parameters
        ----------
        stencils : mapping
            The differences in place of derivatives: for each order, 1 to 3, the coefficients, shape (2 r + 1,).
        """
        return None

    def compacton(self, speed: float, sign: int = 1) -> CosinePower:
        """The shape of the compacton of a speed and a sign.

        Raises
        ------
        InputError
            If there is none of closed form.
        """
        raise InputError(
            f"{type(self).__name__} has no compacton of closed form known to this program; give the initial data as a Formula "
            "or as Samples."
        )

    def compacton_speed(self, height: float) -> float | None:
        """The speed of the compacton of a height, which is positive; None where there is none of closed form."""
        return None

    def solitary_shape(self, height: float, sign: int = 1) -> SolitaryShape | None:
        """The shape of the solitary wave of a height, by which waves are recognised and measured.

        By default that of the compacton, where `compacton` and `compacton_speed` are known.

        Parameters
        ----------
        height : float
            The largest size of the wave, positive.
        sign : {1, -1}
            Bright or dark.

        Returns
        -------
        SolitaryShape or None
            None where there is none known.

        Raises
        ------
        InputError
            If the height is not positive, or the two methods contradict each other.
        """
        found = self._compacton_of(height, sign)
        return None if found is None else found[1]

    def solitary_speed(self, height: float, sign: int = 1) -> float | None:
        """The speed of that wave; of waves that go both ways its size; None where there is none known.

        Parameters and errors are those of `solitary_shape`.
        """
        found = self._compacton_of(height, sign)
        return None if found is None else found[0]

    def _compacton_of(self, height: float, sign: int) -> tuple[float, CosinePower] | None:
        """Speed and shape of the compacton of a height."""
        size = self.compacton_speed(self.checked_height(height))
        for speed in () if size is None else (size, -size):
            try:
                shape = self.compacton(speed, sign)
            except InputError:
                continue
            require(
                abs(shape.amplitude - sign * height) <= LARGEST_MISMATCH * height,
                f"{type(self).__name__}.compacton_speed({height:g}) is {size:g}, but the compacton of this speed has the "
                f"height {shape.amplitude:g}; let the two methods be inverse to each other.",
            )
            return speed, shape
        return None

    @staticmethod
    def checked_height(height: float) -> float:
        """The height, if it is one."""
        require(0 < height < math.inf, f"The height of a solitary wave is positive, not {height:g}; a dark one has sign=-1.")
        return height

    def fastest_growth(self, state: Array, spacing: float) -> float:
        """The largest rate at which the equation itself lets short waves on a grid grow; 0 where it is well-posed.

        Parameters
        ----------
        state : array, shape (components, N)
            The state that they run on.
        spacing : float
            The grid spacing h; the shortest wave number of the grid is pi / h.
        """
        return 0.0

    def travelling_state(self, shape: Any, z: Array, speed: float) -> Array:
        """The state of a wave of a shape and speed at the distances z from its centre, shape (components, N)."""
        profile = shape(z)
        return np.array([profile, speed * profile]) if self.two_way else np.asarray(profile)[None]

    def check_center(self, center: float, grid: Any) -> None:
        """Refuse a wave beyond the ends of the domain, where there are any."""

    def check_grid(self, grid: Grid) -> None:
        """Refuse a grid on which the flux or the source has no value."""

    def check_state(self, state: Array) -> None:
        """Refuse a state that the equation has no meaning for."""

    def densities(self, state: Array, second_difference: SecondDifference) -> dict[str, Array]:
        """The densities of the conserved quantities of a state of shape (components, N): by default u and, two-way, v.

        With a source only Int u of a two-way equation is conserved.

        A density that has parts, like the potential and the kinetic energy, is an array of these, shape (parts, N).
        """
        known = state[: int(self.two_way)] if self.has_source else state
        return dict(zip(("mass", "momentum"), known, strict=False))

    def invariants(self, state: Array, spacing: float, second_difference: SecondDifference) -> dict[str, float]:
        """The conserved quantities of a state, as sums of their densities over the grid."""
        densities = self.densities(state, second_difference)
        return {name: spacing * float(density.sum()) for name, density in densities.items()}

    def magnitudes(self, state: Array, spacing: float, second_difference: SecondDifference) -> dict[str, float]:
        """The sums of the sizes of what the conserved quantities are sums of, for when these cancel."""
        densities = self.densities(state, second_difference)
        return {name: spacing * float(np.abs(density).sum()) for name, density in densities.items()}

    def diagnostics(self, state: Array, spacing: float) -> dict[str, float]:
        """What else is worth a number along t, though it is not conserved: by default the integrals that a source changes."""
        name = "momentum" if self.two_way else "mass"
        return {name: spacing * float(state[-1].sum())} if self.has_source else {}


def check_terms(equation: Equation, grid: Grid) -> None:
    """Refuse an equation, perhaps of the user's own, whose flux or source is no array of one real number for each point."""
    x, derivative = grid.x, partial(difference, stencils_of(2, grid.spacing))
    state = np.full((len(equation.variables), x.size), equation.background)
    for name, term in (("local_flux", equation.local_flux), ("local_source", equation.local_source)):
        with np.errstate(all="ignore"):
            values: Any = term(0.0, x, state, derivative)
        if values is None and name == "local_source":
            continue
        require(
            isinstance(values, np.ndarray) and values.shape == x.shape and values.dtype.kind in "fiu",
            f"{type(equation).__name__}.{name} returned {type(values).__name__} of shape {np.shape(values)}; return an array "
            f"of real numbers of shape {x.shape}.",
        )


@dataclass(frozen=True)
class CosinePower:
    """The shape that the compactons of the known families share: M cos^gamma(K z) for |K z| < pi / 2, and zero elsewhere.

    Parameters
    ----------
    amplitude, wavenumber, exponent : float
        M, K and gamma, nondimensional.
    """

    amplitude: float
    wavenumber: float
    exponent: float

    @property
    def width(self) -> float:
        """The length of the support, pi / K, nondimensional."""
        return math.pi / self.wavenumber

    @property
    def core(self) -> float:
        """Nine tenths of the support, without the edge, where a grid cannot follow the kink of n = 3 and the cusps beyond."""
        return CORE * self.width

    @property
    def half_width(self) -> float:
        """The width at half the height, (2 / K) arccos 2^(-1 / gamma)."""
        return 2 / self.wavenumber * math.acos(0.5 ** (1 / self.exponent))

    def __call__(self, z: Array) -> Array:
        """The profile at the distances z from the centre, same shape."""
        phase = np.minimum(np.abs(self.wavenumber * np.asarray(z, dtype=float)), np.pi / 2)
        cosine = np.where(phase < np.pi / 2, np.cos(phase), 0.0)
        return np.asarray(self.amplitude * cosine**self.exponent)

    def slope(self, z: Array) -> Array:
        """The derivative of the profile at the distances z from the centre, same shape; zero at the edges and outside."""
        phase = self.wavenumber * np.asarray(z, dtype=float)
        inside = np.abs(phase) < np.pi / 2
        cosine, sine = np.cos(phase[inside]), np.sin(phase[inside])
        slope = np.zeros_like(phase)
        slope[inside] = -self.amplitude * self.exponent * self.wavenumber * cosine ** (self.exponent - 1) * sine
        return slope


LARGEST_EXPONENT = 1000.0
"""The largest exponent n of a law; waves are rectangles long before."""


def check_exponent(name: str, n: float) -> None:
    """Refuse an exponent for which powers leave the range of numbers.

    Raises
    ------
    InputError
        If it is above `LARGEST_EXPONENT`.
    """
    require(n <= LARGEST_EXPONENT, f"{name} = {n:g} must not be above {LARGEST_EXPONENT:g}; choose a smaller one.")


def compacton_height(power: float, n: float) -> float:
    """The height M of a compacton with M^(n-1) = power."""
    exponent = math.log(power) / (n - 1) if 0 < power < math.inf else math.inf
    require(
        abs(exponent) < 200,
        f"The compacton of this speed has the height exp({exponent:.4g}) for an exponent {n:g}, out of the range of numbers; "
        "choose a speed nearer to 1, or a larger exponent.",
    )
    return float(power ** (1 / (n - 1)))
