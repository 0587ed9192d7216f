"""What can be said of the waves in one frame alone: their peaks, the exact waves nearest to them, and how fast they move."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.fitting import Fit, fit
from mol_compactons.analysis.peaks import peaks
from mol_compactons.chain.chain import GranularChain
from mol_compactons.equations.base import Equation
from mol_compactons.errors import require
from mol_compactons.grid import Grid, Lattice, ring_distance
from mol_compactons.results.reading import arranged, equation_of, field_names, ring_of
from mol_compactons.stencils import difference, stencils_of

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

RECOGNISED = 0.05
"""A peak is measured by the exact wave if the misfit is at most this: so far is a wave that has just left a collision. A width
that is wrong by 6 % gives as much, and a compacton of another exponent more, 0.09 and up for n up to 3."""

MINOR = 0.25
"""A peak lower than this part of a wave does not count as in its way, unless it is a wave that was there from the start."""

QUARTIC_REACH = 2.5
"""How far the points that a peak is measured by are from it, in spacings."""

FEWEST_MOVING = 5
"""Points around a peak without which its motion is not seen."""


@dataclass(frozen=True)
class Sighting:
    """A peak in a frame.

    Parameters
    ----------
    sign : {1, -1}
        Bright or dark.
    position, height : float
        Of the exact wave where it is recognised, else of the peak; the height is positive.
    width : float
        The width at half the height, of the peak.
    support : float
        The width of the exact wave where it is recognised, else twice the width at half the height.
    residual : float
        The misfit of the exact wave; NaN where none is known, or too few points are clear of other waves.
    motion : float or None
        The speed that the equation gives to the peak; None where it does not.
    family_speed : float
        The speed that belongs to the height, in the direction of the motion; NaN where no wave is known.
    """

    sign: int
    position: float
    height: float
    width: float
    support: float
    residual: float
    motion: float | None
    family_speed: float

    @property
    def recognised(self) -> bool:
        """Whether it is an exact wave of the equation as far as height and width are concerned."""
        return self.residual <= RECOGNISED

    @property
    def speed(self) -> float | None:
        """The speed that it has by what is seen in the frame."""
        return self.family_speed if self.recognised and math.isfinite(self.family_speed) else self.motion


@dataclass(frozen=True, eq=False)
class Frames:
    """The frames of a result, as waves are looked for in them.

    Parameters
    ----------
    name : str
        The field that is followed.
    times : array, shape (T,)
        The times.
    states : array, shape (T, components, N)
        The states.
    grid : Grid or Lattice
        The points, on a ring; beyond the ends of a chain there are empty sites, so that no wave comes round.
    equation : Equation or None
        The equation; None where its class is not loaded.
    is_chain : bool
        Whether the second component is the rate of the first.
    hidden : array of bool, shape (N,)
        The points that the result does not hold; the states are linear there.
    """

    name: str
    times: Array
    states: Array
    grid: Grid | Lattice
    equation: Equation | None
    is_chain: bool
    hidden: Mask

    def sees(self, place: float, reach: float) -> bool:
        """Whether the result holds all points that are not farther from a place."""
        return not self.hidden.any() or not self.hidden[np.abs(self.grid.offset(place)) <= reach].any()

    def look(self, index: int, least: float) -> list[Sighting]:
        """The peaks of a frame that are higher than the least."""
        found = []
        for sign in (1, -1):
            for place, height, width in zip(*peaks(self.states[index, 0], self.grid, sign, least), strict=True):
                bare = Sighting(sign, float(place), float(height), float(width), 2 * float(width), math.nan, None, math.nan)
                if self.sees(bare.position, QUARTIC_REACH * self.grid.spacing):
                    found.append(bare)
        if self.equation is None or not found:
            return found
        return [self._measured(index, peak, found) for peak in found]

    def _measured(self, index: int, peak: Sighting, all_peaks: Sequence[Sighting]) -> Sighting:
        """A peak with the exact wave nearest to it, if there is one, and its motion, where that wave does not tell."""
        fitted = self._fit(self.states[index, 0], peak, all_peaks)
        residual = math.nan if fitted is None else fitted.residual
        assert self.equation is not None
        both_ways = self.equation.two_way or self.is_chain
        motion = self._motion(index, peak) if both_ways or not residual <= RECOGNISED else None
        if fitted is not None and residual <= RECOGNISED:
            peak = replace(peak, position=fitted.position, height=fitted.height, support=fitted.shape.width)
        belongs = self.equation.solitary_speed(peak.height, peak.sign)
        family_speed = math.nan if belongs is None else belongs
        if both_ways:
            family_speed = math.copysign(family_speed, motion or 1.0)
        return replace(peak, residual=residual, motion=motion, family_speed=family_speed)

    def _fit(self, values: Array, peak: Sighting, all_peaks: Sequence[Sighting]) -> Fit | None:
        assert self.equation is not None
        excluded = self.hidden if self.hidden.any() else None
        for other in all_peaks:
            shape = None
            if other is not peak and other.height >= MINOR * peak.height:
                shape = self.equation.solitary_shape(other.height, other.sign)
            if shape is not None:
                under = np.abs(self.grid.offset(other.position)) < shape.width / 2
                excluded = under if excluded is None else excluded | under
        return fit(values, self.grid, self.equation, peak.sign, peak.position, peak.height, excluded)

    def _rates(self, index: int) -> Array | None:
        """What moves with the field at its speed: F of a one-way equation, v of a two-way one; of a chain the rate R_t."""
        state, equation = self.states[index], self.equation
        assert equation is not None
        if self.is_chain or equation.two_way:
            return state[1] if state.shape[0] > 1 else None
        if not equation.has_local_flux:
            return None
        derivative = partial(difference, stencils_of(2, self.grid.spacing))
        with np.errstate(all="ignore"):
            flux = equation.local_flux(float(self.times[index]), self.grid.coordinates, state, derivative)
        return np.asarray(flux, dtype=float)

    def _motion(self, index: int, peak: Sighting) -> float | None:
        """The speed c of a peak, from F = c u + const of a travelling wave, or from R_t = -V R' of one of a chain."""
        values, rates = self.states[index, 0], self._rates(index)
        if rates is None:
            return None
        around = np.abs(self.grid.offset(peak.position)) <= max(peak.width / 2, QUARTIC_REACH * self.grid.spacing)
        if np.count_nonzero(around) < FEWEST_MOVING or not np.isfinite(rates[around]).all():
            return None
        if self.is_chain:
            slope = (np.roll(values, -1) - np.roll(values, 1))[around] / (2 * self.grid.spacing)
            return -float(rates[around] @ slope) / float(slope @ slope) if slope.any() else None
        field, flux = values[around] - values[around].mean(), rates[around]
        return float(flux @ field) / float(field @ field) if field.any() else None


