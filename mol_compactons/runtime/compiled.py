"""Compilation of kernels by numba, kept on disk where there is a place for it."""

from __future__ import annotations

import contextlib
import hashlib
import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar, cast

from numba import njit
from numba.core import caching
from numba.core.event import Listener, install_listener

Kernel = TypeVar("Kernel", bound=Callable[..., Any])

# Numba has hardly any types, and half of them would be worse than none.
_Files: Any = caching.IndexDataCacheFile
_FunctionCache: Any = caching.FunctionCache

DIGEST = hashlib.sha256

LENGTH_OF_DIGEST = DIGEST().digest_size


class _CheckedFile(_Files):  # type: ignore[misc]
    """Numba's files of one function with a digest at the end, so that what is damaged is never run, nor even unpickled.

    Numba itself reads such a file as its own: an unpickler ignores what follows.
    """

    def _dump(self, content: Any) -> bytes:
        data: bytes = super()._dump(content)
        return data + DIGEST(data).digest()

    def _load_index(self) -> Any:
        """Which signature is in which file; none where the index is damaged or out of date."""
        try:
            content = Path(self._index_path).read_bytes()
            version = pickle.dumps(self._version, protocol=-1)
            stamp, overloads = pickle.loads(_verified(content[len(version) :]) if content.startswith(version) else b"")
        except Exception:  # whatever is wrong with a file, its kernels can be compiled anew
            return {}
        return overloads if stamp == self._source_stamp else {}

    def _load_data(self, name: str) -> Any:
        return pickle.loads(_verified(Path(self._data_path(name)).read_bytes()))


def _verified(data: bytes) -> bytes:
    """What stands before the digest; raises OSError where they do not belong together."""
    content, digest = data[:-LENGTH_OF_DIGEST], data[-LENGTH_OF_DIGEST:]
    if DIGEST(content).digest() != digest:
        raise OSError("the file is damaged")
    return content


class _Cache(_FunctionCache):  # type: ignore[misc]
    """Numba's cache of one function, without which a kernel is compiled where it cannot be read or written."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self._cache_file = _CheckedFile(
            cache_path=self._cache_path,
            filename_base=self._impl.filename_base,
            source_stamp=self._impl.locator.get_source_stamp(),
        )

    def load_overload(self, signature: Any, target: Any) -> Any:
        """The machine code for a signature; None where there is none that can be used."""
        try:
            return super().load_overload(signature, target)
        except Exception:  # as in `_CheckedFile`
            return None

    def save_overload(self, signature: Any, code: Any) -> None:
        """Keep machine code if that is possible."""
        with contextlib.suppress(OSError):
            super().save_overload(signature, code)


def compiled(function: Kernel) -> Kernel:
    """Compile a function, with numpy's rules for division by zero.

    Its machine code is cached on disk unless no folder can be written, as in some containers. A cache that is damaged, or
    cannot be written for lack of room or permission, is done without.
    """
    kernel: Any = njit(error_model="numpy")(function)
    # Without a compiler, as under a debugger, the function stays what it is.
    if hasattr(kernel, "enable_caching"):
        with contextlib.suppress(RuntimeError, OSError):
            kernel._cache = _Cache(function)
    return cast(Kernel, kernel)


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
