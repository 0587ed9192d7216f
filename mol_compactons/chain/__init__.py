"""The granular chain: a semi-discretisation by nature, with its contacts, its exact solitary wave and its blows."""

from mol_compactons.chain.chain import GranularChain
from mol_compactons.chain.compacton import ChainCompacton
from mol_compactons.chain.impact import Impact
from mol_compactons.chain.law import ContactLaw, PowerContact
from mol_compactons.chain.nearest_neighbours import NearestNeighbours
from mol_compactons.chain.profile import SolitaryProfile
from mol_compactons.chain.solitary_wave import SolitaryWave, solitary_profile

__all__ = [
    "ChainCompacton",
    "ContactLaw",
    "GranularChain",
    "Impact",
    "NearestNeighbours",
    "PowerContact",
    "SolitaryProfile",
    "SolitaryWave",
    "solitary_profile",
]
