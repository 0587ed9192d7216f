import numpy as np
import pytest

from mol_compactons import Grid, InputError


def test_points_exclude_the_right_end() -> None:
    grid = Grid(length=3, size=6, left=-1)
    assert grid.x.tolist() == [-1, -0.5, 0, 0.5, 1, 1.5]


def test_offset_is_the_signed_distance_on_the_ring() -> None:
    grid = Grid(length=10, size=10)
    assert grid.offset(9.0)[0] == 1.0
    assert grid.offset(19.0)[8] == -1.0
    assert np.abs(grid.offset(3.7)).max() <= 5


def test_wavenumbers_belong_to_the_real_transform() -> None:
    grid = Grid(length=2 * np.pi, size=8)
    assert np.allclose(grid.wavenumbers, [0, 1, 2, 3, 4])


@pytest.mark.parametrize(
    ("length", "size", "words"),
    [(0, 10, "grid.length = 0"), (-1, 10, "grid.length = -1"), (1, 2, "grid.size = 2"), (float("nan"), 10, "finite")],
)
def test_bad_input_is_named(length: float, size: int, words: str) -> None:
    with pytest.raises(InputError, match=words):
        Grid(length=length, size=size)
