"""The command line as a process of its own: its streams, and interrupts while it loads, which takes a second."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType

LAST_STREAM = 2
"""The number of standard error."""

LOADING_INTERRUPTED = b"mol-compactons: interrupted; nothing was written.\n"


def program() -> int:
    """The command line as a process of its own, whose streams may be closed, full or without a listener."""
    _fill_missing_descriptors()
    heeded = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if heeded:
        signal.signal(signal.SIGINT, _leave)
    from mol_compactons.cli.parser import main

    if heeded:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    status = main()
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        try:
            if stream is not None:
                stream.flush()
        except (OSError, ValueError):
            # Python would try again at its end, and call that a failure.
            setattr(sys, name, None)
    return status


def _leave(number: int, frame: FrameType | None) -> None:
    """End at once: an exception would be lost where a library that is being loaded catches all of them."""
    try:
        os.write(LAST_STREAM, LOADING_INTERRUPTED)
    finally:
        os._exit(128 + number)


def _fill_missing_descriptors() -> None:
    """Let no file take the number of a standard stream that is closed, to which libraries print."""
    while (number := os.open(os.devnull, os.O_RDWR)) <= LAST_STREAM:
        pass
    os.close(number)
