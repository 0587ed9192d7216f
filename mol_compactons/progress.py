"""How far a piece of work is, shown where somebody looks: in a terminal, in a notebook, or in the log of a batch job."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, Protocol, TextIO

from mol_compactons.errors import require, shown

VARIABLE = "MOL_COMPACTONS_PROGRESS"
"""The variable of the environment that says whether progress is shown where a call does not say so."""

ANSWERS = {"1": True, "yes": True, "true": True, "on": True, "0": False, "no": False, "false": False, "off": False}
"""What it may say."""

LEAST_SECONDS = 10.0
MOST_SECONDS = 300.0
"""Lines of a log are at least so far apart; when a tenth more is done, or so many seconds have passed, there is another."""

NOT_SHOWN = (OSError, ValueError, AttributeError)
"""What a stream raises that is closed, full or no stream; work goes on all the same."""

_is_shown: ContextVar[bool] = ContextVar("_is_shown", default=False)
"""Whether this is a part of some work whose progress is shown."""


@dataclass(frozen=True)
class Wording:
    """How progress is told.

    Parameters
    ----------
    bar : str
        What stands behind a bar, in the terms of tqdm.
    line : str
        What a line of a log says, with ``{done}`` and ``{total}``.
    """

    bar: str
    line: str


TIME = Wording("t = {n:.4g} / {total:.4g}, {rate_fmt}, {remaining} left", "t = {done:.4g} of {total:.4g}")
MEMBERS = Wording("{n:.0f} / {total:.0f} members, {remaining} left{postfix}", "{done:.0f} of {total:.0f} members")
PICTURES = Wording("{n:.0f} / {total:.0f} pictures, {remaining} left", "{done:.0f} of {total:.0f} pictures")


class Show(Protocol):
    """Shows how far the work is."""

    def __call__(self, done: float, total: float | None = None, note: str = "") -> None:
        """Show how much is done; of how much, where that has changed; and a word beside it."""


def show_nobody(done: float, total: float | None = None, note: str = "") -> None:
    """The `Show` of work that nobody watches."""


class _Display(Protocol):
    def show(self, done: float, total: float, note: str) -> None: ...

    def close(self) -> None: ...


@contextmanager
def showing_progress(total: float, wording: Wording, wanted: bool | None = None) -> Iterator[Show]:
    """A function that shows how far the work inside is; the display appears with its first call, and is gone at the end.

    Work inside other work whose progress is shown shows nothing of its own.

    Parameters
    ----------
    total : float
        How much there is to do.
    wording : Wording
        How it is told.
    wanted : bool, optional
        Whether it is shown. By default what the variable ``MOL_COMPACTONS_PROGRESS`` says, and without it only in a notebook
        or an interactive interpreter.

    Raises
    ------
    InputError
        If the variable has no value that is understood.
    """
    if _is_shown.get() or not _is_wanted(wanted) or sys.stderr is None:
        yield show_nobody
        return
    display: _Display | None = None

    def show(done: float, total: float | None = total, note: str = "") -> None:
        nonlocal display
        with contextlib.suppress(*NOT_SHOWN):
            whole = whole_before if total is None else total
            display = display or _display(done, whole, wording)
            display.show(done, whole, note)

    whole_before = total
    token = _is_shown.set(True)
    try:
        yield show
    finally:
        _is_shown.reset(token)
        if display:
            with contextlib.suppress(*NOT_SHOWN):
                display.close()


def _is_wanted(wanted: bool | None) -> bool:
    said = os.environ.get(VARIABLE, "")
    require(not said or said.lower() in ANSWERS, f"{VARIABLE} = {shown(said)} must be one of {', '.join(ANSWERS)}.")
    if wanted is not None:
        return wanted
    return ANSWERS[said.lower()] if said else hasattr(sys, "ps1")


def _display(done: float, total: float, wording: Wording) -> _Display:
    if _in_notebook() or sys.stderr.isatty():
        return Bar(done, total, wording)
    return Lines(done, wording, sys.stderr)


def _in_notebook() -> bool:
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return type(shell).__name__ == "ZMQInteractiveShell"


class Bar:
    """A bar of tqdm: in a notebook that of ipywidgets, if that is installed, otherwise one of signs.

    Parameters
    ----------
    done, total : float
        How much is done at first, which counts for no rate, and how much there is to do.
    wording : Wording
        How it is told.
    """

    def __init__(self, done: float, total: float, wording: Wording) -> None:
        layout = "{percentage:3.0f}%|{bar}| " + wording.bar
        self._bar: Any = _kind_of_bar()(
            total=total, initial=done, unit="t", bar_format=layout, leave=False, dynamic_ncols=True
        )

    def show(self, done: float, total: float, note: str) -> None:
        """Move it."""
        self._bar.total = total
        if note:
            self._bar.set_postfix_str(note, refresh=False)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Take it away."""
        self._bar.close()


def _kind_of_bar() -> Any:
    if _in_notebook():
        with contextlib.suppress(ImportError):
            import ipywidgets  # noqa: F401  # without it tqdm's own raises when it is too late
            from tqdm.notebook import tqdm as widget

            return widget
    from tqdm import tqdm

    return tqdm


@contextmanager
def beside_bars() -> Iterator[None]:
    """While a line is printed, bars step aside."""
    from tqdm import tqdm

    with tqdm.external_write_mode():
        yield


class Lines:
    """A line now and then, for the log of a batch job; short work is silent.

    Parameters
    ----------
    done : float
        How much is done at first.
    wording : Wording
        How it is told.
    stream : text stream
        Where to.
    clock : callable, optional
        Tells seconds.
    """

    def __init__(self, done: float, wording: Wording, stream: TextIO, clock: Callable[[], float] = time.monotonic) -> None:
        self._wording, self._stream, self._clock = wording, stream, clock
        self._first = self._last = done
        self._began = self._spoke = clock()

    def show(self, done: float, total: float, note: str) -> None:
        """Say it, if it is time to."""
        now = self._clock()
        waited = now - self._spoke
        if waited < LEAST_SECONDS or (done - self._last < total / 10 and waited < MOST_SECONDS):
            return
        self._last, self._spoke = done, now
        left = (now - self._began) * (total - done) / (done - self._first) if done > self._first else None
        told = f"{self._wording.line.format(done=done, total=total)}, {100 * done / total:.0f} %"
        told += "" if left is None else f", about {in_words(left)} left"
        self._stream.write(f"mol-compactons: {told}{f', {note}' if note else ''}\n")
        self._stream.flush()

    def close(self) -> None:
        """Nothing is to be taken away."""


def in_words(seconds: float) -> str:
    """A time in the unit that suits it.

    Examples
    --------
    >>> in_words(75.2), in_words(4000), in_words(200000)
    ('75 s', '67 min', '56 h')
    """
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.0f} h"
