"""Waves: what initial data are made of."""

from mol_compactons.waves.base import LocalizedWave, Wave, superpose
from mol_compactons.waves.compacton import Compacton
from mol_compactons.waves.data import Formula, Samples
from mol_compactons.waves.periodic import PeriodicWave
from mol_compactons.waves.shapes import Ripple, Uniform

__all__ = ["Compacton", "Formula", "LocalizedWave", "PeriodicWave", "Ripple", "Samples", "Uniform", "Wave", "superpose"]
