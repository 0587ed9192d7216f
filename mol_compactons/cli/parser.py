"""The command line: its parser, and what becomes of errors."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from typing import Any, NoReturn

import shtab

from mol_compactons.cli.examples import ExamplesFormatter, examples_of
from mol_compactons.cli.films import add_animate
from mol_compactons.cli.looking import add_doctor, add_info, add_plot, add_track
from mol_compactons.cli.orbits import add_orbit
from mol_compactons.cli.reports import add_report
from mol_compactons.cli.running import add_run
from mol_compactons.cli.speaking import ListenerLostError, complain, logging_to_stderr, remark, tell
from mol_compactons.cli.starting import add_new, add_scenarios
from mol_compactons.cli.studies import add_converge, add_stability
from mol_compactons.cli.sweeps import add_sweep
from mol_compactons.errors import InputError, IntegrationError, shown
from mol_compactons.results.schema import source
from mol_compactons.runtime.compiled import announcing_compilation

TRACEBACK = "MOL_COMPACTONS_TRACEBACK"
"""The variable of the environment that asks for the traceback of an error that nobody foresaw."""

BROKEN_PIPE = 13
"""The number of the signal that ends a program without a listener."""


class Parser(argparse.ArgumentParser):
    """An argument parser whose complaint is one sentence."""

    def error(self, message: str) -> NoReturn:
        """Complain and leave with status 2."""
        complain(f"{message}; see {self.prog} --help.")
        raise SystemExit(2)


class _Version(argparse.Action):
    """Say which versions run; SUNDIALS is asked only then."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        tell(source())
        raise SystemExit(0)


def parser() -> Parser:
    """The parser of the command line."""
    main = Parser(prog="mol-compactons", description="Compacton equations by the method of lines.")
    main.add_argument("--version", action=_Version, nargs=0, help="say which versions of this program and its libraries run")
    shtab.add_argument_to(
        main, "--print-completion", help="print the completion for a shell, to be put where that looks for it"
    )
    main.add_argument("-v", "--verbose", action="count", default=0, help="tell what goes on; -vv tells of checkpoints too")
    commands: Any = main.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for add in (
        add_run,
        add_info,
        add_plot,
        add_animate,
        add_report,
        add_track,
        add_doctor,
        add_converge,
        add_sweep,
        add_stability,
        add_orbit,
        add_scenarios,
        add_new,
    ):
        add(commands)
    for name, command in commands.choices.items():
        command.epilog, command.formatter_class = examples_of(name), ExamplesFormatter
    return main


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line, and return the exit status.

    That is 0 if all is fine, 1 if the solver gave up or a check-up found a contradiction, 2 for bad input, 3 for an error that
    nobody foresaw, 128 and the number of the signal if one ended it, and 141 if nobody listened to what was asked for.
    """
    try:
        options = parser().parse_args(typed() if arguments is None else arguments)
        silent = getattr(options, "quiet", False)
        with nullcontext() if silent else announcing_compilation(_say_that_it_compiles), logging_to_stderr(options.verbose):
            return options.handle(options) or 0
    except ListenerLostError:
        return 128 + BROKEN_PIPE
    except InputError as error:
        complain(str(error))
        return 2
    except IntegrationError as error:
        complain(str(error))
        return 1
    except MemoryError:
        complain("there is not enough memory; choose a smaller grid.size or fewer frames.")
        return 2
    except KeyboardInterrupt as interrupt:
        complain(f"interrupted; {getattr(interrupt, 'kept', 'nothing was written.')}")
        return 128 + getattr(interrupt, "number", signal.SIGINT)
    except Exception as error:
        if os.environ.get(TRACEBACK):
            raise
        if isinstance(error, OSError) and error.filename is not None:
            complain(f"{shown(error.filename)} cannot be used: {error.strerror}; choose another name or place.")
            return 2
        complain(
            f"an error that was not foreseen ({type(error).__name__}: {error}); set {TRACEBACK}=1 to see where, and report it."
        )
        return 3


def typed() -> list[str]:
    """What was typed, as UTF-8 also where the locale knows only ASCII."""
    return [os.fsencode(word).decode("utf-8", "surrogateescape") for word in sys.argv[1:]]


def _say_that_it_compiles() -> None:
    remark("compiling the kernels, which takes some seconds and is done once")
