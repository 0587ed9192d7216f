import logging
import os
import shlex
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

from mol_compactons import (
    CVODE,
    IDA,
    Compacton,
    ConservativeScheme,
    GranularCompacton,
    Grid,
    InputError,
    IntegrationError,
    Midpoint,
    PowerContact,
    Simulation,
    run,
)
from mol_compactons.chain.chain import GranularChain
from mol_compactons.chain.nearest_neighbours import NearestNeighbours
from mol_compactons.grid import Lattice
from mol_compactons.integrators.scales import damping_ratio, order_for_damping
from mol_compactons.integrators.sundials_integration import SundialsIntegration
from mol_compactons.semidiscrete import SemiDiscretization
from tests.systems import Array, one_compacton


def identity_mass(system: SemiDiscretization) -> SemiDiscretization:
    """The same system solved for y': M^-1 f on the right, so that CVODE can take it."""

    def rhs(t: float, state: Array, out: Array) -> None:
        out[:] = system.rate(t, state)

    return replace(system, rhs=rhs, mass=None)


def last_frame(**fields: Any) -> Array:
    return np.asarray(run(one_compacton(size=300, t_end=2, frames=5, **fields)).W.values[-1])


def test_band_sparse_and_midpoint_agree_to_the_tolerances_asked() -> None:
    """The two linear solvers to the tolerance; the midpoint rule approaches them at its own second order."""
    band = last_frame(integrator=IDA(rtol=1e-6))
    sparse = last_frame(integrator=IDA(rtol=1e-6, linear_solver="sparse"))
    assert np.abs(band - sparse).max() < 5e-7
    loose = last_frame(integrator=IDA(rtol=1e-5))
    assert np.abs(band - loose).max() < 1e-5
    coarse, fine = (np.abs(last_frame(integrator=Midpoint(step=step)) - band).max() for step in (0.01, 0.005))
    assert fine < 2e-5
    assert coarse / fine == pytest.approx(4, rel=0.1)


def test_cvode_agrees_with_ida() -> None:
    """On a small ring solved for y'; the dense coupling by M^-1 lies outside the band, so the Jacobian is inexact."""
    simulation = one_compacton(size=60, length=10, t_end=0.5, viscosity=1e-2)
    system, state = simulation.discretize(), simulation.initial_state()
    reference = IDA(rtol=1e-6).start(system, state, 0.5).advance(0.5)
    solved = CVODE(rtol=1e-6).start(identity_mass(system), state, 0.5)
    assert np.abs(solved.advance(0.5) - reference).max() < 1e-6
    assert solved.counters.steps > 0


def test_adams_is_for_the_chain() -> None:
    """On a grid its error does not follow the tolerance; the sentence names what does."""
    with pytest.raises(InputError, match=r"unstable .* choose CVODE\(method='BDF'\), IDA or Rosenbrock"):
        Simulation(
            GranularCompacton(3),
            Grid(30, 80),
            [Compacton(1, 10)],
            t_end=1,
            scheme=ConservativeScheme(4),
            integrator=CVODE(method="Adams"),
        )
    Simulation(GranularChain(PowerContact(1.5)), Lattice(40), [Compacton(1, 20)], t_end=1, integrator=CVODE(method="Adams"))


def test_cvode_refuses_a_mass_matrix() -> None:
    with pytest.raises(InputError, match="cannot take a scheme with a mass matrix; choose IDA, Rosenbrock, Midpoint"):
        one_compacton(integrator=CVODE())


@pytest.mark.parametrize("linear_solver", ["band", "sparse"])
def test_cvode_and_ida_agree_on_the_chain(linear_solver: Literal["band", "sparse"]) -> None:
    chain = Simulation(
        equation=GranularChain(PowerContact(n=2, linear=0.1)),
        grid=Lattice(size=40),
        scheme=NearestNeighbours(),
        initial=[Compacton(speed=1, center=20)],
        t_end=5,
        frames=2,
        integrator=CVODE(rtol=1e-9, linear_solver=linear_solver, max_order=5),
    )
    other = replace(chain, integrator=IDA(rtol=1e-9, max_order=5))
    assert np.abs(run(chain).R[-1] - run(other).R[-1]).max() < 1e-7


def test_a_sparse_run_that_ends_before_it_began_does_not_crash() -> None:
    """SuperLU_MT crashes the process when it is freed before its first factorisation."""
    program = (
        "from tests.systems import one_compacton\n"
        "from mol_compactons import IDA\n"
        "import numpy as np\n"
        "from dataclasses import replace\n"
        "simulation = one_compacton(integrator=IDA(linear_solver='sparse'))\n"
        "system, state = simulation.discretize(), simulation.initial_state()\n"
        "simulation.integrator.start(system, state, 1.0)\n"
        "calls = []\n"
        "def rhs(t, y, out):\n"
        "    calls.append(t)\n"
        "    system.rhs(t, y, out)\n"
        "    if len(calls) == 2: out[:] = np.nan\n"
        "integration = simulation.integrator.start(replace(system, rhs=rhs), state, 1.0)\n"
        "try:\n"
        "    integration.advance(1.0)\n"
        "except Exception as error:\n"
        "    print(type(error).__name__)\n"
        "del integration\n"
    )
    root = Path(__file__).parent.parent.parent
    done = subprocess.run([sys.executable, "-c", program], cwd=root, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "IntegrationError\n"), done.stderr


