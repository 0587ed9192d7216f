"""The folder of a study: its plan, what each member came to, and the results of the members, safe whatever ends the study."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from mol_compactons.errors import InputError, require
from mol_compactons.results.places import REASONS, sync_folder, why, written_whole
from mol_compactons.results.running_file import claim, is_claimed

PLAN, ROWS, LOCK, MEMBERS = "plan.json", "rows.jsonl", ".lock", "members"
"""The files of a study and the folder of its results."""

FORMAT = 1
"""The form of a study's folder; a program that does not know it says so."""

logger = logging.getLogger(__name__)

Row = dict[str, Any]
"""What a member came to, JSON-ready: its ``name``, ``status``, ``reason``, ``seconds`` and ``quantities``."""

FAILED = "failed"
"""The status of a member that has no complete result."""

LOST = "lost"
"""Whether a row is that of a member that lost its process: what it came to is not known."""


class Store:
    """The folder of one study, claimed by one process.

    Parameters
    ----------
    folder : Path
        Where; made if it does not exist.
    plan : mapping
        What is studied, JSON-ready. A folder holds one plan for good.

    Raises
    ------
    InputError
        If the folder holds another study or anything else, cannot be written, or another process runs the study.
    """

    def __init__(self, folder: Path, plan: Mapping[str, Any]) -> None:
        self.folder = folder
        require(folder.parent.is_dir(), f"The folder {folder.parent} does not exist; create it, or choose another.")
        require(not folder.exists() or folder.is_dir(), f"{folder} is a file; give the name of a folder for the study.")
        with _in(folder):
            others = {path.name for path in folder.iterdir()} if folder.is_dir() else set()
        if PLAN in others:
            require(
                plan_of(folder) == _stored(plan), f"{folder} holds another study; choose another folder, or remove this one."
            )
        else:
            require(others <= {LOCK, MEMBERS}, f"{folder} holds other files; choose a folder of its own for the study.")
        with _in(folder):
            (folder / MEMBERS).mkdir(parents=True, exist_ok=True)
            self._lock = (folder / LOCK).open("ab")
        try:
            claim(self._lock.fileno())
        except BlockingIOError:
            self._lock.close()
            raise InputError(
                f"Another process runs the study in {folder}; wait for its end, or choose another folder."
            ) from None
        if PLAN not in others:
            with written_whole(folder / PLAN) as part:
                part.write_text(json.dumps(_stored(plan), indent=1) + "\n", encoding="utf-8")
        with _in(folder):
            self._rows = _whole_lines(folder / ROWS)
        sync_folder(folder)

    def path_of(self, name: str) -> Path:
        """Where the result of a member is."""
        return result_path(self.folder, name)

    def rows(self) -> dict[str, Row]:
        """The last row of each member that has one, by its name."""
        return rows_of(self.folder)

    def add(self, *rows: Row) -> None:
        """Take note of what members came to, safe on disk; raises `InputError` where that fails."""
        for row in rows:
            level = logging.WARNING if row["status"] == FAILED else logging.INFO
            logger.log(level, "%s: %s: %s", self.folder, row.get("label", row["name"]), row.get("reason") or row["status"])
        with _in(self.folder):
            self._rows.write(b"".join(json.dumps(row).encode() + b"\n" for row in rows))
            self._rows.flush()
            os.fsync(self._rows.fileno())

    def close(self) -> None:
        """Let others have the study."""
        self._rows.close()
        self._lock.close()


def forget_another(folder: Path, plan: Mapping[str, Any]) -> None:
    """Remove a folder that a program made for itself, if it holds another study that nobody runs."""
    if not folder.is_dir() or is_claimed(folder / LOCK):
        return
    with contextlib.suppress(InputError):
        if plan_of(folder) == _stored(plan):
            return
    shutil.rmtree(folder, ignore_errors=True)


def _stored(plan: Mapping[str, Any]) -> dict[str, Any]:
    """A plan as it is read again from its file."""
    return dict(json.loads(json.dumps({"format": FORMAT, **plan})))


def plan_of(folder: Path) -> dict[str, Any]:
    """The plan of the study in a folder; raises `InputError` if there is none."""
    try:
        plan = json.loads((folder / PLAN).read_text(encoding="utf-8"))
    except OSError:
        raise InputError(f"{folder} holds no study; give the folder that mol-compactons sweep wrote.") from None
    except ValueError:
        raise InputError(f"{folder / PLAN} is damaged; the results are in {folder / MEMBERS}.") from None
    known = isinstance(plan, dict) and plan.get("format") == FORMAT
    require(known, f"{folder} holds a study in a form that this version does not know; read it with the one that made it.")
    return dict(plan)


def rows_of(folder: Path) -> dict[str, Row]:
    """The last row of each member of the study in a folder, by its name; what a crash cut off is left out."""
    rows = {}
    with contextlib.suppress(FileNotFoundError), _in(folder):
        for line in (folder / ROWS).read_bytes().split(b"\n")[:-1]:
            with contextlib.suppress(ValueError):
                row = json.loads(line)
                rows[row["name"]] = row
    return rows


def what_is_kept(folder: Path) -> str:
    """What a study that was interrupted leaves, and how it goes on."""
    kept = len(rows_of(folder))
    return f"{kept} members that have run are kept; the same command goes on." if kept else "nothing was written."


def result_path(folder: Path, name: str) -> Path:
    """Where the result of a member is that has a file of its own."""
    return folder / MEMBERS / f"{name}.nc"


def file_of(row: Row) -> str:
    """The name of the file in which a member is, alone or with others."""
    return str(row.get("file", f"{row['name']}.nc"))


def _whole_lines(path: Path) -> Any:
    """A file of lines, opened to add more; a last line that a crash cut off is removed."""
    file = path.open("ab")
    content = path.read_bytes()
    file.truncate(content.rfind(b"\n") + 1)
    return file


@contextlib.contextmanager
def _in(folder: Path) -> Iterator[None]:
    """Errors of the file system as one sentence."""
    try:
        yield
    except FileNotFoundError:
        raise
    except OSError as error:
        reason = REASONS.get(error.errno or 0) or why(error, folder.parent)
        raise InputError(f"The folder {folder} cannot be used: {reason}.") from None
