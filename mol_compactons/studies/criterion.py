"""How a member of a study came out, in a word: what a refinement compares."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mol_compactons.errors import InputError, require, shown
from mol_compactons.results.schema import COMPLETE
from mol_compactons.studies.store import FAILED, Row

STATUS, UNKNOWN = "status", "unknown"

COMPARISONS: dict[str, Callable[[float, float], bool]] = {"<": operator.lt, ">": operator.gt}

_COMPARED = re.compile(r"\s*([A-Za-z_]\w*)\s*(?:\[(\d+)\])?\s*([<>])\s*([-+.\deE]+)\s*")


@dataclass(frozen=True)
class Criterion:
    """What is asked of a member: whether it ran to its end, or how one of its quantities compares with a number.

    Parameters
    ----------
    quantity : str
        The name of a quantity in the table; `STATUS` for whether it is complete.
    wave : int
        Of which wave, where it is one of waves.
    comparison : {"<", ">"}
        How it is compared.
    threshold : float
        With what; None for the status.

    Raises
    ------
    InputError
        If there is nothing to compare with, or no such comparison.
    """

    quantity: str = STATUS
    wave: int = 0
    comparison: str = "<"
    threshold: float | None = None

    def __post_init__(self) -> None:
        require(self.comparison in COMPARISONS, f"comparison = {self.comparison!r} must be < or >.")
        require(self.wave >= 0, f"wave = {self.wave} must not be negative; the first is 0.")
        compared = self.threshold is not None and math.isfinite(self.threshold)
        require(
            compared or (self.quantity == STATUS and self.threshold is None),
            f"{self.quantity} is compared with {self.threshold}; give a number.",
        )

    @classmethod
    def from_text(cls, text: str) -> Criterion:
        """The outcome that a text asks for: "status", or as "height_after[1] < 0.9".

        Raises
        ------
        InputError
            If it is neither.
        """
        if text.strip() == STATUS:
            return cls()
        found = _COMPARED.fullmatch(text)
        try:
            if found:
                return cls(found[1], int(found[2] or 0), found[3], float(found[4]))
        except ValueError:
            pass
        raise InputError(f"The outcome {shown(text)} is not understood; write status, or as momentum_drift > 0.01.")

    @property
    def told(self) -> str:
        """The same in a text."""
        if self.quantity == STATUS:
            return self.quantity
        return f"{self.quantity}{f'[{self.wave}]' if self.wave else ''} {self.comparison} {self.threshold}"

    def is_known(self, row: Row) -> bool:
        """Whether a member has what is asked for."""
        return self.quantity == STATUS or self.quantity in row["quantities"]

    def of(self, row: Row) -> str:
        """How a member came out; "unknown" where it does not have what is asked for, or that is NaN."""
        if row["status"] != COMPLETE:
            return FAILED if row["status"] == FAILED else "stopped"
        if self.quantity == STATUS:
            return COMPLETE
        values = np.atleast_1d(row["quantities"].get(self.quantity, math.nan))
        value = float(values[self.wave]) if self.wave < values.size else math.nan
        if math.isnan(value) or self.threshold is None:
            return UNKNOWN
        return "yes" if COMPARISONS[self.comparison](value, self.threshold) else "no"
