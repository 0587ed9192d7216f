"""Spatial discretisations: each turns an equation on a grid into a semi-discretisation M y' = f(t, y)."""

from mol_compactons.schemes.base import Scheme, best_scheme
from mol_compactons.schemes.central import CentralScheme
from mol_compactons.schemes.compact import CompactScheme
from mol_compactons.schemes.conservative import ConservativeScheme
from mol_compactons.schemes.fourier import FourierScheme
from mol_compactons.schemes.pade import PadeScheme

__all__ = ["CentralScheme", "CompactScheme", "ConservativeScheme", "FourierScheme", "PadeScheme", "Scheme", "best_scheme"]
