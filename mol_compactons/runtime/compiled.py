"""Compilation of kernels by numba, kept on disk where there is a place for it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar, cast

from numba import njit
from numba.core.event import Listener, install_listener

Kernel = TypeVar("Kernel", bound=Callable[..., Any])


def compiled(function: Kernel) -> Kernel:
    """Compile a function, with numpy's rules for division by zero.

    Its machine code is cached on disk unless no folder can be written, as in some containers.
    """
    try:
        return cast(Kernel, njit(cache=True, error_model="numpy")(function))
    except RuntimeError:
        return cast(Kernel, njit(error_model="numpy")(function))


class _FirstCompilation(Listener):
    """Calls a function when the first compilation begins."""

    def __init__(self, announce: Callable[[], None]) -> None:
        self._announce: Callable[[], None] | None = announce

    def on_start(self, event: Any) -> None:
        """A compilation begins."""
        if self._announce:
            self._announce()
            self._announce = None

    def on_end(self, event: Any) -> None:
        """A compilation ends."""


@contextmanager
def announcing_compilation(announce: Callable[[], None]) -> Iterator[None]:
    """Call a function, once, when inside something must be compiled that is not in the cache on disk."""
    with install_listener("numba:compile", _FirstCompilation(announce)):
        yield
