"""The chain beside its continuum: both in the coordinates of the lattice, and how far they are apart, as numbers along t."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from mol_compactons.analysis.tracking import track
from mol_compactons.chain.chain import GranularChain
from mol_compactons.chain.law import PowerContact
from mol_compactons.equations.granular import GranularCompacton
from mol_compactons.equations.nesterenko import Nesterenko
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid
from mol_compactons.integrators.sundials import CVODE, IDA
from mol_compactons.results.reading import arranged, field_names, grid_of
from mol_compactons.results.schema import describe
from mol_compactons.schemes.compact import CompactScheme
from mol_compactons.schemes.conservative import ConservativeScheme
from mol_compactons.simulation import Simulation
from mol_compactons.waves.compacton import Compacton

if TYPE_CHECKING:
    import xarray as xr


def lattice_scale(chain: GranularChain) -> float:
    """sqrt(beta), beta = n / (6 (n+1)): the length, in sites, of one unit of X of the granular compacton equation.

    With this length a compacton of the granular compacton equation of speed c has the shape of one of Nesterenko's equation of
    the speed V = sqrt(c A), the data of the paper for the chain.
    """
    return math.sqrt(chain.law.continuum.dispersion)


def continuum_of(chain: Simulation, points_per_site: int = 16) -> Simulation:
    """The granular compacton equation with the compactons of a chain's initial data, on a line as long, for as long.

    Parameters
    ----------
    chain : Simulation
        A chain that starts with compactons, without a linear term.
    points_per_site : int
        How many grid points there are for each site.

    Raises
    ------
    InputError
        If the simulation is no such chain.
    """
    equation = _chain_of(chain)
    law = _power_law_of(equation)
    require(law.linear == 0, "A chain with a linear term does not follow the granular compacton equation; set linear=0.")
    compactons, scale = _compactons_of(chain), lattice_scale(equation)
    require(
        min(wave.speed for wave in compactons) > 0,
        "The granular compacton equation has waves to the right only; give the compactons of the chain positive speeds.",
    )
    return Simulation(
        title=f"The continuum of: {chain.title}",
        equation=GranularCompacton(law.n),
        grid=Grid(length=chain.grid.size / scale, size=chain.grid.size * points_per_site),
        scheme=ConservativeScheme(order=4, grid_viscosity=0.03, viscosity_order=6),
        initial=[Compacton(wave.speed**2 / law.strength, wave.center / scale, wave.sign) for wave in compactons],
        t_end=chain.t_end * math.sqrt(law.strength) / scale,
        frames=chain.frames,
        integrator=CVODE(rtol=1e-5),
    )


def two_way_continuum_of(chain: Simulation) -> Simulation:
    """Nesterenko's equation with the same compactons, on one grid point for each site.

    A finer grid would hold the short waves, k^2 > 12, that grow without bound in this equation; this one holds none.

    Parameters
    ----------
    chain : Simulation
        A chain that starts with compactons.

    Raises
    ------
    InputError
        If the simulation is no such chain.
    """
    return Simulation(
        title=f"Nesterenko's continuum of: {chain.title}",
        equation=_chain_of(chain).law.continuum,
        grid=Grid(length=chain.grid.size, size=chain.grid.size),
        scheme=CompactScheme(second_difference="five_point", viscosity=0),
        initial=_compactons_of(chain),
        t_end=chain.t_end,
        frames=chain.frames,
        integrator=IDA(rtol=1e-5, max_order=2),
    )


def _chain_of(simulation: Simulation) -> GranularChain:
    if not isinstance(simulation.equation, GranularChain):
        raise InputError(f"A continuum is that of a GranularChain, not of {type(simulation.equation).__name__}.")
    return simulation.equation


def _power_law_of(chain: GranularChain) -> PowerContact:
    if not isinstance(chain.law, PowerContact):
        raise InputError(f"A continuum is that of PowerContact, not of {type(chain.law).__name__}.")
    return chain.law


def _compactons_of(simulation: Simulation) -> list[Compacton]:
    """The initial data of a chain of equal grains that is not compressed, if it is compactons alone."""
    equation = _chain_of(simulation)
    require(
        not (equation.compression or equation.masses or equation.strengths),
        "A continuum is that of equal grains without compression; set compression=0, and no masses or strengths.",
    )
    compactons = [wave for wave in simulation.initial if isinstance(wave, Compacton)]
    require(
        len(compactons) == len(simulation.initial),
        "Only chains that start with nothing but compactons have a continuum with the same data; give Compacton waves.",
    )
    return [Compacton(wave.speed, wave.center, wave.sign) for wave in compactons]


def on_lattice(continuum: xr.Dataset, chain: str) -> xr.DataArray:
    r"""The first component of a continuum result in the time and space of the lattice.

    For the granular compacton equation x = sqrt(beta) X and t = sqrt(beta / A) T: then its compactons have the shape of those
    of the chain's data, and the speed c sqrt(A) where the chain has sqrt(c A). They agree for c = 1 only. Nesterenko's
    equation with a = 1 is in lattice coordinates as it stands.

    Parameters
    ----------
    continuum : xarray.Dataset
        A result.
    chain : str
        The simulation of the chain as JSON, the attribute of its result.

    Raises
    ------
    InputError
        If the result is of neither equation.
    """
    equation = _chain_of(Simulation.from_json(chain))
    simulation = Simulation.from_json(str(continuum.attrs["simulation"]))
    field = arranged(continuum)[field_names(continuum)[0]]
    if isinstance(simulation.equation, Nesterenko):
        require(
            simulation.equation.grain_distance == 1,
            f"Nesterenko.grain_distance = {simulation.equation.grain_distance:g}; to be compared with a chain it must be 1.",
        )
        return field
    if not isinstance(simulation.equation, GranularCompacton):
        raise InputError(
            f"A chain is compared with GranularCompacton or Nesterenko, not with {type(simulation.equation).__name__}."
        )
    scale = lattice_scale(equation)
    moved = field.assign_coords(x=field.x * scale, t=field.t * scale / math.sqrt(_power_law_of(equation).strength))
    moved.x.attrs, moved.t.attrs = describe("x"), describe("t")
    return moved


def compare(chain: xr.Dataset, continuum: xr.Dataset) -> xr.Dataset:
    """How far a chain and its continuum are apart, at the times of the chain that the continuum covers.

    Parameters
    ----------
    chain : xarray.Dataset
        A result with R(t, k).
    continuum : xarray.Dataset
        A result of the granular compacton equation or of Nesterenko's, on a grid as long as the chain, with as many frames or
        more.

    Returns
    -------
    xarray.Dataset
        Along t and k: ``R`` and ``continuum``, that at the sites, interpolated. Along t: ``distance``, the L2 norm of their
        difference relative to that of R. Along t and wave: ``position``, ``height``, ``width`` and ``residual`` of the chain's
        waves, as `track` measures them by the exact wave of the chain, and ``continuum_position``, ``continuum_height``,
        ``continuum_width`` and ``continuum_residual``, by the compacton of the continuum.

    Raises
    ------
    InputError
        If the results do not belong together.
    """
    import xarray as xr

    require("R" in chain, "The first result must be of a GranularChain in stresses, with R(t, k).")
    chain, continuum = arranged(chain), arranged(continuum)
    mapped = on_lattice(continuum, str(chain.attrs["simulation"]))
    x = mapped.x.values
    scale = float(x[1] - x[0]) / float(continuum.x[1] - continuum.x[0])
    length, sites = scale * grid_of(continuum).length, grid_of(chain).length
    require(
        abs(length - sites) < 1e-9 * sites,
        f"The continuum is {length:.6g} sites long, and the chain {sites:g}; choose one length, as continuum_of does.",
    )
    require(
        abs(x[0]) < 1e-9 * sites and mapped.sizes["t"] >= 4,
        f"The continuum begins at x = {x[0]:.6g} and has {mapped.sizes['t']} frames; it must begin at 0 and have at least 4.",
    )
    times = chain.t.values[chain.t.values <= float(mapped.t[-1]) * (1 + 1e-12)]
    wrapped = xr.concat([mapped, mapped.isel(x=[0]).assign_coords(x=[x[0] + length])], "x", join="outer")
    at_sites = wrapped.interp(t=np.minimum(times, float(mapped.t[-1])), x=chain.k.values, method="cubic").values
    stress = chain.R.values[: times.size]
    own, other = (track(result, newborn=False) for result in (chain, continuum))
    require(
        own.sizes["wave"] == other.sizes["wave"],
        f"The chain has {own.sizes['wave']} waves and the continuum {other.sizes['wave']}; start both from the same.",
    )
    other = other.assign_coords(t=mapped.t.values).interp(t=times)
    norms = np.linalg.norm(stress, axis=1)
    result = xr.Dataset(
        {
            "R": (("t", "k"), stress, chain.R.attrs),
            "continuum": (("t", "k"), at_sites, describe("continuum")),
            "distance": ("t", np.linalg.norm(stress - at_sites, axis=1) / norms, describe("distance")),
        },
        {"t": ("t", times, describe("t")), "k": ("k", chain.k.values, describe("k"))},
        {"simulation": chain.attrs["simulation"], "continuum": continuum.attrs["simulation"]},
    )
    for name, factor in (("position", scale), ("height", 1.0), ("width", scale), ("residual", 1.0)):
        result[name] = ("t", "wave"), own[name].values[: times.size], describe(name)
        result[f"continuum_{name}"] = ("t", "wave"), factor * other[name].values, describe(f"continuum_{name}")
    return result
