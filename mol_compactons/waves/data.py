"""Initial data of one's own: samples from an array or a file, and formulas."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from mol_compactons.equations.base import Equation
from mol_compactons.errors import InputError, require
from mol_compactons.expressions import pointwise
from mol_compactons.grid import Grid, Lattice
from mol_compactons.waves.base import Array, Wave
from mol_compactons.waves.files import read_csv, read_netcdf
from mol_compactons.waves.interpolation import FEWEST, periodic


@dataclass(frozen=True)
class Samples(Wave):
    """Any data, as numbers at points, given or read from a file.

    On a grid with the same points the numbers are taken as they are; on any other they are interpolated along the periodic
    line, by Fourier series where they are smooth and cover the line evenly, by a monotone spline otherwise. On a chain there
    must be one for each site.

    Parameters
    ----------
    values_at_points : list of float, or array
        One number for each point; for an equation with two components those of the first and then those of the second. Of an
        array of two dimensions the rows are the components.
    places : list of float, or array
        The points, ascending and within one period of the grid; empty where they cover the grid evenly from its left end on.
    file : str
        Where to read both, if they are not given: a CSV file with the columns x, u (and v), with or without a header, or a
        NetCDF file, such as a result. What was read is stored with the simulation, and not read again.
    variable : str
        Which variable of a NetCDF file; by default all fields of a result.
    t : float or None
        Which frame of a NetCDF file, the nearest; None for the last.

    Raises
    ------
    InputError
        If a number is NaN or infinite, the counts do not fit, or the file cannot be read.

    Examples
    --------
    >>> from mol_compactons import GranularCompacton
    >>> Samples(np.cos(np.arange(8) * np.pi / 4)).values(GranularCompacton(n=3), Grid(length=8, size=4)).round(12)
    array([[ 1.,  0., -1., -0.]])
    """

    values_at_points: tuple[float, ...] = ()
    places: tuple[float, ...] = ()
    file: str = ""
    variable: str = ""
    t: float | None = None

    def __post_init__(self) -> None:
        if isinstance(self.file, Path):
            object.__setattr__(self, "file", str(self.file))
        given: Any = self.values_at_points
        if getattr(given, "ndim", 1) > 1:
            object.__setattr__(self, "values_at_points", np.asarray(given).ravel())
        elif isinstance(given, tuple) and not given and isinstance(self.file, str) and self.file:
            places, values = self._read()
            object.__setattr__(self, "values_at_points", tuple(values.ravel()))
            object.__setattr__(self, "places", tuple(places))
        super().__post_init__()
        require(
            len(self.values_at_points) > 0,
            "Samples holds no numbers; give values_at_points, or the name of a file that has them.",
        )
        steps = np.diff(self.places)
        require(bool((steps > 0).all()), "Samples.places must ascend, each number larger than the one before; sort them.")

    def _read(self) -> tuple[Array, Array]:
        if self.file.lower().endswith(".csv"):
            return read_csv(Path(self.file))
        return read_netcdf(Path(self.file), self.variable, self.t)

    def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> Array:
        """The data on a grid, shape (components, size)."""
        components, count = len(equation.variables), len(self.values_at_points)
        points = count // components
        even = count == points * components and len(self.places) in (0, points)
        require(
            even and (points == grid.size or (isinstance(grid, Grid) and points >= FEWEST)),
            f"Samples holds {count} numbers at {len(self.places) or 'evenly spaced'} places, but the equation has "
            f"{components} component(s) on {grid.size} points; give {components * grid.size} numbers"
            + (f", or {components} for each of at least {FEWEST} places." if isinstance(grid, Grid) else "."),
        )
        rows: Array = np.array(self.values_at_points, dtype=np.float64).reshape(components, points)
        if isinstance(grid, Lattice):
            return rows
        even_places = grid.left + grid.length / points * np.arange(points, dtype=np.float64)
        return periodic(np.array(self.places) if self.places else even_places, rows, grid)


@dataclass(frozen=True)
class Formula(Wave):
    """Data given by a formula in x, the coordinate of a grid point or of a site.

    Parameters
    ----------
    formula : str
        The first component, such as "exp(-(x - 20)**2 / 4)"; see docs/formulas.md for what it may hold.
    second : str
        The second component of an equation that has two, zero by default.
    parameters : mapping of str to float
        Names in the formulas that stand for numbers.

    Raises
    ------
    InputError
        If the text is no formula in x, or is not finite at a point.

    Examples
    --------
    >>> from mol_compactons import GranularCompacton
    >>> Formula("a * x", parameters={"a": 2}).values(GranularCompacton(n=3), Grid(length=3, size=3))
    array([[0., 2., 4.]])
    """

    formula: str
    second: str = ""
    parameters: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, text in (("formula", self.formula), ("second", self.second or "0")):
            pointwise(text, ("x",), self.parameters, f"Formula.{name}")

    def values(self, equation: Equation, grid: Grid | Lattice, t: float = 0.0) -> Array:
        """The values of the formulas, shape (components, size)."""
        components = len(equation.variables)
        require(
            components > 1 or not self.second,
            f"Formula.second = {self.second!r} is for equations with two components; {type(equation).__name__} has one.",
        )
        x, rows = grid.coordinates, []
        for name, text in zip(("formula", "second"), (self.formula, self.second or "0")[:components], strict=False):
            row = np.broadcast_to(pointwise(text, ("x",), self.parameters, f"Formula.{name}")(x), x.shape)
            if not np.isfinite(row).all():
                place = float(x[np.flatnonzero(~np.isfinite(row))[0]])
                raise InputError(f"Formula.{name} = {text!r} is not finite at x = {place:g}; choose another formula.")
            rows.append(row)
        return np.array(rows)
