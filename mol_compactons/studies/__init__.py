"""Studies: many runs of one simulation, here or on other machines, and what they say together."""

from mol_compactons.studies.convergence import converge
from mol_compactons.studies.discretisations import compare_schemes
from mol_compactons.studies.engine import Cluster, Engine, Here, Processes
from mol_compactons.studies.family import Family
from mol_compactons.studies.judgement import judge
from mol_compactons.studies.opening import open_member, open_sweep
from mol_compactons.studies.plan import Axis, Plan, drawn, listed, product, together
from mol_compactons.studies.refining import refine
from mol_compactons.studies.report import report
from mol_compactons.studies.sweep import sweep

__all__ = [
    "Axis",
    "Cluster",
    "Engine",
    "Family",
    "Here",
    "Plan",
    "Processes",
    "compare_schemes",
    "converge",
    "drawn",
    "judge",
    "listed",
    "open_member",
    "open_sweep",
    "product",
    "refine",
    "report",
    "sweep",
    "together",
]
