"""mol_compactons: compacton equations by the method of lines.

An equation on a grid is discretised by a scheme into a system of ordinary differential equations, an integrator takes it
through time, and out comes a labelled xarray Dataset, which everything else reads.

What can be imported from here stands in `__init__.pyi`, and is loaded when it is first asked for.
"""

import logging
from importlib.metadata import version

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

logging.getLogger(__name__).addHandler(logging.NullHandler())  # what is logged is for the caller to show

__version__ = version("mol_compactons")
