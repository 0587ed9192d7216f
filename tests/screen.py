"""A terminal that only a test looks at."""

from __future__ import annotations

import fcntl
import os
import struct
import sys
import termios
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress


@contextmanager
def terminal() -> Iterator[Callable[[], str]]:
    """Standard error is a terminal of 100 columns; what is called says what came to it since the last time."""
    keyboard, screen = os.openpty()
    fcntl.ioctl(screen, termios.TIOCSWINSZ, struct.pack("4H", 24, 100, 0, 0))
    os.set_blocking(keyboard, False)
    before = sys.stderr

    def seen() -> str:
        sys.stderr.flush()
        told = b""
        with suppress(BlockingIOError, OSError):
            while part := os.read(keyboard, 10_000):
                told += part
        return told.decode()

    try:
        with os.fdopen(screen, "w") as sys.stderr:
            yield seen
    finally:
        sys.stderr = before
        os.close(keyboard)
