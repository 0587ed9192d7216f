from __future__ import annotations

from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons.integrators.base import Counters
from mol_compactons.results import checkpoint
from mol_compactons.results.checkpoint import Checkpoint


def made(t: float, frames: int = 3) -> Checkpoint:
    memory = {"t": np.array(t), "state": np.full((2, 5), t), "stages": np.arange(24.0).reshape(2, 3, 4)}
    return Checkpoint(t, frames, memory, Counters(steps=7, first_warning="näh"), 1.5, '{"a": 1}', "this 1.0")


def same(one: Checkpoint | None, other: Checkpoint) -> bool:
    assert one is not None
    assert one.memory.keys() == other.memory.keys()
    assert all(np.array_equal(one.memory[name], other.memory[name]) for name in other.memory)
    return one.about() == other.about()


def test_the_last_of_two_is_found_and_no_more_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    assert checkpoint.last(path) is None
    for number in range(5):
        checkpoint.save(path, number, made(number / 10))
        assert same(checkpoint.last(path), made(number / 10))
    assert len(list(tmp_path.iterdir())) == checkpoint.KEPT
    checkpoint.discard(path)
    assert list(tmp_path.iterdir()) == []


@given(st.integers(0, 10**6), st.integers(1, 255))
def test_a_damaged_one_gives_way_to_the_one_before(place: int, change: int) -> None:
    """Whatever byte is flipped: the numbers of the one that is found are right."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "a.nc")
        for number in range(2):
            checkpoint.save(path, number, made(float(number)))
        newest = checkpoint.places(path)[1]
        content = bytearray(newest.read_bytes())
        content[place % len(content)] ^= change
        newest.write_bytes(content)
        found = checkpoint.last(path)
        assert found is not None
        assert same(found, made(found.t))


def test_what_is_cut_short_or_empty_is_no_checkpoint(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    checkpoint.save(path, 0, made(1.0))
    whole = checkpoint.places(path)[0].read_bytes()
    for length in (0, 10, len(whole) // 2, len(whole) - 1):
        checkpoint.places(path)[0].write_bytes(whole[:length])
        assert checkpoint.last(path) is None
