"""The command that runs a scenario."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from mol_compactons.cli.common import add_scenario, contents, cost, kept, progress_bar, simulation_of
from mol_compactons.errors import InputError
from mol_compactons.results.netcdf import check_target
from mol_compactons.running import run

if TYPE_CHECKING:
    from mol_compactons.cli.common import Commands


def add_run(commands: Commands) -> None:
    """The command run."""
    parser = commands.add_parser("run", help="integrate a scenario, or repeat a result, into a NetCDF file")
    add_scenario(parser)
    parser.add_argument("-o", "--output", metavar="FILE.nc", help="where to write (default: the scenario's name)")
    parser.add_argument("--overwrite", action="store_true", help="replace a file that exists")
    parser.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    parser.set_defaults(handle=_run)


def _run(options: argparse.Namespace) -> None:
    simulation = simulation_of(options)
    path = Path(options.output or f"{Path(options.scenario).stem}.nc")
    check_target(path, options.overwrite)
    if path.suffix.lower() != ".nc":
        raise InputError(f"{path} must end in .nc: a result is a NetCDF file.")
    with progress_bar(simulation.t_end, options.quiet) as report:
        dataset = run(simulation, path, overwrite=options.overwrite, report=report)
    if not options.quiet:
        print(f"wrote {path}: {contents(dataset)}", kept(dataset), cost(dataset), sep="\n")
    dataset.close()
