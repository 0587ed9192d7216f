import numpy as np
import pytest
import xarray as xr

from mol_compactons import run
from mol_compactons.analysis.drift import drift
from tests.systems import one_compacton


def test_drift_is_relative_to_the_first_value() -> None:
    dataset = xr.Dataset({"mass": ("t", [2.0, 2.0, 1.0]), "energy": ("t", [0.0, 0.5, -1.0])}, {"t": [0.0, 1.0, 2.0]})
    changes = drift(dataset)
    assert changes.mass.values.tolist() == [0, 0, -0.5]
    assert changes.energy.values.tolist() == [0, 0.5, -1]
    assert changes.energy.attrs["scale"] == 1


def test_a_run_keeps_what_it_should() -> None:
    dataset = run(one_compacton(size=300, viscosity=0.0, integrator=None))
    changes = drift(dataset)
    assert float(np.abs(changes.mass).max()) < 1e-12
    assert float(np.abs(changes.energy).max()) < 1e-5
    assert dataset.energy[0] == pytest.approx(-np.pi / 2, rel=1e-2)
    assert dataset.momentum[0] == pytest.approx(np.pi, rel=1e-4)
    assert dataset.mass[0] == pytest.approx(4 * np.sqrt(2), rel=1e-3)