def test_a_solver_is_let_go_with_its_run() -> None:
    """Once it has factored a matrix a sparse one is held by no more than a banded one."""
    holders = []
    for linear_solver in ("band", "sparse"):
        simulation = one_compacton(integrator=IDA(linear_solver=linear_solver))
        integration = simulation.integrator.start(simulation.discretize(), simulation.initial_state(), 1.0)
        integration.advance(0.1)
        assert isinstance(integration, SundialsIntegration)
        holders.append(sys.getrefcount(integration._solver))
    assert holders[0] == holders[1]


def test_frames_do_not_change_the_steps() -> None:
    """The solver steps on its own and the frames are interpolated: more frames cost nothing and change nothing."""
    few = run(one_compacton(t_end=1, frames=3))
    many = run(one_compacton(t_end=1, frames=21))
    assert np.array_equal(few.W.sel(t=1), many.W.sel(t=1))
    assert few.attrs["solver_steps"] == many.attrs["solver_steps"]


@pytest.mark.parametrize("linear_solver", ["band", "sparse"])
def test_counters_count(linear_solver: Literal["band", "sparse"]) -> None:
    calls = {"f": 0, "J": 0}
    simulation = one_compacton(integrator=IDA(linear_solver=linear_solver))
    system = simulation.discretize()

    def rhs(t: float, state: Array, out: Array) -> None:
        calls["f"] += 1
        system.rhs(t, state, out)

    def jacobian(t: float, state: Array, out: Array) -> None:
        calls["J"] += 1
        system.jacobian(t, state, out)

    counted = replace(system, rhs=rhs, jacobian=jacobian)
    integration = simulation.integrator.start(counted, simulation.initial_state(), 1.0)
    integration.advance(1.0)
    # One more f for the initial rate; one more J for the choice of the order.
    assert integration.counters.evaluations == calls["f"] - 1
    if linear_solver == "sparse":
        assert integration.counters.jacobians == calls["J"] - 1
    assert 0 < integration.counters.steps < calls["f"]


@pytest.mark.parametrize(("viscosity", "size", "order"), [(0.0, 600, 2), (1e-5, 600, 2), (1e-3, 600, 2), (1e-2, 600, 5)])
def test_the_order_follows_the_damping(viscosity: float, size: int, order: int) -> None:
    simulation = one_compacton(viscosity=viscosity, size=size)
    ratio = damping_ratio(simulation.discretize(), simulation.initial_state())
    assert order_for_damping(ratio) == order


def test_without_viscosity_order_2_is_chosen_and_does_not_crawl() -> None:
    """Orders 3 to 5 are unstable on a nearly imaginary spectrum: the same run takes many times the steps."""
    undamped = replace(one_compacton(size=300, viscosity=0.0), integrator=IDA(rtol=1e-3))
    chosen, highest = (run(replace(undamped, integrator=IDA(rtol=1e-3, max_order=order))) for order in (None, 5))
    assert chosen.attrs["solver_steps"] < highest.attrs["solver_steps"] / 5


def test_a_solver_that_gives_up_says_why_and_keeps_its_frames() -> None:
    """Without viscosity the nearest-neighbour difference blows up at the edges of the compacton."""
    simulation = one_compacton(size=600, t_end=2, frames=21, second_difference="nearest", viscosity=0.0)
    simulation = replace(simulation, integrator=IDA(max_steps=800))
    with pytest.raises(IntegrationError, match=r"gave up at t = .*; raise integrator.max_steps, or loosen") as failure:
        run(simulation)
    assert failure.value.dataset is not None
    assert 0 < failure.value.dataset.sizes["t"] < 21
    assert failure.value.dataset.attrs["status"].startswith("failed at t = ")
    assert np.isfinite(failure.value.dataset.W).all()


def test_nan_is_an_error_and_never_a_result() -> None:
    simulation = one_compacton()
    system = simulation.discretize()

    def rhs(t: float, state: Array, out: Array) -> None:
        system.rhs(t, state, out)
        if t > 0.1:
            out[:] = np.nan

    integration = IDA().start(replace(system, rhs=rhs), simulation.initial_state(), 1.0)
    with pytest.raises(IntegrationError, match="not finite") as failure:
        integration.advance(1.0)
    assert 0 < failure.value.t <= 0.1


