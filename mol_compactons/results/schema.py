"""What a result looks like: its names, roles, units, long names and attributes, after the CF conventions 1.11."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons.errors import require
from mol_compactons.integrators.base import Counters
from mol_compactons.runtime.capture import import_sundae
from mol_compactons.waves.base import LocalizedWave

if TYPE_CHECKING:
    from mol_compactons.simulation import Simulation

FORMAT = 2
"""The number of the layout of results, their attribute ``format``. Those of 1 have no such attribute, roles or outlines."""

FIELD, CONSERVED, DIAGNOSTIC = "field", "conserved", "diagnostic"
"""The roles of variables, their attribute ``role``: components of the state, what is conserved, and what is not."""

SERIES = "series"
"""What is recorded more often than the fields: the end of the names of variables and of their roles."""

SERIES_TIME = f"t_{SERIES}"
"""The coordinate of the numbers that are recorded more often."""

COMPLETE = "complete"
"""The status of a run that reached its end."""

FRAMES_BEFORE = "frames_before"
"""The attribute of a result that went beyond its end: the numbers of frames with which it was asked for."""

LIBRARIES = ("scikit-sundae", "numpy", "numba")
"""The packages whose versions a result names."""

REFERENCE = (
    "Vladimirov, V., and Skurativskyi, S. (2015): Solitary waves in one-dimensional pre-stressed lattice and its continual "
    "analog"
)

LONG_NAMES = {
    "t": "time",
    SERIES_TIME: "time of what is recorded more often than the fields",
    "x": "coordinate along the periodic line",
    "k": "number of the site in the chain",
    "mass": "mass, the integral of the first component",
    "momentum": "momentum",
    "energy": "energy",
    "wave": "number of the wave",
    "position": "position of the crest, not wrapped",
    "height": "height of the crest, negative for a dark wave",
    "speed": "speed of the crest",
    "width": "width at half the height",
    "residual": "L2 distance from the exact wave that fits, relative to its norm, in the core of the wave",
    "family_speed": "speed of the exact wave of this height",
    "compacton": "whether profile, height and speed are those of one exact wave",
    "first_seen": "time of the first frame in which the wave was seen",
    "isolated": "whether the support of the wave is clear of all others",
    "mass_left": "integral of the field outside the waves",
    "momentum_left": "half the integral of the squared field outside the waves",
    "height_left": "largest size of the field outside the waves",
    "moment": "time of the first collision",
    "phase_shift": "how far the wave is ahead of its free flight after the first collision",
    "speed_before": "speed before the first collision",
    "speed_after": "speed after the first collision",
    "height_before": "height before the first collision",
    "height_after": "height after the first collision",
    "scatter": "largest distance of a position from the straight line of free flight",
    "flight_end": "last time of free flight after the first collision, or else of the first flight",
    "incoming_noise": "standard error of the line of free flight before the collision, at its moment",
    "misfit": "mean residual of the fit of the exact wave while it is measured",
    "window_t": "middle of a window of free flight, since the collision or the start",
    "window_t_left": "middle of a window in which all waves are free, since the last of the first collisions",
    **{
        f"{prefix}{name}{suffix}": f"{words}{what}"
        for name, what in {
            "phase_shift": "phase shift",
            "speed": "speed",
            "height": "height",
            "mismatch": "speed less that of a compacton as high",
            "mass_left": "integral of the field outside the waves",
            "momentum_left": "half the integral of the squared field outside the waves",
            "height_left": "largest size of the field outside the waves",
        }.items()
        for prefix, suffix, words in (
            ("window_", "", "in each window of free flight, "),
            ("", "_noise", "standard error in a window of the "),
            ("", "_settling", "how far from what it tends to may be the "),
            ("", "_reading", "error of reading from the frames the "),
        )
    },
    "continuum": "the continuum at the sites of the chain",
    "distance": "L2 distance of chain and continuum, relative to the norm of the chain",
    "continuum_position": "position of the crest in the continuum, in sites, not wrapped",
    "continuum_height": "height of the crest in the continuum",
    "continuum_width": "width at half the height in the continuum, in sites",
    "value": "value, extrapolated to the limit; of a profile its L2 norm",
    "error": "error",
    "profile": "last profile to which the members tend",
    "space_error": "part of the error from the grid",
    "time_error": "part of the error from the tolerance of the integrator",
    "viscosity_error": "part of the error from the viscosity",
    "scheme_error": "distance of the independent schemes",
    "settling_error": "part of the error from what goes on changing after a collision",
    "reading_error": "part of the error from how exactly it is read from the frames",
    "failed": "members of the family that did not run to their end",
    "members": "members of the family",
    "rate": "observed power of the grid spacing at which the error falls",
    "scale": "what errors are relative to",
    "continuum_residual": "relative L2 misfit of the compacton in the continuum",
    "spacing": "distance between neighbouring grid points",
}
"""The names that this program gives; an equation brings those of its own variables. All are nondimensional, with units "1"."""


@dataclass(frozen=True)
class WaveOutline:
    """A solitary wave of the initial data, as analysis needs it.

    Parameters
    ----------
    sign : int
        1 for a bright one, -1 for a dark one.
    center, speed : float
        Where it is at t = 0, and its speed.
    height, width : float
        Its height, positive, and the length of its support.
    """

    sign: int
    center: float
    speed: float
    height: float
    width: float


@dataclass(frozen=True, eq=False)
class Layout:
    """All that a recorder needs to know of a result before the first frame.

    Parameters
    ----------
    fields, series : dict
        The attributes of the components and of the numbers along t, by name.
    space : str
        The dimension in space.
    coordinates : array, shape (N,)
        The points.
    coordinate_attributes : dict
        Those of the coordinate.
    frames : int
        How many frames are expected.
    attributes : dict
        The global attributes.
    series_per_frame : int
        How often the series are recorded from one frame to the next.
    """

    fields: dict[str, dict[str, Any]]
    series: dict[str, dict[str, Any]]
    space: str
    coordinates: NDArray[np.float64]
    coordinate_attributes: dict[str, Any]
    frames: int
    attributes: dict[str, Any]
    series_per_frame: int = 1

    @property
    def often(self) -> dict[str, dict[str, Any]]:
        """The attributes of what is recorded more often than the fields, its time first, by name."""
        if self.series_per_frame == 1:
            return {}
        numbers = {f"{name}_{SERIES}": own | {"role": f"{own['role']} {SERIES}"} for name, own in self.series.items()}
        return {SERIES_TIME: describe(SERIES_TIME), **numbers}

    def block(self, between: NDArray[np.float64]) -> NDArray[np.float64]:
        """What is recorded more often, from one frame to the next, shape (of `often`, series_per_frame); NaN before the first.

        Parameters
        ----------
        between : array, shape (times, 1 + numbers)
            The time and the series at each of these times, the last of which is that of the frame.
        """
        block = np.full((len(self.often), self.series_per_frame), np.nan)
        if self.often:
            block[:, self.series_per_frame - len(between) :] = np.transpose(between)
        return block


def describe(name: str) -> dict[str, str]:
    """The attributes of a variable that this program names."""
    return {"long_name": LONG_NAMES[name], "units": "1"}


def layout_of(
    simulation: Simulation, conserved: Sequence[str], diagnostics: Sequence[str], magnitudes: Mapping[str, float] | None = None
) -> Layout:
    """The layout of the result of a simulation, from the names of its numbers along t and magnitudes of the conserved ones.

    A magnitude, the sum of the sizes of what the first value is a sum of, becomes the attribute ``magnitude``.
    """
    own = simulation.equation.long_names

    def described(name: str, role: str) -> dict[str, Any]:
        return {"long_name": own.get(name) or LONG_NAMES.get(name, name), "units": "1", "role": role}

    for name in (*conserved, *diagnostics):
        require(
            name.isidentifier() and name not in simulation.equation.variables,
            f"{type(simulation.equation).__name__} gives a number along t the name {name!r}; choose one that no variable has.",
        )
        require(
            not name.endswith(f"_{SERIES}") and name != "restart",
            f"{type(simulation.equation).__name__} gives a number along t the name {name!r}; choose one that is not 'restart' "
            f"and does not end with _{SERIES}.",
        )
    grid = simulation.grid
    sizes = {name: {"magnitude": magnitude} for name, magnitude in (magnitudes or {}).items()}
    return Layout(
        fields={name: described(name, FIELD) for name in simulation.equation.variables},
        series={name: described(name, CONSERVED) | sizes.get(name, {}) for name in conserved}
        | {name: described(name, DIAGNOSTIC) for name in diagnostics},
        space=grid.dimension,
        coordinates=grid.coordinates,
        coordinate_attributes=describe(grid.dimension) | {"period": float(grid.length), "spacing": float(grid.spacing)},
        frames=simulation.frames,
        attributes=attributes(simulation),
        series_per_frame=simulation.series_per_frame,
    )


@cache
def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "of unknown version"


@cache
def source() -> str:
    """The program and the libraries that compute, with their versions."""
    libraries = ", ".join(f"{name} {_version(name)}" for name in LIBRARIES)
    return f"mol_compactons {_version('mol_compactons')} (SUNDIALS {import_sundae().SUNDIALS_VERSION}, {libraries})"


def outlines(simulation: Simulation) -> list[WaveOutline]:
    """The outlines of the solitary waves that a simulation starts from."""
    waves = []
    for wave in simulation.initial:
        if isinstance(wave, LocalizedWave):
            height, width = wave.outline(simulation.equation)
            waves.append(WaveOutline(wave.sign, wave.center, wave.speed, abs(height), width))
    return waves


def attributes(simulation: Simulation) -> dict[str, Any]:
    """The global attributes of a result whose run has just begun."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    name = type(simulation.equation).__name__
    return {
        "Conventions": "CF-1.11",
        "title": simulation.headline,
        "institution": "not stated",
        "source": f"{source()}: numerical solution of {name}",
        "history": f"{now}: computed by mol_compactons {_version('mol_compactons')}",
        "references": simulation.equation.reference or REFERENCE,
        "comment": "All quantities are nondimensional. The attribute simulation holds everything needed to repeat the run.",
        "format": FORMAT,
        "simulation": simulation.to_json(),
        "waves": json.dumps([asdict(outline) for outline in outlines(simulation)]),
        "status": "running",
    }


def cost_attributes(status: str, counters: Counters, seconds: float) -> dict[str, Any]:
    """The global attributes that a run adds when it ends."""
    return {
        "status": status,
        "solver_steps": counters.steps,
        "solver_evaluations": counters.evaluations,
        "solver_jacobians": counters.jacobians,
        "solver_failures": counters.failures,
        "solver_warnings": counters.warnings,
        "solver_first_warning": counters.first_warning,
        "cpu_seconds": round(seconds, 3),
    }
