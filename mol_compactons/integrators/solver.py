"""One solver of scikit-sundae: begun, stepped, listened to, and freed."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

from mol_compactons.runtime.capture import Messages


class Solver:
    """A solver of scikit-sundae, and what it says.

    Parameters
    ----------
    make : callable
        Returns a solver of scikit-sundae.
    fragile : bool
        Whether it must not be freed before it has factored a matrix: SuperLU_MT crashes then.
    """

    def __init__(self, make: Callable[[], Any], fragile: bool) -> None:
        self._messages = Messages()
        with self._messages.heard():
            self._solver = make()
        self._fragile = fragile

    def begin(self, t: float, *start: Any) -> None:
        """Begin at a time with a state, and with its rate where the solver asks for it."""
        if self._fragile:
            ctypes.pythonapi.Py_IncRef(ctypes.py_object(self._solver))
        with self._messages.heard(), self._messages.logged():
            self._solver.init_step(t, *start)

    def step(self, t: float, method: str) -> Any:
        """One step towards t ("onestep"), or to t and back by interpolation ("normal")."""
        with self._messages.heard():
            result = self._solver.step(t, method=method)
        if self._fragile and result.status >= 0:
            ctypes.pythonapi.Py_DecRef(ctypes.py_object(self._solver))
            self._fragile = False
        return result

    def messages(self) -> list[str]:
        """What it has said so far, line by line; complete when it is freed."""
        return self._messages.lines()

    def free(self) -> None:
        """Free what SUNDIALS holds; no step may follow."""
        if not self._fragile:
            # The frames of an error that it raised hold the solver, but not what is behind it.
            vars(self._solver).clear()
