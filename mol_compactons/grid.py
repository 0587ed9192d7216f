"""Where the unknowns sit: a uniform grid on a periodic line, or the sites of a chain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import Settings
from mol_compactons.errors import require

LARGEST_SIZE = 10**8
"""The most points or sites; a state of this size has 0.8 GB."""


@dataclass(frozen=True)
class Grid(Settings):
    """A uniform periodic grid, x_j = left + j h with j = 0 .. size - 1 and h = length / size.

    The right end is the left end again and is not stored.

    Parameters
    ----------
    length : float
        Period of the line, nondimensional.
    size : int
        Number of grid points.
    left : float
        Coordinate of the first point, nondimensional.

    Raises
    ------
    InputError
        If the length is not positive or there are fewer than 3 points.

    Examples
    --------
    >>> Grid(length=30, size=600).spacing
    0.05
    """

    length: float
    size: int
    left: float = 0.0

    dimension = "x"

    def __post_init__(self) -> None:
        super().__post_init__()
        require(
            1e-9 <= self.length <= 1e9 and abs(self.left) <= 1e9,
            f"grid.length = {self.length:g} must lie between 1e-9 and 1e9, and grid.left = "
            f"{self.left:g} between -1e9 and 1e9.",
        )
        require(3 <= self.size <= LARGEST_SIZE, f"grid.size = {self.size:.16g} must lie between 3 and {LARGEST_SIZE} points.")

    @property
    def spacing(self) -> float:
        """The distance h between neighbouring points, nondimensional."""
        return self.length / self.size

    @property
    def coordinates(self) -> NDArray[np.float64]:
        """The coordinates of the points, shape (size,), nondimensional."""
        return self.x

    @property
    def x(self) -> NDArray[np.float64]:
        """The coordinates, shape (size,), nondimensional."""
        return self.left + self.spacing * np.arange(self.size, dtype=np.float64)

    @property
    def wavenumbers(self) -> NDArray[np.float64]:
        """The wavenumbers k of a real Fourier transform on this grid, shape (size // 2 + 1,), nondimensional."""
        return 2 * np.pi / self.length * np.arange(self.size // 2 + 1, dtype=np.float64)

    def offset(self, center: float) -> NDArray[np.float64]:
        """Signed distance x - center on the periodic line, in [-length / 2, length / 2), shape (size,)."""
        return ring_distance(self.x, center, self.length)


@dataclass(frozen=True)
class Lattice(Settings):
    """The sites of a chain, k = 0 .. size - 1, a distance 1 apart.

    Parameters
    ----------
    size : int
        Number of sites.

    Raises
    ------
    InputError
        If there are fewer than 3 sites.
    """

    size: int

    dimension = "k"
    spacing = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require(3 <= self.size <= LARGEST_SIZE, f"grid.size = {self.size:.16g} must lie between 3 and {LARGEST_SIZE} sites.")

    @property
    def length(self) -> float:
        """The period, as long as there are sites."""
        return float(self.size)

    @property
    def coordinates(self) -> NDArray[np.float64]:
        """The numbers of the sites, shape (size,)."""
        return np.arange(self.size, dtype=np.float64)

    def offset(self, center: float) -> NDArray[np.float64]:
        """Signed distance k - center on the ring, in [-size / 2, size / 2), shape (size,)."""
        return ring_distance(self.coordinates, center, self.length)


def ring_distance(points: NDArray[np.float64], center: float | NDArray[np.float64], length: float) -> NDArray[np.float64]:
    """Signed distances points - center on a ring, in [-length / 2, length / 2)."""
    return np.asarray((points - center + length / 2) % length - length / 2)
