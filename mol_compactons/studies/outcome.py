"""What a member of a family came to: its quantities, what errors of each are compared with, and how each settled."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.collisions import first_collision, least_change
from mol_compactons.analysis.drift import drift
from mol_compactons.analysis.settling import WINDOWS
from mol_compactons.results.reading import field_names
from mol_compactons.simulation import Simulation
from mol_compactons.studies.family import Member

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

LARGEST_VALUES = frozenset({"height left"})
"""Quantities that are the largest of many values, and so no smooth function of the grid: they are not extrapolated."""


@dataclass(frozen=True, eq=False)
class Course:
    """How a quantity went on in the windows of free flight.

    Parameters
    ----------
    t, values : array, shape (3,)
        The middle of each window since the moment of the collision, and the quantity there; NaN where there are no windows.
    noise : float
        The standard error of the last value.
    least : float
        The signed change that is to come because the speed and the height of the wave do not belong together.
    common : float
        An error that all windows share.
    """

    t: Array
    values: Array
    noise: float
    least: float = 0.0
    common: float = 0.0


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a member of a family came to.

    Parameters
    ----------
    member : Member
        The member.
    values : dict of str to array
        Each quantity: a number, or a profile on the points of the coarsest grid.
    scales : dict of str to float
        What an error of each is compared with.
    courses : dict of str to Course
        Of the quantities that stand for all later times.
    steps : int, optional
        How many steps the integrator took.
    """

    member: Member
    values: dict[str, Array]
    scales: dict[str, float]
    courses: dict[str, Course] = field(default_factory=dict)
    steps: int | None = None

    def add(self, name: str, value: float | xr.DataArray, scale: float, course: Course | None = None) -> None:
        """Take note of a number."""
        self.values[name], self.scales[name] = np.array(float(value)), float(scale)
        if course is not None:
            self.courses[name] = course

    def is_same_run_as(self, other: Outcome) -> bool:
        """Whether two tolerances came to the same steps, as fixed steps do that are cut to the times of the frames."""
        same_steps = self.steps is not None and self.steps == other.steps and self.member.size == other.member.size
        return same_steps and bool(np.array_equal(self.values["profile"], other.values["profile"]))

    def knows(self, quantity: str) -> bool:
        """Whether it has a value of a quantity."""
        return quantity in self.values and not np.isnan(self.values[quantity]).any()


def outcome_of(result: xr.Dataset, coarsest: int) -> Outcome:
    """What a stored member came to, with its profile on the points of the coarsest grid."""
    simulation = Simulation.from_json(str(result.attrs["simulation"]))
    amounts = float(result.attrs["viscosity"]), float(result.attrs["tolerance"])
    member = Member(str(result.attrs["limit"]), simulation.scheme.label, *amounts, simulation)
    profile = on_grid(result[field_names(result)[0]].values, coarsest) * np.sqrt(simulation.grid.length / coarsest)
    steps = int(result.attrs["solver_steps"]) if "solver_steps" in result.attrs else None
    outcome = Outcome(member, {"profile": profile}, {"profile": float(np.linalg.norm(profile))}, steps=steps)
    for quantity, change in drift(result).data_vars.items():
        outcome.add(f"{quantity} drift", float(change[-1]), 1.0)
    if "position" in result:
        _add_waves(outcome, result)
    return outcome


def _add_waves(outcome: Outcome, tracks: xr.Dataset) -> None:
    """Add what the tracks say about each wave, once it has settled, and about what it left behind."""
    collision = first_collision(tracks)
    for wave in range(tracks.sizes["wave"]):
        one = collision.isel(wave=wave)
        collided = not np.isnan(one.phase_shift)
        when, label = ("after", f"{wave} after") if collided else ("before", f"{wave}")
        width = float(tracks.width[0, wave])
        courses = _courses(one)
        outcome.add(f"height {label}", one[f"height_{when}"], abs(float(tracks.height[0, wave])), courses["height"])
        outcome.add(f"speed {label}", one[f"speed_{when}"], abs(float(one.speed_before)), courses["speed"])
        outcome.add(f"position {wave}", tracks.position[-1, wave], width)
        if collided:
            outcome.add(f"phase shift {wave}", one.phase_shift, width, courses["phase_shift"])
    first, spacing = outcome.member.simulation.initial_state()[0], outcome.member.simulation.grid.spacing
    totals = {"mass": np.abs(first).sum() * spacing, "momentum": 0.5 * spacing * first @ first, "height": np.abs(first).max()}
    collided_at_all = bool(np.isfinite(collision.phase_shift).any())
    for name, total in totals.items():
        left = f"{name}_left"
        if collided_at_all:
            windows = collision[f"window_{left}"].values
            course = Course(collision.window_t_left.values, windows, float(collision[f"{left}_noise"]))
            outcome.add(f"{name} left", collision[left], total, course)
        else:
            outcome.add(f"{name} left", tracks[left][-1], total)


def _courses(one: xr.Dataset) -> dict[str, Course]:
    """How the phase shift, the speed and the height of a wave went on."""
    t = one.window_t.values
    names = ("phase_shift", "speed", "height")
    if t.size != WINDOWS or np.isnan(t).any():
        return {name: Course(t, t, np.nan) for name in names}
    last = [float(one[f"window_{name}"][-1]) for name in ("speed", "height", "mismatch")]
    least = least_change(float(t[-1]), *last)
    common = {"phase_shift": 2 * float(one.incoming_noise)}
    return {
        name: Course(t, one[f"window_{name}"].values, float(one[f"{name}_noise"]), least[name], common.get(name, 0.0))
        for name in names
    }


def on_grid(profile: Array, size: int) -> Array:
    """A periodic profile on a coarser grid with the same first point, by a cubic spline where the points do not coincide."""
    if profile.size % size == 0:
        return profile[:: profile.size // size]
    from scipy.interpolate import CubicSpline

    places = np.arange(profile.size + 1) / profile.size
    return np.asarray(CubicSpline(places, np.append(profile, profile[0]), bc_type="periodic")(np.arange(size) / size))
