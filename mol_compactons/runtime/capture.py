"""What C libraries print, as lines."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import tempfile
from collections.abc import Iterator


@contextlib.contextmanager
def captured_lines() -> Iterator[list[str]]:
    """Keep what is printed inside, by C on file descriptor 2 and by Python on stdout, from the screen.

    Yields
    ------
    list of str
        Empty at first; after the block, even one that raises, its lines, stripped, without empty ones.
    """
    lines: list[str] = []
    sys.stderr.flush()
    with tempfile.TemporaryFile() as heard, contextlib.redirect_stdout(io.StringIO()) as printed:
        saved = os.dup(2)
        try:
            os.dup2(heard.fileno(), 2)
            yield lines
        finally:
            os.dup2(saved, 2)
            os.close(saved)
            heard.seek(0)
            text = heard.read().decode(errors="replace") + printed.getvalue()
            lines += [line.strip() for line in text.splitlines() if line.strip()]
