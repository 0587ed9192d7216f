"""What is made of a result: where its waves are, what collisions did to them, how well it kept what is conserved, and more."""

from mol_compactons.analysis.chain_and_continuum import compare, continuum_of, two_way_continuum_of
from mol_compactons.analysis.checkup import Finding, check_up
from mol_compactons.analysis.collisions import first_collision
from mol_compactons.analysis.displacements import displacements
from mol_compactons.analysis.drift import drift
from mol_compactons.analysis.scaling import ScalingMap
from mol_compactons.analysis.stop_rules import CollisionOver
from mol_compactons.analysis.tracking import track
from mol_compactons.analysis.wave_orbits import orbit

__all__ = [
    "CollisionOver",
    "Finding",
    "ScalingMap",
    "check_up",
    "compare",
    "continuum_of",
    "displacements",
    "drift",
    "first_collision",
    "orbit",
    "track",
    "two_way_continuum_of",
]
