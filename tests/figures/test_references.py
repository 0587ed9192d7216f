from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from mol_compactons import (
    Compacton,
    GranularChain,
    InputError,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Simulation,
    Symplectic,
    continuum_of,
    run,
)
from mol_compactons.figures.references import beside_of, exact_profile, profile_at
from mol_compactons.figures.views import snapshots
from tests.systems import one_compacton


@pytest.fixture(scope="module")
def chain() -> xr.Dataset:
    return run(
        Simulation(
            equation=GranularChain(PowerContact(1.5)),
            grid=Lattice(40),
            scheme=NearestNeighbours(),
            initial=[Compacton(speed=1, center=10)],
            t_end=4,
            frames=5,
            integrator=Symplectic(step=0.05),
        )
    )


@pytest.fixture(scope="module")
def continuum(chain: xr.Dataset) -> xr.Dataset:
    return run(continuum_of(Simulation.from_json(chain.attrs["simulation"]), points_per_site=8))


def test_the_exact_wave_moves_with_its_speed() -> None:
    dataset = run(one_compacton(size=150, t_end=1, frames=2))
    crests = []
    for t in (0.0, 1.0):
        curve = exact_profile(dataset, t)
        assert curve is not None
        crests.append(float(curve[0][np.argmax(curve[1])]))
    assert crests[1] - crests[0] == pytest.approx(1, abs=0.2)
    assert exact_profile(dataset.assign_attrs(simulation="{}"), 0.0) is None


def test_a_continuum_stands_beside_its_chain_in_sites(chain: xr.Dataset, continuum: xr.Dataset) -> None:
    """Marks at the sites, on a line with the same crest: at t = 0 both are the same wave."""
    axes = Figure().subplots()
    snapshots(chain, axes, (0, 4), beside=continuum, called="continuum")
    marks, line, later, _ = axes.lines
    assert marks.get_marker() != later.get_marker() != "None"
    np.testing.assert_array_equal(np.asarray(marks.get_ydata()), chain.R.values[0])
    x, values = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    np.testing.assert_allclose(np.interp(chain.k.values, x, values), chain.R.values[0], atol=1e-2)
    assert axes.get_xlabel() == "k"
    assert axes.lines[-1].get_label() == "continuum"


def test_results_without_a_common_space_are_refused(chain: xr.Dataset, continuum: xr.Dataset) -> None:
    with pytest.raises(InputError, match="along x and the second along k; give a chain first, and then its continuum"):
        beside_of(continuum, chain)


def test_a_time_beyond_the_second_result_is_refused_and_rounding_is_not(chain: xr.Dataset, continuum: xr.Dataset) -> None:
    field = beside_of(chain, continuum)
    last = float(field.t[-1])
    for t in (last * (1 + 1e-13), last):
        np.testing.assert_allclose(profile_at(field, t)[1], field.values[-1], atol=1e-13)
    with pytest.raises(InputError, match="t = 5 is beyond the second result, which goes from 0 to 4"):
        profile_at(field, 5)
