"""Signals that ask a run to end, answered between two steps and never inside a solver."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""The signals that end a run in order."""


class Interrupted(KeyboardInterrupt):
    """A signal asked the run to end.

    Parameters
    ----------
    number : int
        Which.
    """

    def __init__(self, number: int) -> None:
        super().__init__(f"signal {number}")
        self.number = number


@contextmanager
def stopping_on_signals(report: Callable[[float], None]) -> Iterator[Callable[[float], None]]:
    """A report that raises `Interrupted` after a signal that ends a run; what is ignored, as under nohup, stays ignored."""
    if threading.current_thread() is not threading.main_thread():
        yield report
        return
    caught: list[int] = []
    before = {}
    for number in ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            before[number] = signal.signal(number, lambda number, _: caught.append(number))

    def watch(t: float) -> None:
        report(t)
        if caught:
            raise Interrupted(caught[0])

    try:
        yield watch
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
