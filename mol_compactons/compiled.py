"""Compilation of kernels by numba, kept on disk where there is a place for it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

from numba import njit

Kernel = TypeVar("Kernel", bound=Callable[..., Any])


def compiled(function: Kernel) -> Kernel:
    """Compile a function, with numpy's rules for division by zero.

    Its machine code is cached on disk unless no folder can be written, as in some containers.
    """
    try:
        return cast(Kernel, njit(cache=True, error_model="numpy")(function))
    except RuntimeError:
        return cast(Kernel, njit(error_model="numpy")(function))


def is_cold(function: Any) -> bool:
    """Whether a compiled function is not yet in the cache on disk, so that its first call will compile it."""
    folder = getattr(getattr(function, "_cache", None), "cache_path", None)
    return folder is not None and not any(Path(folder).glob(f"*.{function.__name__}-*.nbi"))
