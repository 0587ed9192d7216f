"""The command that runs a simulation with some of its fields varied."""

from __future__ import annotations

import argparse
import ast
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mol_compactons.cli.common import add_scenario, add_workers, assignments, engine_of, simulation_of
from mol_compactons.cli.machine import tell_json
from mol_compactons.cli.scenarios import import_module
from mol_compactons.cli.speaking import remark, tell
from mol_compactons.errors import InputError, require, shown
from mol_compactons.simulation import Simulation
from mol_compactons.studies.plan import Axis, Plan, drawn
from mol_compactons.studies.refining import UNFINISHED, refine
from mol_compactons.studies.store import FAILED, PLAN, plan_of, rows_of, what_is_kept
from mol_compactons.studies.sweep import TABLE, sweep
from mol_compactons.studies.table import MISSING, laid_out, table

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from mol_compactons.cli.common import Commands

SPACINGS: dict[str, Callable[..., Any]] = {"linspace": np.linspace, "geomspace": np.geomspace}
"""How several values are given at once, as numpy calls them: geomspace(1e-4, 1e-2, 5)."""

OF_REFINEMENT = ("outcome", "accuracy", "parts")
"""The options that go to `refine` as they stand."""

MOST_VALUES = 10**6

OF_DRAWING, DRAWN = ("count", "seed"), 100
"""The options of random values, and how many members these make unless told otherwise."""

REASONS_SHOWN = 5
"""How many different reasons are told."""


def add_sweep(commands: Commands) -> None:
    """The command sweep."""
    parser = commands.add_parser(
        "sweep",
        help="run a scenario with some of its fields varied",
        description="Each member runs once, into its own file; the same command again does what is missing or has failed.",
    )
    add_scenario(parser)
    parser.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="FIELD=A,B,...",
        help="a field and its values: grid.size=300,600; 'scheme.viscosity=geomspace(1e-4, 1e-2, 5)'; "
        "scheme='CompactScheme(),FourierScheme()'. All combinations are run",
    )
    parser.add_argument("--together", action="store_true", help="the first values of all fields, the second ones, and so on")
    parser.add_argument(
        "--draw", action="append", default=[], metavar="FIELD=LOW,HIGH", help="random values between two, in place of --vary"
    )
    parser.add_argument("--count", type=int, metavar="N", help="how many members --draw makes (default: 100)")
    parser.add_argument("--seed", type=int, metavar="N", help="of the random values of --draw (default: 0)")
    _add_refinement(parser)
    parser.add_argument("-o", "--output", metavar="FOLDER", help="where results go (default: the scenario's name and _sweep)")
    parser.add_argument("--untracked", action="store_true", help="do not follow the waves, which takes its time")
    parser.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    add_workers(parser)
    parser.set_defaults(handle=_sweep)


def _add_refinement(parser: argparse.ArgumentParser) -> None:
    """The options of a refinement; what is not given is what `refine` takes."""
    parser.add_argument(
        "--refine",
        metavar="FIELD=A,B,...",
        help="values between which it is found where the outcome changes, in place of --vary",
    )
    parser.add_argument(
        "--outcome",
        metavar="QUANTITY>NUMBER",
        help="what --refine asks: 'momentum_drift > 0.01', 'height_after[1] < 0.9' (default: whether the run is complete)",
    )
    parser.add_argument("--accuracy", type=float, metavar="X", help="how close the values of --refine get (default: 0.01)")
    parser.add_argument("--parts", type=int, metavar="N", help="into how many parts --refine divides (default: 2)")


def _sweep(options: argparse.Namespace) -> int:
    run_members = _refinement(options) if options.refine else _variation(options)
    folder = Path(options.output or f"{Path(options.scenario).stem}_sweep")
    try:
        result = run_members(
            folder=folder, engine=engine_of(options), tracked=not options.untracked, progress=not options.quiet
        )
    except KeyboardInterrupt as interrupt:
        interrupt.kept = what_is_kept(folder)  # type: ignore[attr-defined]
        raise
    if not options.quiet:
        remark(*summary(result), f"wrote {folder / TABLE}")
    return int(bool((result["status"] == FAILED).all()))


