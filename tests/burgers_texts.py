"""What several of these tests write and run."""

MODULE = '''
from dataclasses import dataclass
from mol_compactons import *

@dataclass(frozen=True)
class Burgers(Equation):
    """u_t + (u^2 / 2 - nu u_x)_x = 0"""
    nu: float = {nu}
    variables = ("u",)

    def local_flux(self, t, x, state, derivative):
        return state[0] ** 2 / 2 - self.nu * derivative(state[0], 1)

simulation = Simulation(Burgers(), Grid(10, 40), [Uniform(1), Ripple(0.1, periods=1)], t_end=0.1, frames=2)
'''
"""A module of a user's own, with an equation and a scenario."""

REPEAT = ("-m", "mol_compactons", "run", "first.nc", "-o", "again.nc", "--overwrite", "--quiet")
"""The arguments with which Python repeats a result."""