def frames_of(dataset: xr.Dataset) -> Frames:
    """The frames of a result, in whatever order and on however many of its points it holds them.

    Raises
    ------
    InputError
        If it is no result, holds no frame, has points that lie on no grid of its period, or values that are no numbers.
    """
    require(
        "simulation" in dataset.attrs and len(field_names(dataset)) > 0,
        "There is no field to follow waves in; give a result of run(), not a study or tracks.",
    )
    dataset = arranged(dataset)
    require(dataset.sizes["t"] > 0, "The result holds no frame; give one of a run that has begun.")
    names, equation = field_names(dataset), equation_of(dataset)
    grid, points = ring_of(dataset)
    states = np.stack([np.asarray(dataset[name].values, dtype=float) for name in names], axis=1)
    finite = np.isfinite(states).all(axis=(1, 2))
    require(
        bool(finite.all()),
        f"The result holds values that are no numbers, first at t = {dataset['t'].values[np.argmin(finite)]:g}; "
        "select the times before.",
    )
    states, hidden = _on_ring(states, points, grid.size)
    is_chain = "k" in dataset.dims
    name = names[0]
    if is_chain:
        ends = equation.ends if isinstance(equation, GranularChain) else "periodic"
        if name == "Q":
            require(
                grid.spacing == 1 and not hidden.any(),
                "Stresses are differences of neighbouring grains; give all grains of the chain.",
            )
            masses = equation.masses if isinstance(equation, GranularChain) else ()
            name, states = "R", _stresses(states, ends, masses or (1.0,))
            hidden = np.zeros(states.shape[-1], dtype=bool)
        hidden = np.concatenate([hidden, np.zeros(0 if ends == "periodic" else states.shape[-1], dtype=bool)])
        grid, states = _ring(grid, _without_gaps(states, equation), ends)
    return Frames(name, dataset["t"].values.astype(float), states, grid, equation, is_chain, hidden)


def _on_ring(states: Array, points: NDArray[np.intp], size: int) -> tuple[Array, Mask]:
    """States on all points of a ring, linear between those that are known, and which are not."""
    hidden = np.ones(size, dtype=bool)
    hidden[points] = False
    if not hidden.any():
        return states, hidden
    after = np.searchsorted(points, np.arange(size))
    left, right = points[after - 1], points[after % points.size]
    share = (np.arange(size) - left) % size / np.maximum((right - left) % size, 1)
    filled = (1 - share) * states[..., after - 1] + share * states[..., after % points.size]
    filled[..., points] = states
    return filled, hidden


def _stresses(states: Array, ends: str, masses: Sequence[float]) -> Array:
    """R_k = Q_(k-1) - Q_k and its rate from displacements and momenta, shape (T, 2, N)."""
    states = np.stack([states[:, 0], states[:, 1] / np.asarray(masses)], axis=1)
    first = {"periodic": states[..., -1:], "free": states[..., :1]}.get(ends, np.zeros_like(states[..., :1]))
    before = np.concatenate([first, states], axis=-1)
    after = np.concatenate([states, np.zeros_like(first)], axis=-1)
    stresses: Array = before - after
    return stresses if ends == "fixed" else stresses[..., :-1]


def _without_gaps(states: Array, equation: Equation | None) -> Array:
    """Stresses and rates of a chain, with none where grains have parted: there R is a distance."""
    if isinstance(equation, GranularChain) and not equation.compression:
        for sign in (1, -1):
            if not equation.law.force(np.array([float(sign)]), np.ones(1)).any():
                states = np.where(sign * states[:, :1] > 0, 0.0, states)
    return states


def _ring(grid: Grid | Lattice, states: Array, ends: str) -> tuple[Grid | Lattice, Array]:
    """A chain with two ends, with as many empty sites beyond them."""
    size = states.shape[-1]
    if ends == "periodic":
        return grid, states
    padded = np.concatenate([states, np.zeros_like(states)], axis=-1)
    if isinstance(grid, Lattice):
        return Lattice(size=2 * size), padded
    return Grid(length=2 * size * grid.spacing, size=2 * size, left=grid.left), padded


def nearest_step(place: float, later: Array, length: float) -> float:
    """From a place to the nearest of some later ones on a ring; 0 where there is none."""
    gone = ring_distance(later, place, length)
    return float(gone[np.argmin(np.abs(gone))]) if gone.size else 0.0
