"""One simulation: what is solved, where, how, from what and how long."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import MISSING, dataclass, field, fields, replace
from fractions import Fraction
from functools import partial
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import Settings, decode, encode
from mol_compactons.equations.base import Equation, check_terms
from mol_compactons.errors import InputError, require, within_numbers
from mol_compactons.grid import Grid, Lattice
from mol_compactons.integrators.base import Integrator
from mol_compactons.integrators.sundials import IDA
from mol_compactons.notebook import html_of_settings
from mol_compactons.schemes.base import Scheme, best_scheme
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.stencils import difference, stencils_of
from mol_compactons.waves.base import LocalizedWave, Wave, superpose
from mol_compactons.waves.shapes import Uniform

VISCOSITY_NAMES = ("viscosity", "grid viscosity")

TAKEN = {"x", "k", "t", "restart", "mass", "momentum", "energy"}
"""What else a result holds, so that no variable may be called so."""

LONGEST_FIELD = 40
"""How much of a field a headline shows."""

SMALLEST_FOR_SPEED = 8
"""The fewest points that the differences of `speed_of` need."""

MOST_FRAMES = 10**7
"""The largest number of output times."""

LARGEST_EXACT = 2**53
"""Whole numbers below are floats as they are."""


@dataclass(frozen=True)
class Simulation(Settings):
    """An equation on a grid, discretised by a scheme, from exact waves at t = 0 to t_end.

    Parameters
    ----------
    equation, grid
        A continuous equation on a Grid, or a chain on its Lattice.
    scheme : Scheme, optional
        The discretisation; which goes with which equation is for ``scheme.discretize`` to say. None, the default, takes the
        one that suits the equation best, with settings for the speeds of the initial data, see `best_scheme` and
        docs/schemes.md. It is stored as if it had been given.
    initial : list of waves
        Their sum is the state at t = 0. The supports of compactons must not overlap.
    t_end : float
        The last time, nondimensional.
    frames : int
        Number of output times, equally spaced from 0 to t_end, both included.
    output_times : list of float, optional
        Output times of one's own, growing from 0 to t_end, in place of equally spaced ones; `frames` is their number then.
    series_per_frame : int
        How often conserved quantities and diagnostics are recorded from one output time to the next. Above 1 the result has
        them also on the coordinate ``t_series``, as ``mass_series``. Methods of fixed steps end a step at each of these times.
    integrator
        The time integrator.
    title : str
        One line that says what this is.

    Raises
    ------
    InputError
        If a value is out of range, or the parts do not fit together.

    Examples
    --------
    >>> from mol_compactons import Compacton, GranularCompacton
    >>> simulation = Simulation(
    ...     equation=GranularCompacton(n=3),
    ...     grid=Grid(length=30, size=120),
    ...     initial=[Compacton(speed=1, center=5.5)],
    ...     t_end=1,
    ...     frames=3,
    ... )
    >>> simulation.scheme
    ConservativeScheme(order=4, viscosity=0.0, grid_viscosity=0.03, viscosity_order=6)
    """

    equation: Equation
    grid: Grid | Lattice
    initial: Sequence[Wave]
    t_end: float
    scheme: Scheme = None  # type: ignore[assignment]  # chosen in __post_init__
    frames: int = 101
    integrator: Integrator = field(default_factory=IDA)
    title: str = ""
    output_times: Sequence[float] | None = None
    series_per_frame: int = 1

    def __post_init__(self) -> None:
        with within_numbers("This simulation"):
            self._complete_and_check()

    def _complete_and_check(self) -> None:
        if isinstance(self.equation, Equation) and isinstance(self.grid, Grid):
            self._check_variables()
            if self.equation.has_local_flux and self.grid.size >= SMALLEST_FOR_SPEED:
                check_terms(self.equation, self.grid)
        if self.scheme is None and isinstance(self.equation, Equation):
            object.__setattr__(self, "scheme", self._best_scheme())
        super().__post_init__()
        require(
            self.title.encode("utf-8", "replace") == self.title.encode("utf-8", "surrogatepass"),
            f"title = {self.title!a} holds what no text can hold; choose letters and signs.",
        )
        require(1e-9 <= self.t_end <= 1e12, f"t_end = {self.t_end:g} must lie between 1e-9 and 1e12.")
        self._check_output_times()
        require(
            2 <= self.frames <= MOST_FRAMES,
            f"frames = {self.frames:.16g} must lie between 2, the first and the last time, and {MOST_FRAMES}.",
        )
        require(
            self.series_per_frame >= 1 and self.frames * self.series_per_frame <= MOST_FRAMES,
            f"series_per_frame = {self.series_per_frame:.16g} must be at least 1, and at most {MOST_FRAMES} / frames.",
        )
        system, state = self.discretize(), self.initial_state()
        self.integrator.check_system(system)
        self._check_state(system, state)

    def _check_state(self, system: SemiDiscretization, state: NDArray[np.float64]) -> None:
        """Refuse data of which nothing can be computed, or nothing is left on the points."""
        require(
            bool(state.any()) or all(isinstance(wave, Uniform) for wave in self.initial),
            f"The initial state is zero at all {self.grid.size} points, although initial has waves; choose a larger "
            "grid.size, or waves that do not vanish there.",
        )
        for name, value in system.invariants(state).items():
            require(
                np.ndim(value) > 0 or bool(np.isfinite(value)),
                f"The {name} of the initial state, of size {float(np.abs(state).max()):g}, is not finite; choose "
                "smaller waves.",
            )

    def _check_output_times(self) -> None:
        """Those of one's own count as frames."""
        if self.output_times is None:
            return
        times = np.asarray(self.output_times, dtype=float)
        growing = times.size > 1 and bool((np.diff(times) > 0).all())
        require(
            growing and times[0] == 0 and times[-1] == self.t_end,
            f"output_times must grow from 0 to t_end = {self.t_end:g}, both included; these are {times.size} values, "
            f"{', '.join(f'{t:g}' for t in times[:3])}{', ...' if times.size > 3 else ''}.",
        )
        object.__setattr__(self, "frames", times.size)

    def _check_variables(self) -> None:
        """An equation of the user's own may call its variables anything."""
        names, kind = self.equation.variables, type(self.equation).__name__
        allowed = isinstance(names, tuple) and all(
            isinstance(name, str) and name.isidentifier() and not name.endswith("_series") for name in names
        )
        require(
            allowed and len(set(names)) == len(names) and not set(names) & TAKEN,
            f"{kind}.variables = {names!r} must be a tuple of different names, none of them {', '.join(sorted(TAKEN))}, "
            "and none with _series at its end.",
        )
        count = 2 if self.equation.two_way else 1
        require(
            len(names) == count or not self.equation.has_local_flux,
            f"{kind}.variables = {names!r} must be {count} for an equation with two_way = {self.equation.two_way}.",
        )

    def _best_scheme(self) -> Scheme:
        waves = self.initial if isinstance(self.initial, Sequence) else [None]
        if not isinstance(self.grid, Grid | Lattice) or not all(isinstance(wave, Wave) for wave in waves):
            # What is wrong with these is for the check of all fields to say.
            return cast(Scheme, None)
        return best_scheme(self.equation, self.grid, self._speed_scale())

    def _speed_scale(self) -> float:
        """The largest speed of the initial data: that of its waves or, for other data, of a compacton as high."""
        if self.initial and all(isinstance(wave, LocalizedWave) for wave in self.initial):
            return max(abs(wave.speed) for wave in self.initial if isinstance(wave, LocalizedWave))
        state = self.initial_state()
        of_height = self.equation.compacton_speed(float(np.abs(state[0]).max()))
        return of_height or speed_of(self.equation, self.grid, state)

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        return html_of_settings(self, self.headline)

    def discretize(self) -> SemiDiscretization:
        """The system of ordinary differential equations."""
        return self.scheme.discretize(self.equation, self.grid)

    def initial_state(self) -> NDArray[np.float64]:
        """The state at t = 0, shape (components, size)."""
        return superpose(self.initial, self.equation, self.grid)

    def exact_state(self, t: float) -> NDArray[np.float64] | None:
        """The solution of the equation at a time, shape (components, size), where the initial data are one exact wave.

        That of the equation without any viscosity; None for other data.
        """
        wave = self.initial[0]
        return wave.values(self.equation, self.grid, t) if len(self.initial) == 1 and wave.is_solution(self.equation) else None

    @property
    def times(self) -> NDArray[np.float64]:
        """The output times, shape (frames,): multiples of t_end / (frames - 1), each the float next to the exact quotient.

        A simulation that goes on farther with frames as dense has the same times as far as this one goes, to the last bit.
        """
        if self.output_times is not None:
            return np.array(self.output_times, dtype=float)
        return multiples(Fraction(repr(float(self.t_end))) / (self.frames - 1), self.frames)

    def extended(self, t_end: float) -> Simulation:
        """The same simulation to another end, with frames as dense.

        Raises
        ------
        InputError
            If the new end is no output time of it.
        """
        require(
            self.output_times is None or t_end == self.t_end,
            f"t_end = {t_end:g} is beyond the output_times that the simulation has; give longer ones that begin with these.",
        )
        if self.output_times is not None:
            return self
        spacing = Fraction(repr(float(self.t_end))) / (self.frames - 1)
        count = round(Fraction(repr(float(t_end))) / spacing)
        longer = replace(self, t_end=t_end, frames=max(count + 1, 2))
        shared = min(self.frames, longer.frames)
        require(
            np.array_equal(longer.times[:shared], self.times[:shared]),
            f"t_end = {t_end:.12g} is no multiple of the distance of the frames, {float(spacing):.12g}; choose one, as "
            f"{float(spacing * max(count, 1)):.12g} or {float(spacing * (max(count, 1) + 1)):.12g}.",
        )
        return longer

    @property
    def headline(self) -> str:
        """One line for titles and pictures: the title and, made from the settings, what distinguishes the run."""
        amounts = [
            f"{kind} {amount:g}" for kind, amount in zip(VISCOSITY_NAMES, self.scheme.viscosities, strict=True) if amount
        ]
        speeds = [f"{wave.speed:g}" for wave in self.initial if isinstance(wave, LocalizedWave)]
        waves = (
            f"c = {', '.join(speeds)}" if speeds else ", ".join(dict.fromkeys(type(wave).__name__ for wave in self.initial))
        )
        discrete = ", ".join([f"{self.scheme.label}, N = {self.grid.size}", *amounts])
        settings = f"{brief(self.equation)}; {waves}; {discrete}"
        return f"{self.title}: {settings}" if self.title else settings

    def to_json(self) -> str:
        """The simulation as JSON, from which `from_json` makes it again, bit for bit."""
        return json.dumps(encode(self))

    @classmethod
    def from_json(cls, text: str) -> Simulation:
        """The inverse of `to_json`.

        Raises
        ------
        InputError
            If the text is not the JSON of a valid simulation.
        """
        try:
            data = json.loads(text)
            simulation = decode(cls, data)
        except InputError:
            raise
        except RecursionError:
            raise InputError(
                "The JSON is nested too deep for a Simulation; give what Simulation.to_json() returned."
            ) from None
        except ValueError as error:
            told = error if isinstance(error, json.JSONDecodeError) else "a number in it has too many digits"
            raise InputError(f"The text is not JSON ({told}); give what Simulation.to_json() returned.") from None
        require(isinstance(simulation, cls), "The JSON does not describe a Simulation.")
        return cast(Simulation, simulation)


