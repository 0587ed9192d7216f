from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from mol_compactons.errors import InputError
from mol_compactons.results.places import (
    LONGEST_ADDITION,
    beside,
    check_target,
    leftovers,
    name_limit,
    new_part,
    why,
    written_whole,
)


def test_a_file_appears_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")
    with written_whole(path) as part:
        assert part.suffix == path.suffix
        part.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("error", [ZeroDivisionError(), KeyboardInterrupt(), OSError(errno.ENOSPC, "full")])
def test_the_old_file_stays_where_the_new_one_fails(error: BaseException, tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fail() -> None:
        with written_whole(path) as part:
            part.write_text("half")
            raise error

    with pytest.raises(InputError if isinstance(error, OSError) else type(error)):
        fail()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.ENOSPC, "the disk is full"),
        (errno.EDQUOT, "your share of the disk is used up"),
        (errno.EFBIG, "larger than the system allows"),
        (errno.EROFS, "read-only"),
        (errno.EACCES, "permission denied"),
        (errno.ENOENT, "its folder is no longer there"),
        (errno.ELOOP, "Too many levels"),
    ],
)
def test_the_reason_is_the_one_of_the_system_and_says_what_to_do(number: int, words: str, tmp_path: Path) -> None:
    sentence = why(OSError(number, os.strerror(number)), tmp_path)
    assert words in sentence
    assert ";" in sentence


def test_a_library_that_calls_a_full_disk_a_lack_of_permission_is_not_believed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shutil.disk_usage", lambda folder: os.terminal_size((0, 0)) and _Usage())
    for error in (PermissionError(errno.EACCES, "Permission denied"), RuntimeError("NetCDF: HDF error")):
        assert "the disk is full" in why(error, tmp_path)


class _Usage:
    free = 0


def test_a_folder_that_is_gone_is_named(tmp_path: Path) -> None:
    assert "no longer there" in why(RuntimeError("NetCDF: HDF error"), tmp_path / "gone")


def test_a_name_leaves_room_for_those_beside_it(tmp_path: Path) -> None:
    longest = name_limit(tmp_path) - LONGEST_ADDITION
    path = tmp_path / ("a" * (longest - 3) + ".nc")
    check_target(path, overwrite=False)
    for other in (beside(path, "checkpoint-0"), new_part(beside(path, "checkpoint-1"))):
        other.write_text("")
        other.unlink()
    with pytest.raises(InputError, match=f"has {longest + 1} bytes, and {longest} are allowed"):
        check_target(tmp_path / ("a" * (longest - 2) + ".nc"), overwrite=False)


def test_parts_of_processes_that_have_ended_are_found_and_no_others(tmp_path: Path) -> None:
    path = tmp_path / "re[s]ult.nc"
    mine = [new_part(path) for _ in range(3)]
    assert len(set(mine)) == 3
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    left = [tmp_path / f".re[s]ult.{ended.pid}-{number}.nc" for number in range(2)]
    for part in (*mine, *left):
        part.write_text("")
    (tmp_path / ".re[s]ult.nc.checkpoint-0").write_text("")
    (tmp_path / ".other.1-1.nc").write_text("")
    assert sorted(leftovers(path)) == left