def test_every_line_of_other_threads_arrives(capfd: pytest.CaptureFixture[str]) -> None:
    """Printed, logged, or written by C, also by the right-hand side itself; none of them counts as a warning of the solver."""
    simulation = one_compacton(size=60, length=10)
    system, state = simulation.discretize(), simulation.initial_state()
    integrations, ended = [], threading.Event()

    def rhs(t: float, state: Array, out: Array) -> None:
        if t == 0.0:
            sys.stdout.write("from the right-hand side\n")
        system.rhs(t, state, out)

    def integrate(integrator: IDA | CVODE) -> None:
        own = replace(system, rhs=rhs) if isinstance(integrator, IDA) else identity_mass(replace(system, rhs=rhs))
        while not ended.is_set():
            integrations.append(integrator.start(own, state, 0.05))
            integrations[-1].advance(0.05)

    at_work = [threading.Thread(target=integrate, args=(one,)) for one in (IDA(), CVODE(), IDA(linear_solver="sparse"))]
    for thread in at_work:
        thread.start()
    handler = logging.StreamHandler()
    for index in range(70):
        sys.stdout.write(f"printed {index}\n")
        handler.handle(logging.makeLogRecord({"msg": f"logged {index}"}))
        os.write(2, f"written {index}\n".encode())
        time.sleep(2e-3)
    ended.set()
    for thread in at_work:
        thread.join()
    out, err = (text.splitlines() for text in capfd.readouterr())
    assert [line for line in out if line.startswith("printed")] == [f"printed {index}" for index in range(70)]
    assert set(out) == {f"printed {index}" for index in range(70)} | {"from the right-hand side"}
    assert err == [f"{how} {index}" for index in range(70) for how in ("logged", "written")]
    assert len(integrations) > 3
    assert {one.counters.warnings for one in integrations} == {0}


WALL = """
import sys
import numpy as np
from mol_compactons import CVODE, IDA, IntegrationError
from mol_compactons.semidiscrete import SemiDiscretization

rng = np.random.default_rng(0)

def wall(t, y, out):
    out[:] = -y if t < 0.5 else 1e100 * rng.random(y.shape)

said = []
for integrator in (CVODE(max_steps=700), IDA(rtol=1e-2, max_steps=700)):
    system = SemiDiscretization(5, 1, 0, rhs=wall, invariants=lambda state: {})
    integration = integrator.start(system, np.ones((1, 5)), 2.0)
    try:
        integration.advance(2.0)
    except IntegrationError as error:
        said.append(f"{integration.counters.warnings} {integration.counters.first_warning[:9]} {error}")
open(sys.argv[1], "w").write("\\n".join(said))
"""


@pytest.mark.parametrize("streams", ["", "2>&- >/dev/full"])
def test_streams_that_are_full_or_closed_end_no_run_and_hear_nothing(streams: str, tmp_path: Path) -> None:
    """Where the solver warns, and gives up; what it said is counted all the same."""
    command = f"{shlex.join([sys.executable, '-c', WALL, str(tmp_path / 'said')])} {streams}"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    first, second = (tmp_path / "said").read_text().split("\n")
    assert first.startswith("11 [WARNING] CVODE gave up at t = 0.5: it did not reach")
    assert second.startswith("1 [IDAHandl IDA gave up at t = 0.5")
    assert [path.name for path in tmp_path.iterdir()] == ["said"]


def test_an_integration_that_has_ended_says_so() -> None:
    simulation = one_compacton(size=60, length=10)
    integration = IDA().start(simulation.discretize(), simulation.initial_state(), 0.2)
    early = integration.advance(0.1)
    final = integration.advance(0.2)
    assert np.array_equal(integration.advance(0.2), final)
    assert not np.array_equal(early, final)
    with pytest.raises(IntegrationError, match=r"ended at t = 0\.2.* cannot go to t = 0\.3"):
        integration.advance(0.3)


def test_a_report_that_raises_ends_an_integration() -> None:
    def interrupt(t: float) -> None:
        raise KeyboardInterrupt

    simulation = one_compacton(size=60, length=10)
    integration = IDA().start(simulation.discretize(), simulation.initial_state(), 0.2)
    with pytest.raises(KeyboardInterrupt):
        integration.advance(0.1, interrupt)
    with pytest.raises(IntegrationError, match="ended at t"):
        integration.advance(0.2)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"rtol": 0}, "must lie between 1e-15 and 0.1"),
        ({"rtol": 1}, "must lie between 1e-15 and 0.1"),
        ({"atol": 0}, "atol = 0.0 must be above 1e-100"),
        ({"max_order": 6}, "max_order = 6 must lie between 1 and 5"),
        ({"max_step": -1}, "max_step = -1.0 must be positive"),
        ({"max_steps": 0}, "must lie between 1 and"),
        ({"linear_solver": "dense"}, "one of 'band', 'sparse'"),
    ],
)
@pytest.mark.parametrize("integrator", [IDA, CVODE])
def test_bad_settings_are_named(integrator: type[IDA] | type[CVODE], fields: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        integrator(**fields)