def _variation(options: argparse.Namespace) -> Callable[..., xr.Dataset]:
    """The sweep that the options describe."""
    given = [f"--{name}" for name in OF_REFINEMENT if getattr(options, name) is not None]
    require(not given, f"{', '.join(given)} belongs to a refinement; give --refine, or leave it out.")
    return partial(sweep, _plan(simulation_of(options), options), None)


def _refinement(options: argparse.Namespace) -> Callable[..., xr.Dataset]:
    """The refinement that the options describe."""
    others = [
        f"--{name}" for name in ("vary", "draw", "together", *OF_DRAWING) if getattr(options, name) not in (None, [], False)
    ]
    require(not others, f"A field is refined or varied; leave out --refine or {', '.join(others)}.")
    ((path, text),) = assignments([options.refine]).items()
    try:
        values = [ast.literal_eval(value) if isinstance(value, str) else value for value in values_of(path, text)]
    except (ValueError, SyntaxError):
        raise InputError(f"{shown(path)} is to be refined between {shown(text)}; write numbers, {path}=LOW,HIGH.") from None
    own = {name: getattr(options, name) for name in OF_REFINEMENT if getattr(options, name) is not None}
    return partial(refine, simulation_of(options), path, values, importing=import_module, **own)


def _plan(simulation: Simulation, options: argparse.Namespace) -> Plan:
    """What is varied, by the options of the command."""
    varied = {path: values_of(path, text) for path, text in assignments(options.vary).items()}
    if options.draw:
        require(not varied, "Values are drawn or given; give --draw or --vary.")
        ranges = {path: _range(path, text) for path, text in assignments(options.draw).items()}
        own = {name: getattr(options, name) for name in OF_DRAWING if getattr(options, name) is not None}
        return drawn(simulation, ranges, **({"count": DRAWN, "seed": 0} | own))
    given = [f"--{name}" for name in OF_DRAWING if getattr(options, name) is not None]
    require(not given, f"{', '.join(given)} belongs to random values; give --draw, or leave it out.")
    axes = [Axis(varied)] if options.together and varied else [Axis({path: values}) for path, values in varied.items()]
    return Plan(simulation, axes, import_module)


def values_of(path: str, text: str) -> list[Any]:
    """The values that a text lists: separated by commas outside of brackets, or spaced as numpy does."""
    for name, spacing in SPACINGS.items():
        if text.startswith(f"{name}(") and text.endswith(")"):
            return _spaced(path, text, spacing, text[len(name) + 1 : -1])
    return [part.strip() for part in _split(text) if part.strip()]


def _spaced(path: str, text: str, spacing: Callable[..., Any], inside: str) -> list[Any]:
    try:
        first, last, count = (ast.literal_eval(part.strip()) for part in inside.split(","))
        require(2 <= count <= MOST_VALUES, f"{path} = {shown(text)} has {count} values; choose between 2 and {MOST_VALUES}.")
        with np.errstate(all="raise"):
            return [float(value) for value in spacing(first, last, count)]
    except InputError:
        raise
    except Exception:
        raise InputError(f"{path} = {shown(text)} is not understood; write it as geomspace(1e-4, 1e-2, 5).") from None


def _split(text: str) -> Iterator[str]:
    """A text at its commas outside of brackets and quotes."""
    part, depth, quote = "", 0, ""
    for sign in text:
        if quote:
            quote = "" if sign == quote else quote
        elif sign in "'\"":
            quote = sign
        depth += (sign in "([{") - (sign in ")]}") if not quote else 0
        if sign == "," and depth == 0 and not quote:
            yield part
            part = ""
        else:
            part += sign
    yield part


