"""Who is who from frame to frame: which peak is which wave, and which is a wave that was not there before."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.sighting import MINOR, Frames, Sighting, nearest_step
from mol_compactons.errors import require
from mol_compactons.grid import ring_distance
from mol_compactons.results.schema import WaveOutline

Array = NDArray[np.float64]

THRESHOLD = 0.05
"""Peaks lower than this, relative to the lowest wave at the start, are ripples."""

HIGH = 4 * THRESHOLD
"""Where no solitary wave is known, a peak lower than this part of the highest at the start is no wave."""

FARTHEST_MATCH = 3.5
"""A peak is taken for a wave if its distance from where the wave should be, in half-widths, and twice the logarithm of the
ratio of their heights add up to less than this: a wave may lose half its height in a collision, a ripple is no wave."""

NAMED_BY = 2.0
"""How much more heights count where peaks are to be shared out: waves leave a collision ahead of their flight or behind it,
and two of n = 3 hand on their heights over a distance of a width without ever being one."""

SPEED_FRAMES = 5
"""How many frames of free flight give the speed with which the next place is foretold."""

FEWEST_FRAMES = 3
"""Frames of free flight without which no speed is measured."""

PERSISTENCE = 5
"""In how many frames a new peak must have had the profile of an exact wave to be one; or, if it is high, seen at all while it
moved by half its width."""

ASTRAY = 0.25
"""How far the speed of a new wave may be from that of its height, relative to it. The crest of a ripple may have the profile
of a wave, but stands or goes the other way."""

LONGEST_ABSENCE = 3
"""For how many frames a new peak may be away before it is forgotten."""

UNSURE = 0.3
"""How wrong the speed may be that is read from one frame, relative to it."""


@dataclass
class Followed:
    """A wave, where it was seen, and what is known of it from its last frames of free flight, or of birth before any."""

    sign: int
    position: float
    speed: float
    height: float
    width: float
    t: float = 0.0
    doubt: float = 0.0
    from_data: bool = False
    from_start: bool = False
    has_been_free: bool = False
    seen: dict[int, Sighting] = field(default_factory=dict)
    places: dict[int, float] = field(default_factory=dict)
    flight: list[tuple[int, float, float]] = field(default_factory=list)

    def foretold(self, t: float) -> float:
        """Where free flight takes it."""
        return self.position + self.speed * (t - self.t)

    def take(self, index: int, t: float, sighting: Sighting, length: float) -> None:
        """Take note of a peak that is it; its position goes on growing where it comes round again."""
        expected = self.foretold(t)
        place = expected + float(ring_distance(np.array(sighting.position), expected, length))
        self.seen[index] = replace(sighting, position=place)
        if sighting.recognised and not self.from_data:
            self.width = sighting.support

    def remember(self, index: int, t: float) -> None:
        """Take note of a frame of free flight: of where it is, and how fast by its height or by its last places."""
        sighting = self.seen[index]
        if self.flight and self.flight[-1][0] != index - 1:
            self.flight = []
        self.flight = [*self.flight[1 - SPEED_FRAMES :], (index, t, sighting.position)]
        known = sighting.family_speed
        if sighting.recognised and math.isfinite(known):
            self.speed = known
        elif len(self.flight) >= FEWEST_FRAMES:
            _, times, places = np.array(self.flight).T
            self.speed = float(np.polyfit(times - t, places, 1)[0])
        self.t, self.position, self.height = t, sighting.position, sighting.height

    @property
    def first(self) -> int:
        """The first frame in which it was seen; 0 for one that never was."""
        return min(self.seen, default=0)


def _highest(states: Array) -> float:
    """The largest size of the first component."""
    return float(np.abs(states[:, 0]).max())


class Followers:
    """All waves of a result from frame to frame, the old ones and those that may become new ones."""

    def __init__(self, frames: Frames, outlines: Sequence[WaveOutline], least: float | None, newborn: bool) -> None:
        self.frames, self.newborn = frames, newborn
        self.highest, later = _highest(frames.states[:1]), _highest(frames.states)
        self.waves = [
            Followed(wave.sign, wave.center, wave.speed, wave.height, wave.width, from_data=True, has_been_free=True)
            for wave in outlines
        ]
        if not self.waves and self.highest > THRESHOLD * later:
            self.waves = self._from_peaks(least or HIGH * self.highest)
        if not self.waves:
            self.highest = later
        self.count_at_start = len(self.waves)
        for wave in self.waves:
            wave.from_start = True
        self.least = least or THRESHOLD * min((wave.height for wave in self.waves), default=self.highest)
        self.candidates: list[Followed] = []

    def _from_peaks(self, least: float) -> list[Followed]:
        """The peaks of the first frame, with their speeds from that frame or, where it does not tell, from the second."""
        first = self.frames.look(0, least)
        times, length = self.frames.times, self.frames.grid.length
        second = self.frames.look(min(1, len(times) - 1), least)
        waves = []
        for peak in first:
            wave = self._begun(peak, float(times[0]))
            if peak.speed is None and len(times) > 1:
                later = np.array([other.position for other in second if other.sign == peak.sign])
                moved = nearest_step(peak.position, later, length)
                wave.speed = moved / float(times[1] - times[0])
                wave.doubt = 2 * abs(moved) if abs(moved) < peak.width / 2 else length
            waves.append(wave)
        return waves

    def _begun(self, peak: Sighting, t: float) -> Followed:
        speed, step = peak.speed, float(np.diff(self.frames.times[:2]).sum())
        doubt = 0.0 if speed is None or peak.recognised else UNSURE * abs(speed) * step
        return Followed(peak.sign, peak.position, speed or 0.0, peak.height, peak.support, t, doubt)

    def run(self) -> list[Followed]:
        """Follow all through all frames."""
        for index, t in enumerate(self.frames.times):
            self._step(index, float(t))
        require(
            len(self.waves) > 0,
            "There is no wave to follow: the initial data hold no solitary wave, and no frame a peak that lasts.",
        )
        return self.waves

    def _step(self, index: int, t: float) -> None:
        peaks = self._matched(index, t, self.waves, self.frames.look(index, self.least))
        places = [wave.seen[index].position if index in wave.seen else wave.foretold(t) for wave in self.waves]
        free = clear(self.waves, np.array(places), np.array([wave.height for wave in self.waves]), self.frames)
        for wave, place, alone in zip(self.waves, places, free, strict=True):
            wave.places[index] = place
            if index in wave.seen and (alone or not wave.has_been_free):
                wave.remember(index, t)
                wave.has_been_free |= bool(alone)
        if self.newborn:
            self._look_for_new(index, t, self._matched(index, t, self.candidates, peaks), free)

    def _matched(self, index: int, t: float, waves: Sequence[Followed], peaks: Sequence[Sighting]) -> list[Sighting]:
        """Give each wave the peak that is most like it, and return the other peaks."""
        from scipy.optimize import linear_sum_assignment

        taken: set[int] = set()
        for sign in (1, -1):
            members = [wave for wave in waves if wave.sign == sign]
            numbers = [number for number, peak in enumerate(peaks) if peak.sign == sign]
            if not members or not numbers:
                continue
            foretold = np.array([wave.foretold(t) for wave in members])[:, None]
            reach = np.array([wave.width / 2 for wave in members])[:, None]
            before = np.array([wave.height for wave in members])[:, None]
            positions = np.array([peaks[number].position for number in numbers])
            heights = np.array([peaks[number].height for number in numbers])
            distance = ring_distance(positions, foretold, self.frames.grid.length)
            unlike = np.abs(np.log(heights / before))
            cost = np.abs(distance) / reach + 2 * unlike
            shared = linear_sum_assignment(np.minimum(cost + NAMED_BY * unlike, 10 * FARTHEST_MATCH))
            for row, column in zip(*shared, strict=True):
                if cost[row, column] < FARTHEST_MATCH:
                    members[row].take(index, t, peaks[numbers[column]], self.frames.grid.length)
                    taken.add(numbers[column])
        return [peak for number, peak in enumerate(peaks) if number not in taken]

    def _look_for_new(self, index: int, t: float, peaks: Sequence[Sighting], free: NDArray[np.bool_]) -> None:
        """Begin with the peaks that are nobody's, go on with those of before, and make waves of those that last."""
        length = self.frames.grid.length
        for candidate in self.candidates:
            if index in candidate.seen:
                candidate.remember(index, t)
                candidate.places[index] = candidate.position
            else:
                candidate.places[index] = candidate.foretold(t)
        hidden = [wave for wave, alone in zip(self.waves, free, strict=True) if index not in wave.seen and not alone]
        for peak in peaks:
            if all(abs(ring_distance(np.array(peak.position), w.foretold(t), length)) > w.width for w in hidden):
                new = self._begun(peak, t)
                new.take(index, t, peak, length)
                new.remember(index, t)
                new.places[index] = new.position
                self.candidates.append(new)
        grown = [candidate for candidate in self.candidates if self._lasts(candidate)]
        self.waves += grown
        self.candidates = [one for one in self.candidates if one not in grown and index - max(one.seen) <= LONGEST_ABSENCE]

    def _lasts(self, candidate: Followed) -> bool:
        """Whether a new peak has been a wave for long enough."""
        sightings = list(candidate.seen.values())
        exact = [index for index, sighting in candidate.seen.items() if sighting.recognised]
        if len(exact) >= PERSISTENCE and self._moves_as_it_should(candidate, exact):
            return True
        moved = abs(sightings[-1].position - sightings[0].position)
        high = min(sighting.height for sighting in sightings) >= HIGH * self.highest
        return len(sightings) >= PERSISTENCE and high and moved >= candidate.width / 2

    def _moves_as_it_should(self, candidate: Followed, exact: Sequence[int]) -> bool:
        """Whether a new peak went as far between some frames as its height demands."""
        places, speeds = np.array([(candidate.seen[index].position, candidate.seen[index].family_speed) for index in exact]).T
        gone, times = places[-1] - places[0], self.frames.times[list(exact)]
        due = float(np.mean(speeds)) * (times[-1] - times[0])
        return bool(abs(gone - due) <= ASTRAY * abs(due))


def clear(waves: Sequence[Followed], places: Array, heights: Array, frames: Frames) -> NDArray[np.bool_]:
    """Which waves have their support, all of it known, clear of others; NaN for a place that is not known.

    Those born later that are much lower do not count: else a tall wave would not be clear of its own ripples.
    """
    halves = np.array([wave.width / 2 for wave in waves])
    distance = np.abs(ring_distance(places[:, None], places, frames.grid.length))
    minor = (heights < MINOR * heights[:, None]) & ~np.array([wave.from_start for wave in waves], dtype=bool)
    apart = (distance >= halves[:, None] + halves) | np.isnan(distance) | minor
    np.fill_diagonal(apart, True)
    seen = np.array([frames.sees(place, half) for place, half in zip(places, halves, strict=True)], dtype=bool)
    return np.asarray(apart.all(axis=1) & seen)
