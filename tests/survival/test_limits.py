"""Disks that are full, files that may not grow, folders that go: what was safe stays, and one sentence says what happened."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from mol_compactons import run
from tests.systems import one_compacton

COMMAND = [sys.executable, "-m", "mol_compactons"]

LONG = ["run", "single_compacton", "--quiet", "--set", "t_end=1000", "--set", "frames=20001", "--set", "grid.size=150"]

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits are set as Linux has them")


def whole_frames(path: Path) -> int:
    """How many frames a file counts; none of them is damaged."""
    with xr.open_dataset(path) as dataset:
        assert np.isfinite(dataset.W).all()
        assert np.isfinite(dataset.energy).all()
        assert np.array_equal(dataset.t, np.arange(dataset.sizes["t"]) / 20)
        return dataset.sizes["t"]


def one_sentence(text: str) -> str:
    assert len(text.splitlines()) == 1, text
    assert text.startswith("mol-compactons: ")
    assert len(text) < 450
    return text


def test_a_file_that_may_not_grow_keeps_its_frames(tmp_path: Path) -> None:
    """1,024 blocks of 1,024 bytes."""
    command = f"ulimit -f 1024; exec {' '.join([*COMMAND, *LONG])} -o limited.nc"
    done = subprocess.run(["bash", "-c", command], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "limited.nc cannot be written any further: it would be larger than the system allows" in one_sentence(done.stderr)
    assert whole_frames(tmp_path / "limited.nc") > 100
    with xr.open_dataset(tmp_path / "limited.nc") as dataset:
        assert dataset.attrs["status"].startswith("failed at t = ")


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    disk = tmp_path / "disk"
    disk.mkdir()
    if (
        not shutil.which("mount")
        or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", disk], check=False).returncode
    ):
        pytest.skip("no small disk can be mounted; that needs the rights of root")
    yield disk
    subprocess.run(["umount", disk], check=True)


def fill_at_random_moments(disk: Path, times: int) -> None:
    random = np.random.default_rng(1)
    for _ in range(times):
        for path in disk.iterdir():
            path.unlink()
        run(one_compacton(), disk / "a.nc").close()
        before = (disk / "a.nc").read_bytes()
        (disk / "ballast").write_bytes(bytes(int(random.integers(0, 1_900_000))))
        command = [*COMMAND, *LONG, "-o", str(disk / "a.nc"), "--overwrite"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode in (1, 2)
        assert "the disk is full" in one_sentence(done.stderr)
        if (disk / "a.nc").read_bytes() != before:
            assert whole_frames(disk / "a.nc") > 1
            (disk / "ballast").unlink()
            short = ["-o", str(disk / "a.nc"), "--resume"]
            process = subprocess.Popen([*COMMAND, *LONG, *short], stderr=subprocess.PIPE)
            process.send_signal(signal.SIGTERM)
            process.communicate()
        assert not [path.name for path in disk.iterdir() if path.name.count(".") > 3]


def test_a_full_disk_keeps_what_was_safe(small_disk: Path) -> None:
    fill_at_random_moments(small_disk, 2)


@pytest.mark.slow
def test_a_disk_that_is_full_at_any_moment_keeps_what_was_safe(small_disk: Path) -> None:
    fill_at_random_moments(small_disk, 40)


def started(path: Path) -> subprocess.Popen[str]:
    """A long run whose file has some frames."""
    process = subprocess.Popen([*COMMAND, *LONG, "-o", str(path)], cwd=path.parent.parent, stderr=subprocess.PIPE, text=True)
    while not path.exists() or path.stat().st_size < 100_000:
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)
    return process


def test_a_folder_that_goes_and_a_file_that_is_replaced(tmp_path: Path) -> None:
    """The frames are saved in another place, and the file that came instead is not touched."""
    for change in ("folder", "file"):
        folder = tmp_path / change
        folder.mkdir()
        process = started(folder / "a.nc")
        if change == "folder":
            shutil.rmtree(folder)
        else:
            (folder / "other").write_text("precious")
            (folder / "other").replace(folder / "a.nc")
        _, complaint = process.communicate(timeout=120)
        assert process.returncode == 1
        said = one_sentence(complaint)
        assert "Another program replaced or removed" in said
        saved = Path(said.split("saved as ")[1].rstrip(".\n"))
        assert whole_frames(saved) > 20
        assert saved.parent == (tmp_path if change == "folder" else folder)
    assert (tmp_path / "file" / "a.nc").read_text() == "precious"


STABILITY = "stability n=2 sizes=20,40,80 -o"


@pytest.mark.parametrize("command", ["plot a.nc -o a.png", f"{STABILITY} s.nc", f"{STABILITY} s.png"])
def test_what_cannot_be_written_leaves_nothing(command: str, tmp_path: Path) -> None:
    run(one_compacton(), tmp_path / "a.nc").close()
    words = f"ulimit -f 4; exec {' '.join(COMMAND)} {command}"
    environment = os.environ | {"MPLCONFIGDIR": str(tmp_path.parent)}
    done = subprocess.run(["bash", "-c", words], cwd=tmp_path, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 2
    assert "cannot be written: it would be larger than the system allows" in one_sentence(done.stderr.splitlines()[-1] + "\n")
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]
