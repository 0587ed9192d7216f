"""A family of runs whose answer is known, and what a study of it says beside that answer."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mol_compactons import Compacton, Equation, Family, Grid, Lattice, Simulation, converge
from mol_compactons.studies.judgement import CONVERGED
from mol_compactons.waves.base import LocalizedWave

if TYPE_CHECKING:
    import xarray as xr

ROUND_OFF = 1e-12
"""A distance from the truth up to this, relative to the scale of the quantity, is no fault of a bar."""


@dataclass(frozen=True)
class Truth:
    """What a quantity is.

    Parameters
    ----------
    value : float
        Its exact value, or that of a reference.
    uncertainty : float
        How far the reference may be from the exact value; 0 for what is known exactly.
    """

    value: float
    uncertainty: float = 0.0


Trap = Callable[["xr.DataTree"], str]
"""What of a trap is seen in a study, in words; raises `NoTrapError` where it is not there."""


class NoTrapError(Exception):
    """A family does not show the trap that it was made for, and so says nothing of it."""


@dataclass(frozen=True)
class Known:
    """A simulation, the family that is made of it, and what is known of its outcome.

    Parameters
    ----------
    simulation : Simulation
        What the family is made of.
    family : Family
        What is varied.
    truths : mapping of str to Truth
        By quantity, as the summary of a study calls it.
    conserved : tuple of str
        What the equation conserves, so that its drift is 0; "all" for whatever the results report.
    trap : callable, optional
        Called with the study; sees to it that the trap is there, for which the family was made.
    """

    simulation: Simulation
    family: Family = field(default_factory=Family)
    truths: Mapping[str, Truth] = field(default_factory=dict)
    conserved: tuple[str, ...] = ("all",)
    trap: Trap | None = None

    def truth(self, quantity: str) -> Truth | None:
        """What is known of a quantity; None for nothing."""
        of, _, what = quantity.rpartition(" ")
        if what == "drift" and (of in self.conserved or "all" in self.conserved):
            return Truth(0.0)
        return self.truths.get(quantity)


@dataclass(frozen=True)
class Row:
    """A quantity of a study beside its truth; bar, distance and scale in its units."""

    family: str
    limit: str
    quantity: str
    verdict: str
    value: float
    bar: float
    truth: float
    uncertainty: float
    scale: float
    accuracy: float
    reason: str

    @property
    def distance(self) -> float:
        """|value - truth|, less what the truth itself leaves open; infinite where there is no value."""
        apart = abs(self.value - self.truth) - self.uncertainty
        return np.inf if np.isnan(apart) else max(apart, 0.0)

    @property
    def ratio(self) -> float:
        """The distance in bars; 0 where it is round-off."""
        if self.distance <= ROUND_OFF * self.scale:
            return 0.0
        return self.distance / self.bar if self.bar > 0 else np.inf

    @property
    def holds(self) -> bool:
        """Whether the bar holds the truth."""
        return self.ratio <= 1

    @property
    def is_accurate(self) -> bool:
        """Whether the value is as near to the truth as the family asked."""
        return self.distance <= self.accuracy * self.scale

    @property
    def is_false(self) -> bool:
        """Whether it was called converged, and its bar does not hold the truth."""
        return self.verdict == CONVERGED and not self.holds

    @property
    def is_right(self) -> bool:
        """Whether it was called converged with a bar that holds the truth."""
        return self.verdict == CONVERGED and self.holds

    @property
    def is_unrecognised(self) -> bool:
        """Whether it is accurate, and was not called converged."""
        return self.is_accurate and self.verdict != CONVERGED


def rows(name: str, known: Known, notice: Callable[[str], None] = lambda line: None) -> list[Row]:
    """Run a family, and put what its study says of each quantity beside the truth; quantities without one are left out.

    Parameters
    ----------
    name : str
        That of the family.
    known : Known
        The family.
    notice : callable
        Called with what is seen of its trap.

    Raises
    ------
    NoTrapError
        If the trap is not there for which it was made.
    """
    study = converge(known.simulation, known.family)
    if known.trap is not None:
        notice(known.trap(study))
    summary = study["summary"].to_dataset()
    return [
        _row(name, summary.sel(limit=limit, quantity=quantity), truth, known.family.accuracy)
        for limit in summary["limit"].values
        for quantity in summary["quantity"].values
        if (truth := known.truth(str(quantity))) is not None
    ]


def _row(family: str, cell: xr.Dataset, truth: Truth, accuracy: float) -> Row:
    return Row(
        family=family,
        limit=str(cell["limit"].item()),
        quantity=str(cell["quantity"].item()),
        verdict=str(cell["verdict"].item()),
        value=float(cell["value"]),
        bar=float(cell["error"]),
        truth=truth.value,
        uncertainty=truth.uncertainty,
        scale=float(cell["scale"]),
        accuracy=accuracy,
        reason=str(cell["reason"].item()),
    )


def exact_norm(simulation: Simulation, family: Family) -> float:
    """The L2 norm, on the coarsest grid, of the first component of waves that move freely, at the end."""
    coarsest = min(family.completed(simulation).sizes)
    grid = simulation.grid if isinstance(simulation.grid, Lattice) else replace(simulation.grid, size=coarsest)
    state = sum(wave.values(simulation.equation, grid, simulation.t_end)[0] for wave in simulation.initial)
    return float(np.linalg.norm(state) * np.sqrt(grid.spacing))


def free_waves(simulation: Simulation, family: Family) -> dict[str, Truth]:
    """What is known of localized waves that have not met: all of them move at their speed, as they are."""
    truths = {"profile": exact_norm(simulation, family), "mass left": 0.0, "momentum left": 0.0, "height left": 0.0}
    waves = [wave for wave in simulation.initial if isinstance(wave, LocalizedWave)]
    for index, wave in enumerate(waves):
        truths |= {
            f"height {index}": wave.outline(simulation.equation)[0],
            f"speed {index}": wave.speed,
            f"position {index}": wave.center + wave.speed * simulation.t_end,
        }
    return {quantity: Truth(value) for quantity, value in truths.items()}


def of_free_waves(simulation: Simulation, family: Family | None = None) -> Known:
    """A family of compactons that move freely."""
    family = family or Family()
    return Known(simulation, family, free_waves(simulation, family))


def one(
    equation: Equation, length: float, size: int, t_end: float, speed: float = 1.0, sign: int = 1, **settings: Any
) -> Simulation:
    """One compacton, its centre a third of the box from the left end; `settings` are others of the `Simulation`."""
    wave = Compacton(speed=speed, center=length / 3, sign=sign)
    return Simulation(equation, Grid(length, size), [wave], t_end, **({"frames": 31} | settings))
