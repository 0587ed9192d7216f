"""Time integrators: each takes a semi-discretisation M y' = f(t, y) from output time to output time."""

from mol_compactons.integrators.base import Counters, Integration, Integrator, Report
from mol_compactons.integrators.gauss_legendre import GaussLegendre
from mol_compactons.integrators.midpoint import Midpoint
from mol_compactons.integrators.rosenbrock import Rosenbrock
from mol_compactons.integrators.sundials import CVODE, IDA
from mol_compactons.integrators.symplectic import Symplectic

__all__ = [
    "CVODE",
    "IDA",
    "Counters",
    "GaussLegendre",
    "Integration",
    "Integrator",
    "Midpoint",
    "Report",
    "Rosenbrock",
    "Symplectic",
]
