import numpy as np
import pytest

from mol_compactons import CVODE, Compacton, ConservativeScheme, GranularCompacton, Grid, Simulation, run
from mol_compactons.runtime.subnormals import flushing_subnormals, is_supported

TINY = np.array([1e-310])


def halved() -> float:
    return float((TINY * 0.5)[0])


@pytest.mark.skipif(not is_supported(), reason="only on x86-64 with glibc")
def test_they_are_flushed_inside_and_kept_outside_and_afterwards() -> None:
    assert halved() > 0
    with flushing_subnormals():
        assert halved() == 0
    assert halved() > 0
    with pytest.raises(ValueError, match="inside"), flushing_subnormals():
        raise ValueError("inside")
    assert halved() > 0
    with flushing_subnormals(wanted=False):
        assert halved() > 0


def test_a_run_does_not_depend_on_it_beyond_its_tolerance() -> None:
    simulation = Simulation(
        equation=GranularCompacton(2),
        grid=Grid(60, 200),
        scheme=ConservativeScheme(order=2, grid_viscosity=0.1),
        initial=[Compacton(1, 10)],
        t_end=3,
        frames=3,
        integrator=CVODE(rtol=1e-6),
    )
    flushed, kept = (run(simulation, flush_subnormals=flush).W for flush in (True, False))
    assert float(np.abs(flushed - kept).max()) < 1e-5
    assert halved() > 0
