"""What of a result contradicts what is known: of waves with an edge, of what is conserved, of grids, viscosity and tolerances.

Each check is a function of a `Case`, and says what it found in one sentence, or nothing where it has nothing to look at.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.drift import drift
from mol_compactons.analysis.following import FEWEST_FRAMES
from mol_compactons.analysis.tracking import track
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid
from mol_compactons.results.reading import arranged, field_names, grid_of, outlines_of
from mol_compactons.schemes.viscosity import Damping, ViscousScheme
from mol_compactons.simulation import Simulation

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

Verdict = Literal["agrees", "doubtful", "contradicts"]

DOUBTFUL_MISFIT, WRONG_MISFIT = 2e-3, 2e-2
"""From which relative distance on a speed is not that of its height, and a profile not that of a wave of the equation."""

SETTLED_SHARE = 1 / 3
"""The last part of a run, in which waves should have settled."""

FEWEST_POINTS = 16
"""Points in the support of a wave below which its error is several per cent, for n = 3 (`python -m benchmarks.orders`)."""

FINEST_SHARE = 1e-4
"""The part of the squared field beyond two thirds of the wave numbers of the grid that edges alone do not make."""

DIFFERENCE = 1e-4
"""The step of the difference that gives what the viscosity takes, relative to the largest value of the field."""

LEAST_WORN = 1e-9
"""What the viscosity takes of a quantity below this part of it is round-off."""

WORN = 1e-3
"""The part of the momentum that a viscosity may take before it is worth a word."""


@dataclass(frozen=True)
class Finding:
    """What one check found.

    Parameters
    ----------
    check : str
        What was looked at, in a word or two.
    verdict : {"agrees", "doubtful", "contradicts"}
        Whether it is as it should be.
    sentence : str
        What was seen, beside what is known, and what to do.
    """

    check: str
    verdict: Verdict
    sentence: str


@dataclass(frozen=True, eq=False)
class Case:
    """A result under examination, with what several checks need.

    Parameters
    ----------
    dataset : xarray.Dataset
        The result, in the order (t, x).
    """

    dataset: xr.Dataset

    @cached_property
    def settings(self) -> dict[str, Any]:
        """The simulation as it is written in the result, whose classes may be unknown here."""
        settings: dict[str, Any] = json.loads(str(self.dataset.attrs["simulation"]))
        return settings

    @cached_property
    def simulation(self) -> Simulation | None:
        """The simulation; None where a class of it is not loaded."""
        try:
            return Simulation.from_json(str(self.dataset.attrs["simulation"]))
        except InputError:
            return None

    @cached_property
    def tracks(self) -> xr.Dataset | None:
        """The tracks of the waves; None where there is nothing to follow."""
        try:
            return track(self.dataset)
        except InputError:
            return None

    @cached_property
    def worn(self) -> dict[str, Array]:
        """What the viscosity has added to each conserved quantity up to each frame: the integral of its change along D u.

        With the damping D that is the derivative of the quantity in the direction D u, by a difference, which is exact for
        a square.
        """
        if self.simulation is None or len(field_names(self.dataset)) > 1:
            return {}
        scheme, grid = self.simulation.scheme, self.simulation.grid
        if not isinstance(scheme, ViscousScheme) or not any(scheme.viscosities):
            return {}
        damping, system = Damping(scheme, grid.spacing), self.simulation.discretize()
        rates: dict[str, list[float]] = {}
        for frame in self.frames:
            change = np.zeros(frame.size)
            damping.add(np.ascontiguousarray(frame), change)
            step = DIFFERENCE * float(np.abs(frame).max()) / (float(np.abs(change).max()) or 1.0)
            ahead, behind = (system.invariants((frame + sign * step * change)[np.newaxis]) for sign in (1, -1))
            for name, value in ahead.items():
                rates.setdefault(name, []).append((value - behind[name]) / (2 * step or 1.0))
        between = np.diff(self.dataset["t"].values)
        return {
            name: np.concatenate([[0.0], np.cumsum(0.5 * (np.array(rate[1:]) + np.array(rate[:-1])) * between)])
            for name, rate in rates.items()
        }

    def speed_of(self, height: float) -> float | None:
        """The speed of the wave of a signed height; None where none is known."""
        if self.simulation is None or not np.isfinite(height) or not height:
            return None
        return self.simulation.equation.solitary_speed(abs(height), int(np.sign(height)))

    @cached_property
    def frames(self) -> Array:
        """The first component, shape (t, points)."""
        return np.asarray(self.dataset[field_names(self.dataset)[0]].values)

    @cached_property
    def rtol(self) -> float | None:
        """The relative tolerance of the integrator; None for one of fixed step."""
        value = self.settings["integrator"].get("rtol")
        return None if value is None else float(value)


def check_up(dataset: xr.Dataset) -> list[Finding]:
    """What of a result agrees with what is known, is doubtful, or contradicts it.

    Looked at are: how the run ended; the drift of each conserved quantity against the tolerance, less what the viscosity
    takes; each wave's speed against the speed that belongs to its height, and its profile against
    that of an exact wave; the points in a wave; waves that go round the ring; ripples at the scale of the grid; an absolute
    tolerance against the height of the waves; growth that the equation itself has; the troubles of the solver.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of a run.

    Returns
    -------
    list of Finding

    Raises
    ------
    InputError
        If it is no result of a run, or holds no frame.
    """
    require("simulation" in dataset.attrs and "t" in dataset.dims, "This is no result of a run; give what run() returned.")
    require(dataset.sizes["t"] > 0, "The result holds no frame; give one of a run that has begun.")
    case = Case(arranged(dataset))
    return [finding for check in CHECKS for finding in check(case)]


def _judged(value: float, doubtful: float, wrong: float) -> Verdict:
    """A value that is not known contradicts everything."""
    return "agrees" if value <= doubtful else "doubtful" if value <= wrong else "contradicts"


def _sound(condition: bool) -> Verdict:
    return "agrees" if condition else "doubtful"


def _found(check: str, verdict: Verdict, told: str, cure: str) -> Finding:
    """What was seen, with what to do where it is not as it should be."""
    return Finding(check, verdict, f"{told}." if verdict == "agrees" else f"{told}; {cure}.")


def _ending(case: Case) -> Iterator[Finding]:
    status = str(case.dataset.attrs.get("status", "unknown"))
    reached, wanted = float(case.dataset["t"][-1]), float(case.settings["t_end"])
    if not np.isfinite(case.frames).all():
        first = float(case.dataset["t"][int(np.argmin(np.isfinite(case.frames).all(axis=1)))])
        yield Finding(
            "frames", "contradicts", f"there are values that are no numbers, first at t = {first:g}; use none after it."
        )
    known = status == "complete" and reached >= wanted * (1 - 1e-12)
    told = f"{case.dataset.sizes['t']} frames to t = {reached:g} of {wanted:g}, {status}"
    yield _found("status", _sound(known), told, "it is not the whole run")


def _conserved(case: Case) -> Iterator[Finding]:
    """Drift against the tolerance; of one field less what the viscosity took."""
    tolerance = max(10 * case.rtol, 1e-12) if case.rtol is not None else 1e-6
    for name, change in drift(case.dataset).data_vars.items():
        values = change.values
        relative_to, size = change.attrs["relative_to"], float(np.abs(values).max())
        told = f"changes by {size:.1e} of {relative_to}"
        worn = case.worn.get(str(name))
        if worn is not None and float(np.abs(worn).max()) > LEAST_WORN * float(change.attrs["scale"]):
            times, at = case.dataset["t"].values, change[change.dims[0]].values
            explained = np.interp(at, times, worn) / float(change.attrs["scale"] or 1.0)
            told += f"; the viscosity takes {abs(float(explained[-1])):.1e}"
            # A scheme that does not keep the quantity may give back what the viscosity takes: what hardly changes is no fault.
            size = min(size, float(np.abs(values - explained).max()))
        verdict = _judged(size, tolerance, max(WRONG_MISFIT, tolerance))
        cure = f"the integrator's part is {tolerance:.0e}, the rest that of the scheme and its viscosity: refine the grid"
        yield _found(str(name), verdict, told, cure)


def _viscosity(case: Case) -> Iterator[Finding]:
    if "momentum" not in case.worn:
        return
    share = -float(case.worn["momentum"][-1]) / (0.5 * grid_of(case.dataset).spacing * float((case.frames[0] ** 2).sum()))
    cure = "that is not the equation's: choose a smaller viscosity, or a finer grid"
    told = f"it takes {share:.1e} of the integral of the squared field"
    yield _found("viscosity", _judged(share, WORN, 0.1), told, cure)


def _waves(case: Case) -> Iterator[Finding]:
    """Speed, height and profile that belong together, at the end of the run."""
    if case.tracks is None:
        return
    lost = str(case.tracks.attrs["lost"])
    if lost:
        yield Finding("tracks", "contradicts", lost)
    if case.simulation is None:
        return
    late = case.tracks.isel(t=slice(int((1 - SETTLED_SHARE) * case.tracks.sizes["t"]), None))
    late = late.isel(wave=[case.speed_of(_median(height)) is not None for height in late["height"].values.T])
    measured = late.where(late["isolated"])
    for wave in range(late.sizes["wave"]):
        if late["isolated"].values[:, wave].any():
            yield from _one_wave(case, measured.isel(wave=wave))


def _one_wave(case: Case, wave: xr.Dataset) -> Iterator[Finding]:
    height, speed, misfit = _median(wave["height"].values), _mean_speed(wave), _median(wave["residual"].values)
    name, belongs = f"wave {int(wave['wave'])}", case.speed_of(height)
    if np.isnan(misfit):
        yield Finding(name, "contradicts", "no exact wave of the equation fits it.")
        return
    if np.isfinite(speed) and belongs is not None:
        apart = abs(abs(speed / belongs) - 1)
        told = f"moves at {speed:.5g}, a wave of its height {height:.5g} at {belongs:.5g}, {apart:.1e} apart"
        yield _found(name, _judged(apart, DOUBTFUL_MISFIT, WRONG_MISFIT), told, "it has not settled, or is not resolved")
    told = f"its profile differs from the exact wave that fits by {misfit:.1e}"
    verdict = _judged(misfit, 5 * DOUBTFUL_MISFIT, 5 * WRONG_MISFIT)
    yield _found(name, verdict, told, "something else is added to it, or it is none")


def _mean_speed(wave: xr.Dataset) -> float:
    """The slope of the line through the places of a wave; NaN unless it moves by its width, or the slope says little."""
    known = wave.dropna("t", subset=["position"])
    places = known["position"].values
    if places.size < FEWEST_FRAMES or np.ptp(places) < float(known["width"].median()):
        return np.nan
    return float(np.polyfit(known["t"].values, places, 1)[0])


def _median(values: Array) -> float:
    known = values[~np.isnan(values)]
    return float(np.median(known)) if known.size else np.nan


def _resolution(case: Case) -> Iterator[Finding]:
    grid, waves = grid_of(case.dataset), outlines_of(case.dataset)
    if not isinstance(grid, Grid) or not waves:
        return
    points = min(wave.width for wave in waves) / grid.spacing
    cure = f"below {FEWEST_POINTS} the error is several per cent: choose a larger grid.size"
    told = f"the narrowest wave has {points:.0f} points in its support"
    yield _found("grid", _sound(points >= FEWEST_POINTS), told, cure)


def _ring(case: Case) -> Iterator[Finding]:
    """A wave that has gone round the ring runs through what the waves left behind."""
    if case.tracks is None or not isinstance(grid_of(case.dataset), Grid):
        return
    tracks, length = case.tracks, grid_of(case.dataset).length
    places = tracks["position"].values
    first_seen = np.argmax(~np.isnan(places), axis=0)
    gone = np.abs(places - places[first_seen, np.arange(places.shape[1])]) + tracks["width"].values
    round_it = np.argwhere(np.nan_to_num(gone) > length)
    if not len(round_it):
        return
    frame, wave = round_it[0]
    moment, left = float(tracks["t"][frame]), float(np.nanmax(tracks["height_left"].values, initial=0.0))
    share = left / float(np.nanmax(np.abs(tracks["height"].values[0])))
    told = f"from t = {moment:g} on wave {int(tracks['wave'][wave])} runs through ripples, up to {share:.1e} of its height"
    yield _found("ring", _sound(share <= DOUBTFUL_MISFIT), told, "choose a longer box, or an earlier end")


def _seam(case: Case) -> Iterator[Finding]:
    """Data that do not close on the ring start with a shock where the ring closes."""
    if not isinstance(grid_of(case.dataset), Grid):
        return
    first = case.frames[0]
    jumps = np.abs(np.diff(first, append=first[:1]))
    seam, elsewhere, size = float(jumps[-1]), float(jumps[:-1].max()), float(np.abs(first).max()) or 1.0
    closes = seam <= max(10 * elsewhere, DOUBTFUL_MISFIT * size)
    cure = "the data do not close: choose a period of theirs for the box, or data that vanish at its ends"
    told = f"across the seam the data jump by {seam / size:.1e} of their size, elsewhere by at most {elsewhere / size:.1e}"
    yield _found("seam", "agrees" if closes else "contradicts", told, cure)


def _ripples(case: Case) -> Iterator[Finding]:
    if not isinstance(grid_of(case.dataset), Grid):
        return
    first, last = (_finest_share(frame) for frame in case.frames[[0, -1]])
    fine = last <= max(FINEST_SHARE, 10 * first)
    cure = "give the scheme a viscosity in grid units, scheme.grid_viscosity, or a larger one"
    told = (
        f"the shortest third of the waves of the grid holds {last:.1e} of the squared field at the end, {first:.1e} at first"
    )
    yield _found("ripples", _sound(fine), told, cure)


def _finest_share(frame: Array) -> float:
    power = np.abs(np.fft.rfft(frame)) ** 2
    return float(power[2 * power.size // 3 :].sum() / (power.sum() or 1.0))


def _tolerance(case: Case) -> Iterator[Finding]:
    absolute, waves = case.settings["integrator"].get("atol"), outlines_of(case.dataset)
    if absolute is None:
        return
    lowest = min((wave.height for wave in waves), default=float(np.abs(case.frames[0]).max()))
    share = float(absolute) / lowest if lowest else np.inf
    allowed = case.rtol or 1e-6
    cure = "choose a smaller integrator.atol, or none, which makes it relative to the state"
    told = f"the absolute one is {share:.1e} of the lowest wave, the relative one is {allowed:g}"
    yield _found("tolerance", _judged(share, allowed, 1e-2), told, cure)


def _growth(case: Case) -> Iterator[Finding]:
    if case.simulation is None or not isinstance(case.simulation.grid, Grid):
        return
    grid, t_end = case.simulation.grid, float(case.dataset["t"][-1])
    rate = case.simulation.equation.fastest_growth(case.simulation.initial_state(), grid.spacing)
    if not rate:
        return
    exponent = rate * t_end
    told = f"the equation itself lets the shortest waves of this grid grow as exp({exponent:.3g})"
    yield _found("growth", _judged(exponent, 1.0, 10.0), told, "choose a coarser grid or an earlier end")


def _solver(case: Case) -> Iterator[Finding]:
    attributes = case.dataset.attrs
    if "solver_steps" not in attributes:
        return
    steps, failures, warnings = (int(attributes[f"solver_{name}"]) for name in ("steps", "failures", "warnings"))
    smooth = failures <= 0.1 * steps and not warnings
    first = f", the first: {attributes['solver_first_warning']}" if warnings else ""
    told = f"{steps} steps, {failures} repeated, {warnings} warnings{first}"
    yield _found("solver", _sound(smooth), told, "see whether a tighter tolerance gives the same")


CHECKS: tuple[Callable[[Case], Iterator[Finding]], ...] = (
    _ending,
    _conserved,
    _viscosity,
    _waves,
    _resolution,
    _ring,
    _seam,
    _ripples,
    _tolerance,
    _growth,
    _solver,
)