def _range(path: str, text: str) -> tuple[float, float]:
    try:
        low, high = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"{shown(path)} is to be drawn from {shown(text)}; write two numbers, {path}=LOW,HIGH.") from None
    return low, high


def summary(result: xr.Dataset) -> list[str]:
    """A sweep in a few lines: how its members ended, and why some did not."""
    statuses = Counter(map(str, result["status"].values.ravel()))
    lines = [f"{result['status'].size} members: {', '.join(f'{statuses[one]} {one}' for one in sorted(statuses))}"]
    reasons = Counter(filter(None, map(str, result["reason"].values.ravel()))).most_common()
    lines += [f"failed {count} times: {reason}" for reason, count in reasons[:REASONS_SHOWN]]
    lines += changes_of(result) if "outcome" in result else []
    lines += [str(result.attrs[UNFINISHED])] if UNFINISHED in result.attrs else []
    return lines + ([f"and for {len(reasons) - REASONS_SHOWN} other reasons"] if len(reasons) > REASONS_SHOWN else [])


def changes_of(result: xr.Dataset) -> list[str]:
    """Where the outcome of a refinement changes, a line each."""
    (name,) = map(str, result["outcome"].dims)
    result = result.isel({name: np.flatnonzero(result["outcome"].values != "")})  # others have not run yet
    if not result.sizes[name]:
        return []
    outcomes, values = result["outcome"].values, result[name].values
    pairs = [(index, index + 1) for index in range(outcomes.size - 1) if outcomes[index] != outcomes[index + 1]]
    lines = [f"{outcomes[low]} at {name} = {values[low]:.6g}, {outcomes[high]} at {values[high]:.6g}" for low, high in pairs]
    return lines or [f"{outcomes[0]} at all {outcomes.size} values of {name}"]


def is_sweep(path: Path) -> bool:
    """Whether a path is the folder of a study."""
    return (path / PLAN).is_file()


def _table_of(folder: Path) -> tuple[Mapping[str, Any], xr.Dataset]:
    """The plan of a sweep, and its table as far as it has come."""
    plan = plan_of(folder)
    require(
        "family" not in plan, f"{folder} holds the members of a convergence study that has not ended; run its command again."
    )
    own, rows = laid_out(plan, rows_of(folder).values())
    return own, table(own, rows)


def print_sweep(folder: Path, for_programs: bool = False) -> None:
    """Say what is in the folder of a sweep, also while it runs."""
    plan, result = _table_of(folder)
    if for_programs:
        tell_json({"varied": _varied(plan), "table": result.to_dict()})
        return
    tell(*_axes(plan), *summary(result), *_numbers(result))


def picture_of_sweep(folder: Path) -> Figure:
    """The picture of a sweep, also while it runs."""
    from mol_compactons.figures import sweep_overview

    plan, result = _table_of(folder)
    varied = ", ".join(path for axis in plan["axes"] for path in axis["fields"])
    return sweep_overview(result.assign_attrs(title=f"Sweep over {varied}: {'; '.join(summary(result)[:1])}"))


def _varied(plan: Mapping[str, Any]) -> dict[str, list[str]]:
    """The fields that are varied, and their values in words."""
    return {path: field["told"] for axis in plan["axes"] for path, field in axis["fields"].items()}


def _axes(plan: Mapping[str, Any]) -> Sequence[str]:
    fields = _varied(plan).items()
    return [f"varied: {path} = {', '.join(values[:10])}{', ...' if len(values) > 10 else ''}" for path, values in fields]


def _numbers(result: xr.Dataset) -> Sequence[str]:
    """The range of each quantity of a table."""
    known = result.where(result["status"] != MISSING)
    lines = []
    for name, one in known.data_vars.items():
        if np.issubdtype(one.dtype, np.floating) and bool(one.notnull().any()):
            lines.append(f"{name}: {float(one.min()):.6g} to {float(one.max()):.6g}")
    return lines
