"""Formulas as text: read without running anything, computed by compiled kernels, differentiated exactly."""

from mol_compactons.expressions.pointwise import Pointwise, pointwise
from mol_compactons.expressions.program import Program
from mol_compactons.expressions.syntax import check_name, parse
from mol_compactons.expressions.tree import DERIVATIVES, FUNCTIONS, Node, number

__all__ = ["DERIVATIVES", "FUNCTIONS", "Node", "Pointwise", "Program", "check_name", "number", "parse", "pointwise"]
