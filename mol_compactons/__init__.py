"""mol_compactons: compacton equations by the method of lines.

An equation on a grid is discretised by a scheme into a system of ordinary differential equations, an integrator takes it
through time, and out comes a labelled xarray Dataset.
"""

from mol_compactons.chain import GranularChain, NearestNeighbours
from mol_compactons.chain_waves import SolitaryWave
from mol_compactons.equations import GranularCompacton, PowerLawEquation, RosenauHyman
from mol_compactons.errors import InputError, IntegrationError
from mol_compactons.flux import PowerLaw
from mol_compactons.grid import Grid, Lattice
from mol_compactons.integrators import CVODE, IDA, Midpoint, Rosenbrock, Symplectic
from mol_compactons.nesterenko import Nesterenko
from mol_compactons.periodic_waves import PeriodicWave
from mol_compactons.scaling import ScalingMap
from mol_compactons.schemes import CompactScheme, ConservativeScheme, FourierScheme
from mol_compactons.simulation import Simulation, run
from mol_compactons.waves import Compacton, Impact, Ripple, Samples, Uniform

__all__ = [
    "CVODE",
    "IDA",
    "CompactScheme",
    "Compacton",
    "ConservativeScheme",
    "FourierScheme",
    "GranularChain",
    "GranularCompacton",
    "Grid",
    "Impact",
    "InputError",
    "IntegrationError",
    "Lattice",
    "Midpoint",
    "NearestNeighbours",
    "Nesterenko",
    "PeriodicWave",
    "PowerLaw",
    "PowerLawEquation",
    "Ripple",
    "RosenauHyman",
    "Rosenbrock",
    "Samples",
    "ScalingMap",
    "Simulation",
    "SolitaryWave",
    "Symplectic",
    "Uniform",
    "run",
]
