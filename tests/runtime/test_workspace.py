"""Arrays of a thread: the same ones for each call in it, and none that another thread has."""

import copy
import pickle
import threading

import numpy as np

from mol_compactons.runtime.workspace import Workspace
from tests.systems import Array


def test_a_thread_keeps_its_arrays_and_shares_none() -> None:
    work = Workspace(3, 5)
    mine = work.arrays
    others: list[tuple[Array, ...]] = []
    thread = threading.Thread(target=lambda: others.append(work.arrays))
    thread.start()
    thread.join()
    assert [array.shape for array in others[0]] == [array.shape for array in mine] == [(3,), (5,)]
    assert all(here is there for here, there in zip(mine, work.arrays, strict=True))
    every = [*mine, *others[0]]
    assert not any(np.shares_memory(one, other) for index, one in enumerate(every) for other in every[:index])


def test_a_copy_has_room_of_its_own() -> None:
    work = Workspace(4)
    for again in (copy.deepcopy(work), pickle.loads(pickle.dumps(work))):
        assert again.arrays[0].shape == (4,)
        assert not np.shares_memory(again.arrays[0], work.arrays[0])
