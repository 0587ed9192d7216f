"""The command that writes a page."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from mol_compactons.cli.common import add_import
from mol_compactons.cli.scenarios import import_module
from mol_compactons.cli.speaking import remark
from mol_compactons.results.places import check_target

if TYPE_CHECKING:
    from mol_compactons.cli.common import Commands


def add_report(commands: Commands) -> None:
    """The command report."""
    parser = commands.add_parser(
        "report",
        help="write a page that shows a result, a study or a sweep",
        description="One HTML file that needs no network: what moves, what was kept, what contradicts what is known.",
    )
    parser.add_argument("result", metavar="FILE.nc|FOLDER")
    parser.add_argument("continuum", nargs="?", metavar="CONTINUUM.nc", help="the continuum of a chain, shown beside it")
    parser.add_argument("-o", "--output", metavar="FILE.html", help="where to (default: the result's name, .html)")
    parser.add_argument("--overwrite", action="store_true", help="replace a file that exists")
    add_import(parser)
    parser.set_defaults(handle=_report)


def _report(options: argparse.Namespace) -> None:
    from mol_compactons.pages import write_report

    for module in options.imports:
        import_module(module)
    result = Path(options.result)
    path = (
        Path(options.output) if options.output else result.with_name(f"{result.name if result.is_dir() else result.stem}.html")
    )
    check_target(path, options.overwrite)
    write_report(result, path, continuum=options.continuum, overwrite=options.overwrite)
    remark(f"wrote {path}: {path.stat().st_size / 1e6:.1f} MB")