def divided(first: float, last: float, parts: int) -> NDArray[np.float64]:
    """The ends of equal parts of an interval, shape (parts,); the last end is `last`."""
    return np.append(first + (last - first) * np.arange(1, parts) / parts, last)


def multiples(spacing: Fraction, count: int) -> NDArray[np.float64]:
    """The first multiples of a rational number from 0 on, each the float next to the exact one."""
    above, below = spacing.numerator, spacing.denominator
    if above * count < LARGEST_EXACT and below < LARGEST_EXACT:
        return np.asarray(np.arange(count, dtype=np.float64) * above / below)
    return np.array([index * above / below for index in range(count)])


def brief(settings: Any) -> str:
    """A part of a simulation in a few characters: its class, and the fields that differ from their defaults."""
    shown = []
    for one in fields(settings):
        value = getattr(settings, one.name)
        default = one.default_factory() if one.default_factory is not MISSING else one.default
        if default is MISSING or value != default:
            text = f"{value:g}" if isinstance(value, float) else brief(value) if isinstance(value, Settings) else str(value)
            shown.append(f"{one.name}={text if len(text) < LONGEST_FIELD else text[:LONGEST_FIELD] + '...'}")
    return f"{type(settings).__name__}({', '.join(shown)})"


def speed_of(equation: Equation, grid: Grid | Lattice, state: NDArray[np.float64]) -> float:
    """The speed at which a state moves, ||u_t|| / ||u_x|| in L2: that of a travelling wave, and 1 where there is none.

    Parameters
    ----------
    equation, grid
        What is solved, and where.
    state : array, shape (components, N)
        The initial data.
    """
    if isinstance(grid, Lattice) or equation.two_way or not equation.has_local_flux or grid.size < SMALLEST_FOR_SPEED:
        return 1.0
    derivative = partial(difference, stencils_of(2, grid.spacing))
    rate = derivative(equation.local_flux(0.0, grid.coordinates, state, derivative), 1)
    slope = derivative(state[0], 1)
    moved, steepness = float(np.linalg.norm(rate)), float(np.linalg.norm(slope))
    if not (np.isfinite(moved) and moved > 0 and steepness > 0):
        return 1.0
    return moved / steepness
