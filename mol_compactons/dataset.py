"""What a result looks like: its names, units, long names and attributes, after the CF conventions 1.11."""

from __future__ import annotations

from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mol_compactons.integrators.progress import Counters

if TYPE_CHECKING:
    import xarray as xr

    from mol_compactons.simulation import Simulation

REFERENCE = (
    "Vladimirov, V., and Skurativskyi, S. (2015): Solitary waves in one-dimensional pre-stressed lattice and its continual "
    "analog"
)

LONG_NAMES = {
    "t": "time",
    "x": "coordinate along the periodic line",
    "k": "number of the site in the chain",
    "W": "amplitude, positive for compression",
    "u": "amplitude",
    "S": "stress",
    "v": "velocity",
    "R": "stress between neighbouring grains, the difference of their displacements",
    "R_t": "rate of the stress",
    "Q": "displacement of a grain",
    "p": "momentum of a grain",
    "mass": "mass, the integral of the first component",
    "momentum": "momentum, the integral of the velocity or, for a one-way equation, Q, half that of the squared amplitude",
    "energy": "energy, the Hamiltonian with the second difference of the scheme",
    "wave": "number of the wave",
    "position": "position of the crest, not wrapped",
    "height": "height of the crest, negative for a dark wave",
    "speed": "speed of the crest",
    "width": "width at half the height",
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
    "continuum": "the continuum at the sites of the chain",
    "distance": "L2 distance of chain and continuum, relative to the norm of the chain",
    "continuum_position": "position of the crest in the continuum, in sites, not wrapped",
    "continuum_height": "height of the crest in the continuum",
    "continuum_width": "width at half the height in the continuum, in sites",
    "value": "value, extrapolated to the limit; of a profile its L2 norm",
    "error": "error",
    "space_error": "part of the error from the grid",
    "time_error": "part of the error from the tolerance of the integrator",
    "viscosity_error": "part of the error from the viscosity",
    "scheme_error": "distance of the independent schemes",
    "rate": "observed power of the grid spacing at which the error falls",
    "scale": "what errors are relative to",
    "spacing": "distance between neighbouring grid points",
}
"""Every name in a result; all are nondimensional, with units "1"."""


def describe(name: str) -> dict[str, str]:
    """The attributes of a variable, by its name."""
    return {"long_name": LONG_NAMES[name], "units": "1"}


@cache
def _version() -> str:
    return version("mol_compactons")


def attributes(simulation: Simulation) -> dict[str, str]:
    """The global attributes of a result whose run has just begun."""
    program = f"mol_compactons {_version()}"
    now = datetime.now(UTC).isoformat(timespec="seconds")
    name = type(simulation.equation).__name__
    return {
        "Conventions": "CF-1.11",
        "title": simulation.title or f"{name} by {type(simulation.scheme).__name__}",
        "institution": "not stated",
        "source": f"{program}: numerical solution of {name}",
        "history": f"{now}: computed by {program}",
        "references": REFERENCE,
        "comment": "All quantities are nondimensional. The attribute simulation holds everything needed to repeat the run.",
        "simulation": simulation.to_json(),
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


def field_names(dataset: xr.Dataset) -> list[str]:
    """The components of the state in a result: its variables along t and space."""
    return [str(name) for name, variable in dataset.data_vars.items() if variable.ndim == 2]


def conserved_names(dataset: xr.Dataset) -> list[str]:
    """The conserved quantities in a result: its variables along t alone."""
    return [str(name) for name, variable in dataset.data_vars.items() if variable.dims == ("t",)]


class Recorder(Protocol):
    """Takes the frames of a run, one after the other."""

    def append(self, t: float, state: NDArray[np.float64], conserved: dict[str, float]) -> None:
        """Add a frame: a state of shape (components, size) and the conserved quantities."""

    def close(self, attributes: dict[str, Any]) -> None:
        """End the recording with the attributes of a run that has ended."""

    def dataset(self) -> xr.Dataset:
        """What was recorded."""


class MemoryRecorder:
    """A `Recorder` that keeps the frames in memory."""

    def __init__(self, simulation: Simulation, conserved: list[str]) -> None:
        self._simulation = simulation
        self._conserved = conserved
        self._attributes: dict[str, Any] = attributes(simulation)
        self._t: list[float] = []
        self._states: list[NDArray[np.float64]] = []
        self._values: list[dict[str, float]] = []

    def append(self, t: float, state: NDArray[np.float64], conserved: dict[str, float]) -> None:
        """Add a frame."""
        self._t.append(t)
        self._states.append(state.copy())
        self._values.append(conserved)

    def close(self, attributes: dict[str, Any]) -> None:
        """End the recording."""
        self._attributes |= attributes

    def dataset(self) -> xr.Dataset:
        """What was recorded."""
        import xarray as xr

        simulation = self._simulation
        names = simulation.equation.variables
        frames = np.array(self._states).reshape(len(self._t), len(names), simulation.grid.size)
        space = simulation.grid.dimension
        fields = {name: (("t", space), frames[:, index], describe(name)) for index, name in enumerate(names)}
        series = {name: ("t", np.array([values[name] for values in self._values]), describe(name)) for name in self._conserved}
        coordinates = {
            "t": ("t", np.array(self._t), describe("t")),
            space: (space, simulation.grid.coordinates, describe(space)),
        }
        return xr.Dataset({**fields, **series}, coordinates, self._attributes)
