"""mol_compactons: compacton equations by the method of lines.

An equation on a grid is discretised by a scheme into a system of ordinary differential equations, an integrator takes it
through time, and out comes a labelled xarray Dataset.
"""

from mol_compactons.equations import GranularCompacton
from mol_compactons.errors import InputError, IntegrationError
from mol_compactons.grid import Grid
from mol_compactons.integrators import CVODE, IDA, Midpoint
from mol_compactons.schemes import CompactScheme
from mol_compactons.simulation import Simulation, run
from mol_compactons.waves import Compacton, Samples

__all__ = [
    "CVODE",
    "IDA",
    "CompactScheme",
    "Compacton",
    "GranularCompacton",
    "Grid",
    "InputError",
    "IntegrationError",
    "Midpoint",
    "Samples",
    "Simulation",
    "run",
]
