"""What a member of a family came to: its quantities, what errors of each are compared with, and how each settled."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.collisions import first_collision, least_change
from mol_compactons.analysis.drift import drift
from mol_compactons.analysis.settling import WINDOWS, reading_noise
from mol_compactons.results.reading import conserved_names, field_names
from mol_compactons.simulation import Simulation
from mol_compactons.studies.family import Member

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

LARGEST_VALUES = frozenset({"height left"})
"""Quantities that are the largest of many values, and so no smooth function of the grid: they are not extrapolated."""


LAST_READINGS = 20
"""How many frames tell how exactly the last one is read."""


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
    """

    t: Array
    values: Array
    noise: float
    least: float = 0.0


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
    readings : dict of str to float
        How exactly each is read from the frames, where that is not to round-off; NaN where that is not known.
    steps : int, optional
        How many steps the integrator took.
    fingerprint : str
        The same for two members with the same numbers, bit for bit, and for no others.
    """

    member: Member
    values: dict[str, Array]
    scales: dict[str, float]
    courses: dict[str, Course] = field(default_factory=dict)
    readings: dict[str, float] = field(default_factory=dict)
    steps: int | None = None
    fingerprint: str = ""

    def add(
        self, name: str, value: float | xr.DataArray, scale: float, course: Course | None = None, reading: float = 0.0
    ) -> None:
        """Take note of a number."""
        self.values[name], self.scales[name], self.readings[name] = np.array(float(value)), float(scale), float(reading)
        if course is not None:
            self.courses[name] = course

    def is_same_run_as(self, other: Outcome) -> bool:
        """Whether two members are one run under two names: the same numbers, bit for bit."""
        return self.fingerprint == other.fingerprint

    def has_the_steps_of(self, other: Outcome) -> bool:
        """Whether two tolerances came to the same steps, as fixed ones do that are cut to the times of the frames."""
        known = self.steps is not None and self.member.size == other.member.size
        return self.is_same_run_as(other) or (known and self.steps == other.steps)

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
    scales = {"profile": float(np.linalg.norm(profile))}
    outcome = Outcome(member, {"profile": profile}, scales, steps=steps, fingerprint=_fingerprint(result))
    for quantity, change in drift(result).data_vars.items():
        outcome.add(f"{quantity} drift", float(change[-1]), 1.0)
    if "position" in result:
        _add_waves(outcome, result)
    return outcome


def _fingerprint(result: xr.Dataset) -> str:
    """A digest of the last frame and of the conserved quantities at all times."""
    digest = hashlib.sha256()
    for name in (*field_names(result), *conserved_names(result)):
        digest.update(name.encode() + np.ascontiguousarray(result[name].values).tobytes())
    return digest.hexdigest()


def _add_waves(outcome: Outcome, tracks: xr.Dataset) -> None:
    """Add what the tracks say about each wave, once it has settled, and about what it left behind."""
    collision = first_collision(tracks)
    for wave in range(tracks.sizes["wave"]):
        one = collision.isel(wave=wave)
        collided = not np.isnan(one.phase_shift)
        when, label = ("after", f"{wave} after") if collided else ("before", f"{wave}")
        width = float(tracks.width[0, wave])
        courses = _courses(one)
        scales = {"height": abs(float(tracks.height[0, wave])), "speed": abs(float(one.speed_before))}
        for name, scale in scales.items():
            outcome.add(f"{name} {label}", one[f"{name}_{when}"], scale, courses[name], float(one[f"{name}_reading"]))
        outcome.add(f"position {wave}", tracks.position[-1, wave], width, reading=_reading_of_place(outcome, tracks, wave))
        if collided:
            reading = float(one.phase_shift_reading)
            outcome.add(f"phase shift {wave}", one.phase_shift, width, courses["phase_shift"], reading)
    _add_what_is_left(outcome, tracks, collision)


def _reading_of_place(outcome: Outcome, tracks: xr.Dataset, wave: int) -> float:
    """How exactly the last position is read: twice the error of one of the last readings, and what the misfit leaves open.

    With too few of them a peak is at least known to lie between two points of the grid.
    """
    noise = 2 * reading_noise(tracks.position.values[-LAST_READINGS:, wave])
    misfit = float(tracks.residual[-1, wave]) if "residual" in tracks else np.nan
    width = float(np.nanmax(tracks.width[:, wave]))
    bounded = outcome.member.simulation.grid.spacing if np.isnan(noise) else noise
    return bounded + (0.0 if np.isnan(misfit) else 0.5 * misfit * width)


def _add_what_is_left(outcome: Outcome, tracks: xr.Dataset, collision: xr.Dataset) -> None:
    """Add what the waves left behind: after a collision while all are free, else at the end."""
    first, spacing = outcome.member.simulation.initial_state()[0], outcome.member.simulation.grid.spacing
    totals = {"mass": np.abs(first).sum() * spacing, "momentum": 0.5 * spacing * first @ first, "height": np.abs(first).max()}
    collided_at_all = bool(np.isfinite(collision.phase_shift).any())
    for name, total in totals.items():
        left = f"{name}_left"
        if collided_at_all:
            windows, noise = collision[f"window_{left}"].values, float(collision[f"{left}_noise"])
            course = Course(collision.window_t_left.values, windows, noise)
            outcome.add(f"{name} left", collision[left], total, course, float(collision[f"{left}_reading"]))
        else:
            # Half the range: a largest value has no standard error.
            noise = 0.5 * float(np.ptp(tracks[left].values[-LAST_READINGS:]))
            outcome.add(f"{name} left", tracks[left][-1], total, reading=noise)


def _courses(one: xr.Dataset) -> dict[str, Course]:
    """How the phase shift, the speed and the height of a wave went on."""
    t = one.window_t.values
    names = ("phase_shift", "speed", "height")
    if t.size != WINDOWS or np.isnan(t).any():
        return {name: Course(t, t, np.nan) for name in names}
    last = [float(one[f"window_{name}"][-1]) for name in ("speed", "height", "mismatch")]
    least = least_change(float(t[-1]), *last)
    return {name: Course(t, one[f"window_{name}"].values, float(one[f"{name}_noise"]), least[name]) for name in names}


def on_grid(profile: Array, size: int) -> Array:
    """A periodic profile on a coarser grid with the same first point, by a cubic spline where the points do not coincide."""
    if profile.size % size == 0:
        return profile[:: profile.size // size]
    from scipy.interpolate import CubicSpline

    places = np.arange(profile.size + 1) / profile.size
    return np.asarray(CubicSpline(places, np.append(profile, profile[0]), bc_type="periodic")(np.arange(size) / size))
