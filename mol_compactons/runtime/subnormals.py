"""Flushing subnormal numbers to zero, which keeps the empty background of a compacton from slowing the arithmetic."""

from __future__ import annotations

import ctypes
import platform
import sys
from collections.abc import Iterator
from contextlib import contextmanager

FLUSH_TO_ZERO, DENORMALS_ARE_ZERO = 0x8000, 0x0040
"""The two bits of the control register of SSE."""

_ENVIRONMENT_BYTES, _CONTROL_OFFSET = 64, 28
"""Room for the floating-point environment of glibc on x86-64, and where the control register stands in it."""


def is_supported() -> bool:
    """Whether this machine's floating-point environment is known: glibc on x86-64."""
    return sys.platform == "linux" and platform.machine() == "x86_64" and platform.libc_ver()[0] == "glibc"


@contextmanager
def flushing_subnormals(wanted: bool = True) -> Iterator[None]:
    """Numbers below 2.2e-308 count as zero in this thread while inside; does nothing where that is not supported.

    Parameters
    ----------
    wanted : bool
        Whether to do so at all.
    """
    if not (wanted and is_supported()):
        yield
        return
    library = ctypes.CDLL("libm.so.6")
    before = ctypes.create_string_buffer(_ENVIRONMENT_BYTES)
    library.fegetenv(before)
    inside = ctypes.create_string_buffer(before.raw, _ENVIRONMENT_BYTES)
    control = ctypes.c_uint32.from_buffer(inside, _CONTROL_OFFSET)
    control.value |= FLUSH_TO_ZERO | DENORMALS_ARE_ZERO
    library.fesetenv(inside)
    try:
        yield
    finally:
        library.fesetenv(before)
