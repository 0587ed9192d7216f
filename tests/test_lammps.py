"""The chain against LAMMPS, where it is installed."""

import numpy as np
import pytest

from benchmarks.lammps_chain import chain, difference, load_lammps


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
