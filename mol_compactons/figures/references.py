"""What a result is seen beside: the exact wave, another result, or the continuum of a chain."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mol_compactons.analysis.chain_and_continuum import on_lattice
from mol_compactons.errors import InputError, require
from mol_compactons.figures.results import profiles
from mol_compactons.results.reading import arranged, space_of
from mol_compactons.simulation import Simulation

if TYPE_CHECKING:
    import xarray as xr

Curve = tuple[Any, Any]
"""The points and values of a profile."""

UNSURE_END = 1e-9
"""How far the last times of two results may lie apart by rounding, relative to them."""


def exact_profile(dataset: xr.Dataset, t: float) -> Curve | None:
    """The exact wave of a result at a time, where one is known that this program can compute.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    t : float
        When.
    """
    try:
        simulation = Simulation.from_json(str(dataset.attrs["simulation"]))
        state = simulation.exact_state(t)
    except InputError:
        return None
    return None if state is None else (simulation.grid.coordinates, state[0])


def beside_of(dataset: xr.Dataset, other: xr.Dataset) -> xr.DataArray:
    """The profiles of another result along t and the space of the first: of a chain's continuum, in sites.

    Parameters
    ----------
    dataset, other : xarray.Dataset
        Two results on the same line, or a chain and its continuum.

    Raises
    ------
    InputError
        If the two have no space in common.
    """
    own, space = arranged(other), space_of(dataset)
    if space == "k" and space_of(own) == "x":
        return on_lattice(own, str(dataset.attrs["simulation"]))
    require(
        space_of(own) == space,
        f"The first result is along {space} and the second along {space_of(own)}; give a chain first, and then its continuum.",
    )
    return profiles(own)


def profile_at(field: xr.DataArray, t: float) -> Curve:
    """A profile between the frames of a result, by linear interpolation.

    Raises
    ------
    InputError
        If the time is beyond the result.
    """
    first, last = float(field["t"][0]), float(field["t"][-1])
    room = UNSURE_END * max(abs(first), abs(last))
    require(
        first - room <= t <= last + room,
        f"t = {t:g} is beyond the second result, which goes from {first:g} to {last:g}.",
    )
    (space,) = (name for name in field.dims if name != "t")
    return field[space].values, field.interp(t=min(max(t, first), last)).values
