"""mol_compactons: compacton equations by the method of lines.

An equation on a grid is discretised by a scheme into a system of ordinary differential equations, an integrator takes it
through time, and out comes a labelled xarray Dataset, which everything else reads.
"""

from importlib.metadata import version

from mol_compactons import figures
from mol_compactons.analysis import (
    CollisionOver,
    ScalingMap,
    check_up,
    compare,
    continuum_of,
    displacements,
    drift,
    first_collision,
    orbit,
    track,
    two_way_continuum_of,
)
from mol_compactons.chain import (
    ChainCompacton,
    ContactLaw,
    GranularChain,
    Impact,
    NearestNeighbours,
    PowerContact,
    SolitaryWave,
    solitary_profile,
)
from mol_compactons.equations import (
    CustomEquation,
    Equation,
    GranularCompacton,
    Nesterenko,
    PowerLaw,
    PowerLawEquation,
    RosenauHyman,
)
from mol_compactons.errors import InputError, IntegrationError, require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.integrators import CVODE, IDA, Counters, GaussLegendre, Integrator, Midpoint, Rosenbrock, Symplectic
from mol_compactons.results import open_result, open_study, write_tree
from mol_compactons.running import run
from mol_compactons.schemes import CentralScheme, CompactScheme, ConservativeScheme, FourierScheme, PadeScheme, Scheme
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.simulation import Simulation
from mol_compactons.stop_rules import BlowUp, DriftBound, SteadyState, StopRule, WallClock
from mol_compactons.studies import Family, converge, judge, report
from mol_compactons.waves import Compacton, Formula, LocalizedWave, PeriodicWave, Ripple, Samples, Uniform, Wave

__version__ = version("mol_compactons")

__all__ = [
    "CVODE",
    "IDA",
    "BlowUp",
    "CentralScheme",
    "ChainCompacton",
    "CollisionOver",
    "CompactScheme",
    "Compacton",
    "ConservativeScheme",
    "ContactLaw",
    "Counters",
    "CustomEquation",
    "DriftBound",
    "Equation",
    "Family",
    "Formula",
    "FourierScheme",
    "GaussLegendre",
    "GranularChain",
    "GranularCompacton",
    "Grid",
    "Impact",
    "InputError",
    "IntegrationError",
    "Integrator",
    "Lattice",
    "LocalizedWave",
    "Midpoint",
    "NearestNeighbours",
    "Nesterenko",
    "PadeScheme",
    "PeriodicWave",
    "PowerContact",
    "PowerLaw",
    "PowerLawEquation",
    "Ripple",
    "RosenauHyman",
    "Rosenbrock",
    "Samples",
    "ScalingMap",
    "Scheme",
    "SemiDiscretization",
    "Simulation",
    "SolitaryWave",
    "SteadyState",
    "StopRule",
    "Symplectic",
    "Uniform",
    "WallClock",
    "Wave",
    "__version__",
    "check_up",
    "compare",
    "continuum_of",
    "converge",
    "displacements",
    "drift",
    "figures",
    "first_collision",
    "judge",
    "open_result",
    "open_study",
    "orbit",
    "report",
    "require",
    "run",
    "solitary_profile",
    "track",
    "two_way_continuum_of",
    "write_tree",
]
