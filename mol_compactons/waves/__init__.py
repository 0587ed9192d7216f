"""Waves: what initial data are made of."""

from mol_compactons.waves.base import LocalizedWave, Wave, superpose
from mol_compactons.waves.compacton import Compacton
from mol_compactons.waves.data import Ripple, Samples, Uniform
from mol_compactons.waves.periodic import PeriodicWave

__all__ = ["Compacton", "LocalizedWave", "PeriodicWave", "Ripple", "Samples", "Uniform", "Wave", "superpose"]
