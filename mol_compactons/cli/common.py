"""What the commands share: options, fields set by text, writing pictures, and results in a line."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from mol_compactons.assignment import assign
from mol_compactons.cli.scenarios import import_module, load
from mol_compactons.cli.speaking import remark
from mol_compactons.errors import LONGEST_SHOWN, InputError, shown
from mol_compactons.results.places import written_whole
from mol_compactons.simulation import Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mol_compactons.studies.engine import Engine

    Commands = argparse._SubParsersAction[argparse.ArgumentParser]

SET_HELP = (
    "change a field: grid.size=1200, integrator='Rosenbrock(rtol=1e-6)'; a class takes its defaults for what is not said, not "
    "the values of the one it replaces"
)

SCENARIO_HELP = "a script, the name of a scenario, or a result"


def add_scenario(parser: argparse.ArgumentParser) -> None:
    """The argument and the options of commands that run a scenario."""
    parser.add_argument("scenario", metavar="SCENARIO.py|RESULT.nc", help=SCENARIO_HELP)
    parser.add_argument("--set", dest="changes", action="append", default=[], metavar="FIELD=VALUE", help=SET_HELP)
    add_import(parser)


def add_import(parser: argparse.ArgumentParser) -> None:
    """The option of commands that read or name classes of the user's own."""
    parser.add_argument(
        "--import", dest="imports", action="append", default=[], metavar="MODULE", help="import a module of your own first"
    )


def add_workers(parser: argparse.ArgumentParser) -> None:
    """The options of commands that run many simulations."""
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", type=int, metavar="N", help="how many processes run members (default: one for each core)")
    where.add_argument("--scheduler", metavar="ADDRESS", help="run members on a Dask cluster: tcp://host:8786")


def engine_of(options: argparse.Namespace) -> Engine:
    """Where members are to run."""
    from mol_compactons.studies.engine import Cluster, Here, Processes

    if options.scheduler is not None:
        return Cluster(options.scheduler)
    return Here() if options.workers == 1 else Processes(options.workers)


def simulation_of(options: argparse.Namespace) -> Simulation:
    """The simulation that a command was asked for, with its changes."""
    for module in options.imports:
        import_module(module)
    return assign(load(options.scenario), assignments(options.changes), import_module)


def assignments(changes: list[str]) -> dict[str, str]:
    """FIELD=VALUE as a mapping."""
    result = {}
    for change in changes:
        field, equals, value = change.partition("=")
        if not equals:
            raise InputError(f"{shown(change)} lacks a value; write FIELD=VALUE.")
        if field.strip() in result:
            raise InputError(f"{field.strip()[:LONGEST_SHOWN]} is given twice; give it once.")
        result[field.strip()] = value
    return result


def save(figure: Figure, path: Path, say: bool = True) -> None:
    """Write a picture, and say so."""
    allowed = figure.canvas.get_supported_filetypes()
    if path.suffix.lstrip(".").lower() not in allowed:
        raise InputError(f"{path} has no picture format; end its name in {', '.join(sorted(allowed))}.")
    with written_whole(path) as part:
        figure.savefig(part, dpi=150)
    if say:
        remark(f"wrote {path}")
