from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mol_compactons.results import running_file
from mol_compactons.results.running_file import STATUS_ROOM, RunningFile, is_claimed
from tests.results.test_recorder import SIZE, layout
from tests.systems import Array

FRAMES = st.lists(arrays(float, (2, SIZE), elements=st.floats(allow_nan=False)), min_size=1, max_size=6)


def filled(path: Path, frames: list[Array]) -> RunningFile:
    file = RunningFile(path, layout())
    for index, frame in enumerate(frames):
        file.append(frame, np.array([[0.5 * index, float(index), -1.0]]))
    return file


@given(FRAMES, st.sampled_from(["netcdf4", "scipy"]))
def test_plain_xarray_reads_what_was_written_and_so_does_it(frames: list[Array], engine: str) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder, "a.nc")
        file = filled(path, frames)
        file.sync()
        with xr.open_dataset(path, engine=engine) as dataset:
            assert dataset.attrs["status"] == "running"
            assert np.array_equal(dataset.S, [frame[0] for frame in frames])
            assert np.array_equal(dataset.v, [frame[1] for frame in frames])
            assert dataset.mass.values.tolist() == list(range(len(frames)))
            assert dataset.x.values.tolist() == layout().coordinates.tolist()
        series, often, fields = file.rows(1, len(frames) - 1)
        assert series[0].tolist() == [0.5 * index for index in range(1, len(frames))]
        assert np.array_equal(series[2], -np.ones(len(frames) - 1))
        assert often.size == 0
        assert np.array_equal(fields.swapaxes(0, 1), frames[1:]) or len(frames) == 1
        file.close()


def test_a_frame_counts_when_it_is_safe_and_not_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = filled(tmp_path / "a.nc", [np.ones((2, SIZE))])
    order: list[str] = []
    write, fsync = file._write, os.fsync

    def written(place: int, content: bytes) -> None:
        order.append(f"{len(content)} at {place}")
        write(place, content)

    def made_safe(number: int) -> None:
        order.append("safe")
        fsync(number)

    monkeypatch.setattr(file, "_write", written)
    monkeypatch.setattr(os, "fsync", made_safe)
    assert file.frames == 0
    with xr.open_dataset(tmp_path / "a.nc") as dataset:
        assert dataset.sizes["t"] == 0
    file.sync()
    assert file.frames == 1
    row = 8 * (3 + 2 * SIZE)
    assert order == [f"{row} at {file.size - row}", "safe", "4 at 4", "safe"]
    file.close()


@pytest.mark.parametrize("status", ["complete", "gescheitert bei t = 3: zu groß", "x" * 5000, "é" * 600])
def test_the_status_has_its_room(status: str, tmp_path: Path) -> None:
    file = filled(tmp_path / "a.nc", [np.ones((2, SIZE))])
    file.sync()
    size = (tmp_path / "a.nc").stat().st_size
    for text in (status, "short"):
        file.set_status(text)
        with xr.open_dataset(tmp_path / "a.nc") as dataset:
            kept = dataset.attrs["status"]
            assert text.startswith(kept)
            assert len(kept.encode()) >= min(len(text.encode()), STATUS_ROOM - 2)
            assert float(dataset.S[0, 0]) == 1
    assert (tmp_path / "a.nc").stat().st_size == size
    file.close()


def test_it_is_claimed_until_it_is_closed(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    file = filled(path, [])
    assert is_claimed(path)
    with pytest.raises(BlockingIOError), path.open("rb") as other:
        running_file.claim(other.fileno())
    file.close()
    assert not is_claimed(path)
    assert not is_claimed(tmp_path / "nothing.nc")


LIMITED = """
import resource, signal, sys
from pathlib import Path
import numpy as np
from mol_compactons.results.running_file import RunningFile
from tests.results.test_recorder import SIZE, layout
file = RunningFile(Path(sys.argv[1]), layout())
for index in range(3):
    file.append(np.full((2, SIZE), index), np.array([[float(index), 0.0, 0.0]]))
file.sync()
resource.setrlimit(resource.RLIMIT_FSIZE, (file.size + 50, resource.RLIM_INFINITY))
for index in range(3, 5):
    file.append(np.full((2, SIZE), index), np.array([[float(index), 0.0, 0.0]]))
try:
    file.sync()
except OSError as error:
    print(error.errno)
file.set_status("failed")
print(file.frames, Path(sys.argv[1]).stat().st_size == file.size)
"""


@pytest.mark.skipif(not hasattr(resource, "RLIMIT_FSIZE"), reason="the system knows no limit on the size of files")
def test_what_cannot_be_added_leaves_what_is_there(tmp_path: Path) -> None:
    """Half a frame fits: it is taken away again."""
    path = tmp_path / "a.nc"
    done = subprocess.run([sys.executable, "-c", LIMITED, str(path)], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "3 True"
    with xr.open_dataset(path) as dataset:
        assert dataset.attrs["status"] == "failed"
        assert dataset.t.values.tolist() == [0, 1, 2]
        assert np.array_equal(dataset.S, np.repeat([[0.0], [1], [2]], SIZE, axis=1))
