"""The commands that make studies: convergence and stability."""

from __future__ import annotations

import argparse
import shutil
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mol_compactons.analysis import stability
from mol_compactons.assignment import assign
from mol_compactons.cli.common import add_scenario, add_workers, assignments, engine_of, save, simulation_of
from mol_compactons.cli.machine import add_json, records, tell_json
from mol_compactons.cli.speaking import remark, tell
from mol_compactons.errors import InputError, IntegrationError
from mol_compactons.progress import beside_bars
from mol_compactons.results.opening import open_study, write_tree
from mol_compactons.results.places import beside, check_target
from mol_compactons.studies.convergence import converge, plan_of_study
from mol_compactons.studies.family import Family
from mol_compactons.studies.report import report, verdict
from mol_compactons.studies.store import forget_another, what_is_kept

if TYPE_CHECKING:
    import xarray as xr

    from mol_compactons.cli.common import Commands


FAMILY_OPTIONS = {
    "sizes": "numbers of grid points: 300,600,1200",
    "schemes": "schemes: 'ConservativeScheme(order=4),FourierScheme'",
    "viscosities": "viscosities kept fixed while the grid is refined: 1e-3,5e-4",
    "grid_viscosities": "viscosities in grid units: 0.1,0.03",
    "tolerances": "relative tolerances, or steps of Midpoint: 1e-4,1e-5",
    "accuracy": "what may be called converged: 0.01",
}
"""The fields of a `Family` that are options of converge, and an example of each."""


def add_converge(commands: Commands) -> None:
    """The command converge."""
    parser = commands.add_parser("converge", help="run a family of a scenario, and say what of its result is converged")
    add_scenario(parser)
    parser.add_argument("-o", "--output", metavar="STUDY.nc|STUDY.png", help="store the study (default), or draw it")
    for name, example in FAMILY_OPTIONS.items():
        parser.add_argument(f"--{name.replace('_', '-')}", metavar="A,B,...", help=example)
    parser.add_argument("--overwrite", action="store_true", help="replace a file that exists")
    parser.add_argument("--quiet", action="store_true", help="no line for each member")
    add_workers(parser)
    add_json(parser)
    parser.set_defaults(handle=_converge)


def add_stability(commands: Commands) -> None:
    """The command stability."""
    parser = commands.add_parser("stability", help="report on the stability of a compacton")
    parser.add_argument(
        "changes", nargs="*", metavar="FIELD=VALUE", help="n=3, speed=1, sizes=100,200,400, scheme.viscosity=0"
    )
    parser.add_argument("-o", "--output", metavar="FILE.nc|FILE.png", help="store the report, or draw it")
    parser.add_argument("--overwrite", action="store_true", help="replace a file that exists")
    add_json(parser)
    parser.set_defaults(handle=_stability)


def family_of(options: argparse.Namespace) -> Family:
    """The family that a command was asked for."""
    asked = {name: getattr(options, name) for name in FAMILY_OPTIONS if getattr(options, name) is not None}
    lists = {name: text if name == "accuracy" or text[:1] in "[(" else f"[{text}]" for name, text in asked.items()}
    return assign(Family(), lists)


def _converge(options: argparse.Namespace) -> None:
    from mol_compactons.figures import convergence_overview

    simulation = simulation_of(options)
    family = family_of(options)
    path = Path(options.output or f"{Path(options.scenario).stem}_study.nc")
    check_target(path, options.overwrite)
    if path.suffix.lower() not in (".nc", ".png"):
        raise InputError(f"{path} must end in .nc, to store the study, or .png, to draw it.")
    members = beside(path, "members")
    forget_another(members, plan_of_study(simulation, family))
    try:
        silent = options.quiet or options.json
        notice = (lambda line: None) if silent else _remark_beside_bars
        tree = converge(simulation, family, notice, engine=engine_of(options), folder=members, progress=not silent)
    except KeyboardInterrupt as interrupt:
        interrupt.kept = what_is_kept(members)  # type: ignore[attr-defined]
        raise
    except IntegrationError:
        shutil.rmtree(members, ignore_errors=True)
        raise
    say = partial(tell_json, as_json(tree)) if options.json else partial(remark, *report(tree))
    if path.suffix.lower() == ".nc":
        try:
            write_tree(tree, path)
        finally:
            say()
        if not options.json:
            remark(f"wrote {path}")
    else:
        say()
        save(convergence_overview(tree), path, say=not options.json)
    shutil.rmtree(members, ignore_errors=True)


def _remark_beside_bars(line: str) -> None:
    with beside_bars():
        remark(line)


def as_json(tree: xr.DataTree) -> dict[str, Any]:
    """What a study says, for other programs."""
    summary = tree["summary"].to_dataset()
    quantities = [record for limit in summary["limit"].values for record in records(summary.sel(limit=limit), "quantity")]
    schemes = tree["schemes"].to_dataset() if "schemes" in tree.children else None
    rows = [] if schemes is None else [one for size in schemes["size"] for one in records(schemes.sel(size=size), "scheme")]
    return {
        **{name: tree.attrs[name] for name in ("title", "family", "simulation", "failed")},
        "verdicts": {str(limit): verdict(summary, str(limit)) for limit in summary["limit"].values},
        "quantities": quantities,
        "schemes": rows,
    }


def print_study(path: Path, for_programs: bool = False) -> None:
    """Say what is in a study."""
    with open_study(path) as tree:
        if for_programs:
            tell_json(as_json(tree))
            return
        members = tree["members"].children.values()
        tell(tree.attrs["title"], *(f"member: {member.attrs['label']}" for member in members), *report(tree))


def _stability(options: argparse.Namespace) -> None:
    from mol_compactons.figures import stability_overview

    study = assign(stability.StabilityStudy(), assignments(options.changes))
    path = Path(options.output) if options.output else None
    if path:
        check_target(path, options.overwrite)
        if path.suffix.lower() not in (".nc", ".png"):
            raise InputError(f"{path} must end in .nc, to store the report, or .png, to draw it.")
    dataset = stability.report(study)
    if options.json:
        tell_json({"verdicts": list(stability.verdicts(dataset)), **dataset.to_dict()})
    else:
        (remark if path else tell)(*stability.verdicts(dataset))
    if not path:
        return
    if path.suffix.lower() == ".nc":
        write_tree(dataset, path)
        if not options.json:
            remark(f"wrote {path}")
    else:
        save(stability_overview(dataset), path, say=not options.json)
