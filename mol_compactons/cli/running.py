"""The command that runs a scenario."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mol_compactons.analysis.summary import contents, cost, kept
from mol_compactons.assignment import assign
from mol_compactons.cli.common import add_scenario, simulation_of
from mol_compactons.cli.scenarios import import_module
from mol_compactons.cli.speaking import remark
from mol_compactons.configuration import Settings
from mol_compactons.errors import InputError, shown
from mol_compactons.open_set import loaded
from mol_compactons.results.places import check_target
from mol_compactons.running import run
from mol_compactons.stop_rules import StopRule

if TYPE_CHECKING:
    from mol_compactons.cli.common import Commands


@dataclass(frozen=True)
class _Ends(Settings):
    """What may end a run early."""

    rules: Sequence[StopRule] = ()


def add_run(commands: Commands) -> None:
    """The command run."""
    parser = commands.add_parser("run", help="integrate a scenario, or repeat a result, into a NetCDF file")
    add_scenario(parser)
    parser.add_argument("-o", "--output", metavar="FILE.nc", help="where to write (default: the scenario's name)")
    existing = parser.add_mutually_exclusive_group()
    existing.add_argument("--overwrite", action="store_true", help="replace a file that exists")
    existing.add_argument(
        "--resume", action="store_true", help="go on from a file that exists, to its end or to a later one (--set t_end=...)"
    )
    parser.add_argument("--keep-checkpoints", action="store_true", help="leave the checkpoints beside a file that is complete")
    parser.add_argument(
        "--stop",
        action="append",
        default=[],
        metavar="RULE",
        help="end the run early: 'WallClock(seconds=3600)', CollisionOver, BlowUp, 'DriftBound(bound=1e-4)', SteadyState",
    )
    parser.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    parser.set_defaults(handle=_run)


def _run(options: argparse.Namespace) -> None:
    simulation = simulation_of(options)
    path = Path(f"{Path(options.scenario).stem}.nc" if options.output is None else options.output)
    check_target(path, options.overwrite or options.resume)
    if path.suffix.lower() != ".nc":
        raise InputError(f"{path} must end in .nc: a result is a NetCDF file.")
    rules = _rules(options.stop)
    before = _when_changed(path)
    try:
        dataset = run(
            simulation,
            path,
            overwrite=options.overwrite,
            resume=options.resume,
            keep_checkpoints=options.keep_checkpoints,
            stop=rules,
            progress=not options.quiet,
        )
        with dataset:
            if not options.quiet:
                done = "wrote" if _when_changed(path) != before else "nothing is left to do for"
                remark(f"{done} {path}: {contents(dataset)}", kept(dataset), cost(dataset))
    except KeyboardInterrupt as interrupt:
        interrupt.kept = _what_is_kept(options, path, before)  # type: ignore[attr-defined]
        raise


def _rules(texts: Sequence[str]) -> Sequence[StopRule]:
    """The stop rules that texts name."""
    try:
        return assign(_Ends(), {"rules": f"[{', '.join(texts)}]"}, import_module).rules
    except InputError as error:
        if "_Ends" not in str(error):
            raise
        allowed = ", ".join(sorted(loaded(StopRule)))
        raise InputError(f"--stop {shown(', '.join(texts))} names no rule; choose among {allowed}.") from None


def _when_changed(path: Path) -> Any:
    """What tells one file at a path from another."""
    try:
        return path.stat().st_ino, path.stat().st_mtime_ns
    except OSError:
        return None


def _what_is_kept(options: argparse.Namespace, path: Path, before: Any) -> str:
    """What an interrupted run leaves, and how it goes on."""
    now = _when_changed(path)
    if now is None:
        return "nothing was written."
    if now == before:
        return f"{path} is as it was."
    words = ["mol-compactons", "run", options.scenario, "-o", str(path), "--resume"]
    words += ["--keep-checkpoints"] if options.keep_checkpoints else []
    for option, values in (("--set", options.changes), ("--import", options.imports), ("--stop", options.stop)):
        for value in values:
            words += [option, value]
    return f"its frames so far are kept; it goes on with: {shlex.join(words)}"
