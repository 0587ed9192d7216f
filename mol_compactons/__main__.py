"""`python -m mol_compactons` is the command line."""

from mol_compactons.cli import program

if __name__ == "__main__":
    raise SystemExit(program())
