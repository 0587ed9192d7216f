"""Small things of which there are pages: a run, a chain with its continuum, a study and a sweep."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from mol_compactons import (
    ChainCompacton,
    Compacton,
    Family,
    GranularChain,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Rosenbrock,
    Simulation,
    Symplectic,
    continuum_of,
    converge,
    run,
    sweep,
)
from tests.systems import one_compacton

HOSTILE = "</script><script>alert(1)</script><b>&amp;\u2028 {{ 7 * 7 }}"
"""A title that would like to be more than that."""

PAIR = replace(
    one_compacton(size=150, t_end=28, frames=57, integrator=Rosenbrock()),
    initial=[Compacton(1, 6), Compacton(0.25, 16)],
    title=HOSTILE,
)


@pytest.fixture(scope="package")
def pair() -> xr.Dataset:
    """Two compactons."""
    return run(PAIR)


@pytest.fixture(scope="package")
def chain() -> tuple[xr.Dataset, xr.Dataset]:
    """Two waves of a chain, and its continuum."""
    simulation = Simulation(
        equation=GranularChain(PowerContact(n=3 / 2), ends="held"),
        grid=Lattice(size=40),
        scheme=NearestNeighbours(),
        initial=[ChainCompacton(speed=1, center=8), ChainCompacton(speed=1 / 2, center=18)],
        t_end=4,
        frames=21,
        integrator=Symplectic(step=0.05),
    )
    return run(simulation), run(continuum_of(simulation))


@pytest.fixture(scope="package")
def study() -> xr.DataTree:
    """A small family."""
    return converge(one_compacton(t_end=0.3, frames=4), Family(sizes=(75, 150)))


@pytest.fixture(scope="package")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a sweep of which some members fail."""
    folder = tmp_path_factory.mktemp("swept") / "sweep"
    varied: dict[str, list[Any]] = {"grid.size": [3, 60, 75], "scheme.viscosity": [1e-4, 1e-3, 1e-2]}
    sweep(one_compacton(t_end=0.2, frames=3, integrator=Rosenbrock()), varied, folder)
    return folder
