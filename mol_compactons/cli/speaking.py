"""What the command line says: results, which must arrive, and remarks, which nobody needs to hear."""

from __future__ import annotations

import contextlib
import logging
import sys
from collections.abc import Iterator
from typing import TextIO

from mol_compactons.errors import InputError
from mol_compactons.progress import beside_bars

LONGEST_SENTENCE = 400
"""A complaint is cut in its middle to this length."""


class ListenerLostError(Exception):
    """What a command was asked to print could not be printed."""


def tell(*lines: str) -> None:
    """Print what a command was asked for.

    Raises
    ------
    ListenerLostError
        If nobody listens any more.
    InputError
        If standard output is closed, or cannot take it.
    """
    if sys.stdout is None:
        raise InputError("Standard output is closed, so that nothing can be printed; leave it open.")
    try:
        _write(sys.stdout, lines)
    except BrokenPipeError:
        raise ListenerLostError from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"Standard output cannot be written ({reason}); send it to another place.") from None


def remark(*lines: str) -> None:
    """Print on standard output what is not the result of a command; that nobody listens changes nothing."""
    if sys.stdout is not None:
        with contextlib.suppress(OSError, ValueError):
            _write(sys.stdout, lines)


def complain(sentence: str) -> None:
    """Print one sentence about what went wrong on standard error, if somebody listens there."""
    if sys.stderr is not None:
        # Escapes are longer than what they stand for, so that they come before the cut.
        sentence = printable(" ".join(sentence.splitlines()), getattr(sys.stderr, "encoding", None) or "utf-8")
        if len(sentence) > LONGEST_SENTENCE:
            half = LONGEST_SENTENCE // 2 - 3
            sentence = f"{sentence[:half]} ... {sentence[-half:]}"
        with contextlib.suppress(OSError, ValueError):
            _write(sys.stderr, [f"mol-compactons: {sentence}"])


@contextlib.contextmanager
def logging_to_stderr(verbosity: int) -> Iterator[None]:
    """Show what the package logs on standard error: nothing for 0, what begins and ends for 1, checkpoints too for 2."""
    if not verbosity:
        yield
        return
    package, handler = logging.getLogger("mol_compactons"), _Handler()
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    before = package.level
    package.setLevel(logging.INFO if verbosity == 1 else logging.DEBUG)
    package.addHandler(handler)
    try:
        yield
    finally:
        package.removeHandler(handler)
        package.setLevel(before)


class _Handler(logging.Handler):
    """Writes to standard error, if somebody listens there."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write one line."""
        if sys.stderr is not None:
            with contextlib.suppress(OSError, ValueError), beside_bars():
                _write(sys.stderr, [" ".join(self.format(record).splitlines())])


def _write(stream: TextIO, lines: tuple[str, ...] | list[str]) -> None:
    for line in lines:
        stream.write(printable(line, getattr(stream, "encoding", None) or "utf-8") + "\n")
    stream.flush()


def printable(text: str, encoding: str) -> str:
    """A text with control characters, and what an encoding has not, as escapes: no title speaks to the terminal."""
    safe = "".join(c if c == "\n" or c.isprintable() or c == " " else c.encode("unicode_escape").decode() for c in text)
    return safe.encode(encoding, "backslashreplace").decode(encoding)
