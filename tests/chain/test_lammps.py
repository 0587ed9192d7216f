"""The chain against LAMMPS, where it is installed."""

import numpy as np
import pytest

from benchmarks.lammps_chain import chain, difference, hertz_by_lammps, load_lammps
from mol_compactons import run


@pytest.fixture(scope="module", autouse=True)
def _needs_lammps() -> None:
    try:
        with np.errstate(all="ignore"):
            load_lammps().close()
    except (ImportError, OSError) as error:
        pytest.skip(f"LAMMPS cannot be loaded: {error}")


@pytest.mark.parametrize("n", [1.5, 2, 3])
def test_the_same_displacements(n: float) -> None:
    with np.errstate(all="ignore"):
        assert difference(chain(n, size=60, t_end=20)) < 1e-9


def test_the_pair_style_for_hertz_contacts_is_the_same_chain() -> None:
    simulation = chain(1.5, size=60, t_end=20)
    ours = run(simulation).Q.values[-1]
    with np.errstate(all="ignore"):
        theirs = hertz_by_lammps(simulation)
    assert np.abs(ours - theirs).max() < 1e-3 * np.abs(ours).max()
