"""The command that finds the orbit of a wave and its Floquet multipliers."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from mol_compactons.analysis.wave_orbits import orbit, report_orbit
from mol_compactons.cli.common import add_scenario, save, simulation_of
from mol_compactons.cli.speaking import remark, tell
from mol_compactons.errors import InputError
from mol_compactons.results.opening import write_tree
from mol_compactons.results.places import check_target

if TYPE_CHECKING:
    from mol_compactons.cli.common import Commands


def add_orbit(commands: Commands) -> None:
    """The command orbit."""
    parser = commands.add_parser("orbit", help="the Floquet multipliers of a travelling wave on its grid or chain")
    add_scenario(parser)
    parser.add_argument("--steps", type=int, default=10, metavar="K", help="Gauss-Legendre steps for each cell (default 10)")
    parser.add_argument("--order", type=int, default=4, choices=(4, 6), help="the order of these steps (default 4)")
    parser.add_argument("--speed", type=float, metavar="C", help="the speed, for initial data that do not know it")
    parser.add_argument(
        "--around",
        choices=("ring", "window"),
        help="follow small changes around the whole ring (default for a grid), or near the wave only (default for a chain), "
        "so that what it leaves behind does not come back",
    )
    parser.add_argument("-o", "--output", metavar="FILE.nc|FILE.png", help="store the wave and its multipliers, or draw them")
    parser.add_argument("--overwrite", action="store_true", help="replace a file that exists")
    parser.set_defaults(handle=_orbit)


def _orbit(options: argparse.Namespace) -> None:
    from mol_compactons.figures import orbit_overview

    simulation = simulation_of(options)
    path = Path(options.output) if options.output else None
    if path:
        check_target(path, options.overwrite)
        if path.suffix.lower() not in (".nc", ".png"):
            raise InputError(f"{path} must end in .nc, to store the orbit, or .png, to draw it.")
    dataset = orbit(
        simulation,
        steps=options.steps,
        order=options.order,
        around=options.around,
        speed=options.speed,
    )
    (remark if path else tell)(*report_orbit(dataset))
    if not path:
        return
    if path.suffix.lower() == ".png":
        save(orbit_overview(dataset), path)
        return
    write_tree(dataset, path)
    remark(f"wrote {path}")
