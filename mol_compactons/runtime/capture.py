"""What SUNDIALS and scikit-sundae say, collected without touching the streams of the process.

The logger of a solver of SUNDIALS writes warnings to C's stdout, unless variables of the environment name a file at the moment
when the solver is made: they are set for that moment only. Errors are printed by scikit-sundae, with the `print` that it finds
when it is imported: it is imported so that it finds one which first asks whether its thread listens. Where somebody else has
imported it before, its errors go to stdout as they would without us.
"""

from __future__ import annotations

import builtins
import contextlib
import os
import sys
import tempfile
import threading
import warnings
import weakref
from collections.abc import Iterator
from typing import IO, Any

LOG_VARIABLES = ("SUNLOGGER_ERROR_FILENAME", "SUNLOGGER_WARNING_FILENAME")

NEEDLESS_WARNING = "Custom sparse Jacobian approximation"
"""How the warning begins that a Jacobian is used rather than the pattern that it was given with."""

_print = print

_changing_the_environment = threading.RLock()
if hasattr(os, "register_at_fork"):
    # A process forked meanwhile would keep the variables, and wait for the lock for ever.
    os.register_at_fork(
        before=_changing_the_environment.acquire,
        after_in_parent=_changing_the_environment.release,
        after_in_child=_changing_the_environment.release,
    )


class _Listener(threading.local):
    """Where lines go that are said in a thread; None where nobody listens."""

    lines: list[str] | None = None


_listener = _Listener()


def _say(*values: Any, **options: Any) -> None:
    """The `print` of scikit-sundae."""
    if _listener.lines is None:
        _print(*values, **options)
    else:
        _listener.lines += [line.strip() for line in " ".join(map(str, values)).splitlines() if line.strip()]


def _warn(message: str, category: type[Warning] | None = None) -> None:
    """The `warn` of scikit-sundae: a filter of warnings would be one for all threads."""
    if _listener.lines is None or not message.startswith(NEEDLESS_WARNING):
        warnings.warn(message, category, stacklevel=2)


def import_sundae() -> Any:
    """The package ``sksundae``, which speaks to whom listens; nobody else in this program imports it."""
    with _changing_the_environment:
        if "sksundae" not in sys.modules:
            builtins.print = _say
        try:
            import sksundae
            from sksundae import _cy_cvode, _cy_ida
        finally:
            if builtins.print is _say:
                builtins.print = _print
        _cy_cvode.warn = _cy_ida.warn = _warn
    return sksundae


class Messages:
    """What one solver says, line by line, without empty lines."""

    def __init__(self) -> None:
        self._printed: list[str] = []
        self._logged: list[str] = []
        self._log: IO[bytes] | None = None
        self._read = 0

    @contextlib.contextmanager
    def heard(self) -> Iterator[None]:
        """Keep what scikit-sundae prints inside, in this thread."""
        before, _listener.lines = _listener.lines, self._printed
        try:
            yield
        finally:
            _listener.lines = before

    @contextlib.contextmanager
    def logged(self) -> Iterator[None]:
        """Keep the log of a solver of SUNDIALS that is made inside."""
        self._log, self._read = _nameless_file(), 0
        place = os.devnull
        if self._log is not None:
            place = _place_of(self._log)
            weakref.finalize(self, self._log.close)
        with _changing_the_environment:
            for name in LOG_VARIABLES:
                os.putenv(name, place)
            try:
                yield
            finally:
                for name in LOG_VARIABLES:
                    if name in os.environ:
                        os.putenv(name, os.environ[name])
                    else:
                        os.unsetenv(name)

    def lines(self) -> list[str]:
        """All lines so far. The logger keeps some back, a few thousand characters at most, until its solver is freed."""
        if self._log is not None:
            # Where a name of the file means the same open file, its position is that of the logger.
            file = self._log.fileno()
            text = os.pread(file, os.fstat(file).st_size - self._read, self._read)
            self._read += len(text)
            self._logged += [line.strip() for line in text.decode(errors="replace").splitlines() if line.strip()]
        return self._logged + self._printed


def _nameless_file() -> IO[bytes] | None:
    """A file that vanishes with its last user, in memory where that can be had; None where there is no room for one."""
    with contextlib.suppress(AttributeError, OSError):
        return os.fdopen(os.memfd_create("sundials"), "rb")
    with contextlib.suppress(OSError):
        return tempfile.TemporaryFile(buffering=0)
    return None


def _place_of(file: IO[bytes]) -> str:
    """A name under which C, and another process too, can open a file that has none."""
    names = (f"/proc/{os.getpid()}/fd/{file.fileno()}", f"/dev/fd/{file.fileno()}")
    return next((name for name in names if os.path.exists(name)), os.devnull)  # noqa: PTH110  # names of the system
