"""The command that makes films of results."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from mol_compactons.cli.speaking import remark
from mol_compactons.results.form import check_form, reading
from mol_compactons.results.opening import open_result
from mol_compactons.results.places import check_target

if TYPE_CHECKING:
    from mol_compactons.cli.common import Commands


def add_animate(commands: Commands) -> None:
    """The command animate."""
    parser = commands.add_parser(
        "animate",
        help="make a film of one result or several",
        description="Several results stand one below the other, or on one axis with --together; a chain and its continuum are "
        "shown in the coordinates of the chain.",
    )
    parser.add_argument("results", nargs="+", metavar="FILE.nc")
    parser.add_argument(
        "-o", "--output", metavar="FILE.mp4|FILE.gif|FILE.webp", help="where to (default: the first name, .webp)"
    )
    parser.add_argument("--together", action="store_true", help="all results on one axis")
    parser.add_argument("--speed", type=float, default=0.0, metavar="C", help="seen from what moves with this speed")
    parser.add_argument("--rate", type=float, default=25.0, metavar="N", help="pictures for each second (default: 25)")
    parser.add_argument("--most-frames", type=int, default=400, metavar="N", help="how many pictures at most (default: 400)")
    parser.add_argument("--overwrite", action="store_true", help="replace a file that exists")
    parser.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    parser.set_defaults(handle=_animate)


def _animate(options: argparse.Namespace) -> None:
    from mol_compactons.figures import animate

    path = Path(options.output or Path(options.results[0]).with_suffix(".webp"))
    check_target(path, options.overwrite)
    datasets = []
    for name in options.results:
        with reading(name), open_result(Path(name)) as dataset:
            check_form(dataset, name)
            datasets.append(dataset.load())
    count = animate(
        datasets,
        path,
        together=options.together,
        speed=options.speed,
        rate=options.rate,
        most_frames=options.most_frames,
        overwrite=options.overwrite,
        progress=not options.quiet,
    )
    if not options.quiet:
        remark(f"wrote {path}: {count} pictures, {count / options.rate:.3g} s")
