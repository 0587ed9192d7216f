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
from mol_compactons.studies.store import Row

COMPARISONS: dict[str, Callable[[float, float], bool]] = {"<": operator.lt, ">": operator.gt}

_COMPARED = re.compile(r"\s*([A-Za-z_]\w*)\s*(?:\[(\d+)\])?\s*([<>])\s*([-+.\deE]+)\s*")


@dataclass(frozen=True)
class Criterion:
    """What is asked of a member: whether it ran to its end, or how one of its quantities compares with a number.

    Parameters
    ----------
    quantity : str
        The name of a quantity in the table; "status" for whether it is complete.
    wave : int
        Of which wave, where it is one of waves.
    comparison : {"<", ">"}
        How it is compared.
    threshold : float
        With what.
    """

    quantity: str = "status"
    wave: int = 0
    comparison: str = "<"
    threshold: float = math.nan

    @classmethod
    def from_text(cls, text: str) -> Criterion:
        """The outcome that a text asks for: "status", or as "height_after[1] < 0.9".

        Raises
        ------
        InputError
            If it is neither.
        """
        if text.strip() == "status":
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
        if self.quantity == "status":
            return self.quantity
        return f"{self.quantity}{f'[{self.wave}]' if self.wave else ''} {self.comparison} {self.threshold:g}"

    def of(self, row: Row) -> str:
        """How a member came out.

        Raises
        ------
        InputError
            If it has no such quantity.
        """
        if row["status"] != COMPLETE:
            return "failed" if row["status"] == "failed" else "stopped"
        if self.quantity == "status":
            return COMPLETE
        known = row["quantities"]
        require(
            self.quantity in known,
            f"The outcome asks for {self.quantity}, which members do not have; they have {', '.join(sorted(known))}.",
        )
        values = np.atleast_1d(known[self.quantity])
        value = float(values[self.wave]) if self.wave < values.size else math.nan
        if math.isnan(value):
            return "unknown"
        return "yes" if COMPARISONS[self.comparison](value, self.threshold) else "no"
