"""The command line, a file for each group of commands."""

from mol_compactons.cli.process import program

__all__ = ["program"]
