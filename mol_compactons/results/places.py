"""Where files go: what may be written there, and how a file appears whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import secrets
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from mol_compactons.errors import InputError, require

LONGEST_ADDITION = 32
"""By how many bytes the names of the files beside a result may be longer than its own."""

NAME_LIMIT = 255
"""The longest name of a file in bytes, where the system does not say."""

HARDLY_ANY = 2**20
"""A disk with less free space than this, in bytes, is called full."""

REASONS = {
    errno.ENOSPC: "the disk is full; make room or choose another place",
    errno.EDQUOT: "your share of the disk is used up; make room or choose another place",
    errno.EFBIG: "it would be larger than the system allows a file to be; raise the limit (ulimit -f) or choose fewer frames",
    errno.EACCES: "permission denied; choose another place",
    errno.EPERM: "permission denied; choose another place",
    errno.EROFS: "the file system is read-only; choose another place",
    errno.ENOENT: "its folder is no longer there; create it again or choose another place",
    errno.EIO: "the disk reports an error; choose another place",
}
"""Why a file cannot be written, by the number of the system's error, and what to do."""


def why(error: BaseException, folder: Path) -> str:
    """Why a file in a folder could not be written, and what to do; of a library that does not say, the disk is asked."""
    number = getattr(error, "errno", None)
    if number in REASONS and number not in (errno.EPERM, errno.EACCES):
        return REASONS[number]
    try:
        full = shutil.disk_usage(folder).free < HARDLY_ANY
    except OSError:
        return REASONS[errno.ENOENT]
    if full:
        return REASONS[errno.ENOSPC]
    if number is None and _files_are_limited():
        return REASONS[errno.EFBIG]
    return REASONS.get(number or 0) or f"{getattr(error, 'strerror', None) or error}; choose another place"


def _files_are_limited() -> bool:
    """Whether the system limits the size of the files of this process."""
    try:
        import resource
    except ImportError:
        return False
    return resource.getrlimit(resource.RLIMIT_FSIZE)[0] != resource.RLIM_INFINITY


def check_target(path: Path, overwrite: bool) -> None:
    """Raise `InputError` unless a file can be written at `path`."""
    try:
        name = str(path.name).encode(sys.getfilesystemencoding())
        path.exists()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path} cannot be the name of a file ({reason}); choose another.") from None
    require(not path.is_dir(), f"{path} is a folder; give the name of a file.")
    ordinary = path.is_file() and not path.is_symlink()
    require(ordinary or not os.path.lexists(path), f"{path} is not an ordinary file and is not replaced; choose another name.")
    require(path.parent.is_dir(), f"The folder {path.parent} does not exist; create it, or choose another.")
    require(os.access(path.parent, os.W_OK), f"The folder {path.parent} cannot be written; choose another.")
    longest = name_limit(path.parent) - LONGEST_ADDITION
    require(
        len(name) <= longest,
        f"The name {path.name[:20]}... has {len(name)} bytes, and {longest} are allowed; choose a shorter one.",
    )
    require(
        overwrite or not path.exists(),
        f"{path} exists; allow overwriting (--overwrite, in Python overwrite=True) or choose another name.",
    )


def name_limit(folder: Path) -> int:
    """The longest name of a file in a folder, in bytes."""
    try:
        return os.pathconf(folder, "PC_NAME_MAX")
    except (AttributeError, OSError, ValueError):
        return NAME_LIMIT


def beside(path: Path, role: str) -> Path:
    """The hidden file beside another that has a role for it."""
    return path.with_name(f".{path.name}.{role}")


def new_part(path: Path) -> Path:
    """A hidden name beside a file that nobody else uses, with the same ending, for what is to become that file."""
    return path.with_name(f".{path.stem}.{os.getpid()}-{secrets.token_hex(4)}{path.suffix}")


def parts_of(path: Path) -> list[Path]:
    """The hidden files beside a file that are to become it."""
    return [part for part, _ in _parts(path)]


def leftovers(path: Path) -> list[Path]:
    """Those of processes that have ended."""
    return [part for part, process in _parts(path) if not _is_alive(process)]


def _parts(path: Path) -> list[tuple[Path, int]]:
    pattern = re.compile(rf"\.{re.escape(path.stem)}\.(\d+)-[0-9a-f]+{re.escape(path.suffix)}")
    start = f".{path.stem}."
    with os.scandir(path.parent) as entries:
        names = [entry.name for entry in entries if entry.name.startswith(start)]
    found = [(path.with_name(name), pattern.fullmatch(name)) for name in names]
    return [(other, int(match[1])) for other, match in found if match]


def _is_alive(process: int) -> bool:
    """Whether there is a process of a number on this machine; where the system does not say, there may be."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True


@contextlib.contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """A path to write to inside; what stands there afterwards replaces the file at `path` at once, safe on disk.

    If anything is raised inside, the file at `path` stays as it was.

    Yields
    ------
    Path
        A hidden file beside `path`, with the same ending.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    part = new_part(path)
    try:
        yield part
        keep_mode(path, part)
        with part.open("rb+") as file:
            os.fsync(file.fileno())
        part.replace(path)
        sync_folder(path.parent)
    except (OSError, RuntimeError) as error:
        if isinstance(error, BrokenPipeError):
            raise
        raise InputError(f"{path} cannot be written: {why(error, path.parent)}.") from None
    finally:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)


def keep_mode(path: Path, part: Path) -> None:
    """Let what is to replace a file be open to whom that is."""
    with contextlib.suppress(OSError):
        shutil.copymode(path, part)


def sync_folder(folder: Path) -> None:
    """Make the names in a folder safe on disk, where the system can."""
    with contextlib.suppress(OSError):
        number = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)
