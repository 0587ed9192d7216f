"""Room for intermediate results that no two threads share."""

from __future__ import annotations

import threading
from itertools import accumulate
from typing import Any

import numpy as np
from numpy.typing import NDArray


class Workspace(threading.local):
    """Arrays for intermediate results, other ones in each thread, made when a thread first asks for them.

    A kernel that has one may be called from several threads at a time.

    Parameters
    ----------
    *lengths : int
        The length of each array.

    Examples
    --------
    >>> flux, slope = Workspace(3, 2).arrays
    >>> flux.shape, slope.shape
    ((3,), (2,))
    """

    def __init__(self, *lengths: int) -> None:
        self._lengths = lengths
        ends = list(accumulate(lengths))
        self.arrays: tuple[NDArray[np.float64], ...] = tuple(np.split(np.empty(ends[-1]), ends[:-1]))

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy has room of its own."""
        return type(self), self._lengths
