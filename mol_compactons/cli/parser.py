"""The command line: its parser, and what becomes of errors."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from importlib.metadata import version
from typing import Any, NoReturn

from mol_compactons.cli.looking import add_doctor, add_info, add_plot, add_scenarios, add_track
from mol_compactons.cli.orbits import add_orbit
from mol_compactons.cli.running import add_run
from mol_compactons.cli.studies import add_converge, add_stability
from mol_compactons.errors import InputError, IntegrationError
from mol_compactons.runtime.compiled import announcing_compilation


class Parser(argparse.ArgumentParser):
    """An argument parser whose complaint is one sentence."""

    def error(self, message: str) -> NoReturn:
        """Complain and leave with status 2."""
        print(f"{self.prog}: {message}; see {self.prog} --help.", file=sys.stderr)
        raise SystemExit(2)


def parser() -> Parser:
    """The parser of the command line."""
    main = Parser(prog="mol-compactons", description="Compacton equations by the method of lines.")
    main.add_argument("--version", action="version", version=f"%(prog)s {version('mol_compactons')}")
    commands: Any = main.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for add in (add_run, add_info, add_plot, add_track, add_doctor, add_converge, add_stability, add_orbit, add_scenarios):
        add(commands)
    return main


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line, and return the exit status.

    That is 0 if all is fine, 1 if the solver gave up or a check-up found a contradiction, 2 for bad input, 130 if interrupted.
    """
    options = parser().parse_args(arguments)
    status: int | None = None
    try:
        with nullcontext() if getattr(options, "quiet", False) else announcing_compilation(_say_that_it_compiles):
            status = options.handle(options)
        sys.stdout.flush()
    except InputError as error:
        print(f"mol-compactons: {error}", file=sys.stderr)
        return 2
    except IntegrationError as error:
        print(f"mol-compactons: {error}", file=sys.stderr)
        return 1
    except MemoryError:
        print("mol-compactons: there is not enough memory; choose a smaller grid.size.", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        kept = "the frames written so far are kept" if options.command == "run" else "nothing was written"
        print(f"mol-compactons: interrupted; {kept}.", file=sys.stderr)
        return 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return status or 0


def _say_that_it_compiles() -> None:
    print("compiling the kernels, which takes some seconds and is done once", flush=True)
