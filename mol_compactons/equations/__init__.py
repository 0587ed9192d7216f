"""Equations: each is a flux, one-way or two-way, perhaps with a source, with what it conserves and its compactons."""

from mol_compactons.equations.base import CosinePower, Derivative, Equation, Linearization
from mol_compactons.equations.custom import CustomEquation
from mol_compactons.equations.flux import DispersiveFlux, Flux, PowerLaw
from mol_compactons.equations.granular import GranularCompacton
from mol_compactons.equations.nesterenko import Nesterenko
from mol_compactons.equations.power_law import PowerLawEquation
from mol_compactons.equations.rosenau_hyman import RosenauHyman

__all__ = [
    "CosinePower",
    "CustomEquation",
    "Derivative",
    "DispersiveFlux",
    "Equation",
    "Flux",
    "GranularCompacton",
    "Linearization",
    "Nesterenko",
    "PowerLaw",
    "PowerLawEquation",
    "RosenauHyman",
]
