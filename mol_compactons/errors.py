"""The two ways in which a run can go wrong: bad input, and an integrator that gives up."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr


class InputError(ValueError):
    """A value that the program cannot accept.

    The message is one sentence: the value, what is allowed, what to do.
    """


class IntegrationError(RuntimeError):
    """The time integrator could not go on.

    Parameters
    ----------
    message : str
        One sentence: what happened and the cure.
    t : float
        The last time that was reached.
    dataset : xarray.Dataset, optional
        The frames up to there.
    """

    def __init__(self, message: str, t: float, dataset: xr.Dataset | None = None) -> None:
        super().__init__(message)
        self.t = t
        self.dataset: Any = dataset

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle without a call of `__init__`, which unpickling makes with the message alone; a subclass may have its own."""
        return _remade, (type(self), self.args), self.__dict__


def _remade(kind: type[IntegrationError], arguments: tuple[Any, ...]) -> IntegrationError:
    """An error as it was before it was pickled, but for its attributes."""
    return kind.__new__(kind, *arguments)


@contextmanager
def within_numbers(what: str) -> Iterator[None]:
    """Say in one sentence that what is computed inside leaves the range of numbers.

    Arrays do not warn inside: whoever computes them looks whether they are finite.

    Parameters
    ----------
    what : str
        What is computed.

    Raises
    ------
    InputError
        If a division by zero or an overflow is met.
    """
    try:
        with np.errstate(all="ignore"):
            yield
    except ArithmeticError as error:
        raise InputError(
            f"{what} leaves the range of numbers ({error}); choose speeds, exponents and coefficients nearer to 1."
        ) from None


LONGEST_SHOWN = 80
"""How much of a value a sentence shows."""


def shown(value: object) -> str:
    """A value as a sentence quotes it: not above `LONGEST_SHOWN` signs, also where Python writes no number as long."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):
        return f"a {type(value).__name__} too large to be written"
    return text if len(text) < LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}..."


def require(condition: bool, message: str) -> None:
    """Raise `InputError` with `message` unless `condition` holds.

    Parameters
    ----------
    condition : bool
        What must hold.
    message : str
        One sentence: the value, what is allowed, what to do.

    Raises
    ------
    InputError
        If it does not hold.
    """
    if not condition:
        raise InputError(message)
