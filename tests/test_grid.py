import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import Grid, InputError, Lattice
from mol_compactons.grid import ring_distance


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


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(0.1, 100))
def test_the_distance_on_a_ring_is_the_shorter_way_with_its_sign(point: float, center: float, length: float) -> None:
    distance = float(ring_distance(np.array(point), center, length))
    assert -length / 2 <= distance <= length / 2
    rounds = (point - center - distance) / length
    assert rounds == pytest.approx(round(rounds), abs=1e-9 * (1 + 1e3 / length))


def test_the_sites_of_a_lattice_are_numbered_and_one_apart() -> None:
    lattice = Lattice(size=5)
    assert lattice.coordinates.tolist() == [0, 1, 2, 3, 4]
    assert (lattice.length, lattice.spacing) == (5, 1)
    assert lattice.offset(4.5).tolist() == [0.5, 1.5, -2.5, -1.5, -0.5]
    with pytest.raises(InputError, match=r"grid\.size = 2 must lie between 3 and"):
        Lattice(2)
