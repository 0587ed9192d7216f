"""The commands with which one starts: the scenarios that there are, and a script of one's own."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from mol_compactons.cli.scenarios import folder, listing
from mol_compactons.cli.speaking import remark, tell
from mol_compactons.configuration import did_you_mean
from mol_compactons.errors import require
from mol_compactons.results.places import check_target, written_whole

if TYPE_CHECKING:
    from mol_compactons.cli.common import Commands

TEMPLATE = '''"""One line that says what this is.

    mol-compactons run {file}              # writes {stem}.nc
    python {file}                          # the same, and a picture
"""

from mol_compactons import Compacton, GranularCompacton, Grid, Simulation, run

simulation = Simulation(
    title="My first collision",
    equation=GranularCompacton(n=3),  # W_t + ... with contacts whose force goes like the n-th power
    grid=Grid(length=60, size=600),  # a periodic line
    initial=[Compacton(speed=1, center=8), Compacton(speed=0.25, center=20)],
    t_end=40,
    frames=201,
)

if __name__ == "__main__":
    from mol_compactons.figures import overview

    dataset = run(simulation, "{stem}.nc", overwrite=True)
    overview(dataset).savefig("{stem}.png")
    print(dataset)
'''
"""What `new` writes."""


def add_scenarios(commands: Commands) -> None:
    """The command scenarios."""
    parser = commands.add_parser("scenarios", help="list the scenarios that come with the package, or print one")
    parser.add_argument("name", nargs="?", metavar="NAME", help="the one whose script is printed")
    parser.set_defaults(handle=_scenarios)


def add_new(commands: Commands) -> None:
    """The command new."""
    parser = commands.add_parser("new", help="write a scenario to start from")
    parser.add_argument("script", metavar="FILE.py")
    parser.add_argument("--overwrite", action="store_true", help="replace a file that exists")
    parser.set_defaults(handle=_new)


def _scenarios(options: argparse.Namespace) -> None:
    if options.name is None:
        tell(*(f"{name:22} {line}" for name, line in listing().items()))
        return
    name = options.name.removesuffix(".py")
    require(name in listing(), f"There is no scenario {options.name!r}; {did_you_mean(name, list(listing()))}")
    tell(*(folder() / f"{name}.py").read_text(encoding="utf-8").splitlines())


def _new(options: argparse.Namespace) -> None:
    path = Path(options.script)
    require(path.suffix == ".py", f"{path} must end in .py: a scenario is a Python script.")
    require(path.stem.isidentifier(), f"{path} cannot be imported by its name; use letters, digits and _ alone.")
    check_target(path, options.overwrite)
    with written_whole(path) as part:
        part.write_text(TEMPLATE.format(file=path.name, stem=path.stem), encoding="utf-8")
    remark(f"wrote {path}; next: mol-compactons run {path}")
