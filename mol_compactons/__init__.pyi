from . import figures
from .analysis import (
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
from .chain import (
    ChainCompacton,
    ContactLaw,
    GranularChain,
    Impact,
    NearestNeighbours,
    PowerContact,
    SolitaryWave,
    solitary_profile,
)
from .equations import (
    CustomEquation,
    Equation,
    GranularCompacton,
    Nesterenko,
    PowerLaw,
    PowerLawEquation,
    RosenauHyman,
)
from .errors import InputError, IntegrationError, require
from .grid import Grid, Lattice
from .integrators import CVODE, IDA, Counters, GaussLegendre, Integrator, Midpoint, Rosenbrock, Symplectic
from .results import open_result, open_study, write_tree
from .running import run
from .schemes import CentralScheme, CompactScheme, ConservativeScheme, FourierScheme, PadeScheme, Scheme
from .semidiscrete import SemiDiscretization
from .simulation import Simulation
from .stop_rules import BlowUp, DriftBound, SteadyState, StopRule, WallClock
from .studies import Family, converge, judge, report
from .waves import Compacton, Formula, LocalizedWave, PeriodicWave, Ripple, Samples, Uniform, Wave

__version__: str

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
