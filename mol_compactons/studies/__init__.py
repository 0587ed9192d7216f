"""Studies: many runs of one simulation, and what they say together."""

from mol_compactons.studies.convergence import converge
from mol_compactons.studies.family import Family
from mol_compactons.studies.judgement import judge
from mol_compactons.studies.report import report

__all__ = ["Family", "converge", "judge", "report"]
