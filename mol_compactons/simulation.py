"""One simulation: what is solved, where, how, from what and how long; and `run`, which does it."""

from __future__ import annotations

import json
import signal
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.chain import GranularChain, NearestNeighbours
from mol_compactons.chain_waves import SolitaryWave
from mol_compactons.configuration import check, decode, encode
from mol_compactons.equations import GranularCompacton, PowerLawEquation, RosenauHyman
from mol_compactons.errors import InputError, IntegrationError, require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.integrators import CVODE, IDA, Midpoint, Rosenbrock, Symplectic
from mol_compactons.integrators.progress import Report, no_report
from mol_compactons.nesterenko import Nesterenko
from mol_compactons.periodic_waves import PeriodicWave
from mol_compactons.schemes import CompactScheme, ConservativeScheme, FourierScheme
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.subnormals import flushing_subnormals
from mol_compactons.waves import Compacton, Impact, Ripple, Samples, Uniform, superpose

if TYPE_CHECKING:
    import xarray as xr

Equation = GranularCompacton | RosenauHyman | Nesterenko | PowerLawEquation | GranularChain
Scheme = CompactScheme | ConservativeScheme | FourierScheme | NearestNeighbours
Wave = Compacton | SolitaryWave | PeriodicWave | Impact | Samples | Uniform | Ripple
Integrator = IDA | CVODE | Midpoint | Rosenbrock | Symplectic

MOST_FRAMES = 10**7
"""The largest number of output times."""


@dataclass(frozen=True)
class Simulation:
    """An equation on a grid, discretised by a scheme, from exact waves at t = 0 to t_end.

    Parameters
    ----------
    equation, grid, scheme
        A continuous equation on a Grid with its discretisation, or a chain on its Lattice with the differences that belong
        to it; which of them go together is for ``scheme.discretize`` to say. By default the scheme is the one that is best for
        the granular compacton equation, ``ConservativeScheme(order=4, grid_viscosity=0.03, viscosity_order=6)``; see
        docs/schemes.md.
    initial : list of waves
        Their sum is the state at t = 0. The supports of compactons must not overlap.
    t_end : float
        The last time, nondimensional.
    frames : int
        Number of output times, equally spaced from 0 to t_end, both included.
    integrator
        The time integrator.
    title : str
        One line that says what this is.

    Raises
    ------
    InputError
        If a value is out of range, or the parts do not fit together.

    Examples
    --------
    >>> simulation = Simulation(
    ...     equation=GranularCompacton(n=3),
    ...     grid=Grid(length=30, size=120),
    ...     initial=[Compacton(speed=1, center=5.5)],
    ...     t_end=1,
    ...     frames=3,
    ... )
    >>> dataset = run(simulation)
    >>> dataset.W.dims, dataset.sizes["x"], dataset.attrs["status"]
    (('t', 'x'), 120, 'complete')
    """

    equation: Equation
    grid: Grid | Lattice
    initial: Sequence[Wave]
    t_end: float
    scheme: Scheme = field(default_factory=lambda: ConservativeScheme(order=4, grid_viscosity=0.03, viscosity_order=6))
    frames: int = 101
    integrator: Integrator = field(default_factory=IDA)
    title: str = ""

    def __post_init__(self) -> None:
        check(self)
        require(1e-9 <= self.t_end <= 1e12, f"t_end = {self.t_end:g} must lie between 1e-9 and 1e12.")
        require(
            2 <= self.frames <= MOST_FRAMES,
            f"frames = {self.frames:.16g} must lie between 2, the first and the last time, and {MOST_FRAMES}.",
        )
        self.integrator.check_system(self.discretize())
        self.initial_state()

    def discretize(self) -> SemiDiscretization:
        """The system of ordinary differential equations."""
        return self.scheme.discretize(self.equation, self.grid)

    def initial_state(self) -> NDArray[np.float64]:
        """The state at t = 0, shape (components, size)."""
        return superpose(self.initial, self.equation, self.grid)

    @property
    def times(self) -> NDArray[np.float64]:
        """The output times, shape (frames,)."""
        return np.linspace(0.0, self.t_end, self.frames)

    def to_json(self) -> str:
        """The simulation as JSON, from which `from_json` makes it again, bit for bit."""
        return json.dumps(encode(self))

    @classmethod
    def from_json(cls, text: str) -> Simulation:
        """The inverse of `to_json`.

        Raises
        ------
        InputError
            If the text is not the JSON of a valid simulation.
        """
        try:
            data = json.loads(text)
        except json.JSONDecodeError as error:
            raise InputError(f"The text is not JSON ({error}); give what Simulation.to_json() returned.") from None
        simulation = decode(cls, data)
        require(isinstance(simulation, cls), "The JSON does not describe a Simulation.")
        return simulation  # type: ignore[no-any-return]


def run(
    simulation: Simulation,
    path: str | Path | None = None,
    *,
    overwrite: bool = False,
    report: Report = no_report,
    flush_subnormals: bool = True,
) -> xr.Dataset:
    """Integrate a simulation and return its frames as a labelled Dataset.

    Parameters
    ----------
    simulation : Simulation
        What to run.
    path : str or Path, optional
        A NetCDF file. Frames stream into it while the run goes on, and the Dataset returned reads from it lazily. Without
        a path the frames stay in memory.
    overwrite : bool
        Whether a file that exists may be replaced.
    report : callable, optional
        Called now and then with the time reached.
    flush_subnormals : bool
        Whether numbers below 2.2e-308 count as zero during the run, where the machine allows it.

    Returns
    -------
    xarray.Dataset
        The components (t, x), the conserved quantities (t), and in its attributes the simulation, the status and the
        cost.

    Raises
    ------
    InputError
        If the file cannot be written, or the integrator cannot take the system; nothing is written then.
    IntegrationError
        If the integrator gives up. The frames up to there are in the file, or in the error's attribute `dataset`.
    """
    from mol_compactons.dataset import MemoryRecorder, cost_attributes
    from mol_compactons.store import NetCDFRecorder

    system = simulation.discretize()
    state = simulation.initial_state()
    integration = simulation.integrator.start(system, state, simulation.t_end)
    conserved = list(system.invariants(state))
    recorder = (
        MemoryRecorder(simulation, conserved) if path is None else NetCDFRecorder(simulation, conserved, Path(path), overwrite)
    )
    started = time.process_time()
    status, failure = "interrupted at t = 0", None
    try:
        recorder.append(0.0, state, system.invariants(state))
        with stopping_on_signals(report) as watch, flushing_subnormals(flush_subnormals):
            watch(0.0)
            for t in simulation.times[1:]:
                state = integration.advance(t, watch)
                recorder.append(t, state, system.invariants(state))
                status = f"interrupted at t = {t:.6g}"
        status = "complete"
    except IntegrationError as error:
        status, failure = f"failed at t = {error.t:.6g}: {error}", error
    finally:
        recorder.close(cost_attributes(status, integration.counters, time.process_time() - started))
    if failure:
        raise IntegrationError(str(failure), failure.t, recorder.dataset())
    return recorder.dataset()


@contextmanager
def stopping_on_signals(report: Report) -> Iterator[Report]:
    """A report that raises KeyboardInterrupt after SIGINT or SIGTERM, between two steps and never inside the solver."""
    if threading.current_thread() is not threading.main_thread():
        yield report
        return
    caught: list[int] = []
    before = {number: signal.signal(number, lambda n, _: caught.append(n)) for number in (signal.SIGINT, signal.SIGTERM)}

    def watch(t: float) -> None:
        report(t)
        if caught:
            raise KeyboardInterrupt

    try:
        yield watch
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
