"""The command line, a file for each group of commands."""

from mol_compactons.cli.parser import main, program

__all__ = ["main", "program"]
