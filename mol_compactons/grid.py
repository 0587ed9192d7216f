"""Where the unknowns sit: a uniform grid on a periodic line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import check
from mol_compactons.errors import require


@dataclass(frozen=True)
class Grid:
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

    def __post_init__(self) -> None:
        check(self)
        require(self.length > 0, f"grid.length = {self.length:g} must be positive; give the period of the line.")
        require(self.size >= 3, f"grid.size = {self.size} must be at least 3 points.")

    @property
    def spacing(self) -> float:
        """The distance h between neighbouring points, nondimensional."""
        return self.length / self.size

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
        half = self.length / 2
        return np.asarray((self.x - center + half) % self.length - half)
