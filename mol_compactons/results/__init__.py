"""Results: what they look like, where a run writes them, how it goes on from them, and how they are read."""

from mol_compactons.results.opening import open_result, open_study, write_tree
from mol_compactons.results.reading import arranged, conserved_names, field_names, grid_of

__all__ = ["arranged", "conserved_names", "field_names", "grid_of", "open_result", "open_study", "write_tree"]
