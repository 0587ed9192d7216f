"""The command line: mol-compactons run | info | plot | converge | stability | scenarios."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from mol_compactons.compiled import announcing_compilation
from mol_compactons.errors import InputError, IntegrationError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from mol_compactons.integrators.progress import Report


FAMILY_OPTIONS = {
    "sizes": "numbers of grid points: 300,600,1200",
    "schemes": "schemes: 'ConservativeScheme(order=4),FourierScheme'",
    "viscosities": "viscosities kept fixed while the grid is refined: 1e-3,5e-4",
    "grid_viscosities": "viscosities in grid units: 0.1,0.03",
    "tolerances": "relative tolerances, or steps of Midpoint: 1e-5,1e-6",
    "accuracy": "what may be called converged: 0.01",
}
"""The fields of a `Family` that are options of converge, and an example of each."""


SET_HELP = (
    "change a field: grid.size=1200, integrator='Rosenbrock(rtol=1e-6)'; a class takes its defaults for what is not said, not "
    "the values of the one it replaces"
)


class Parser(argparse.ArgumentParser):
    """An argument parser whose complaint is one sentence."""

    def error(self, message: str) -> NoReturn:
        """Complain and leave with status 2."""
        print(f"{self.prog}: {message}; see {self.prog} --help.", file=sys.stderr)
        raise SystemExit(2)


def parser() -> Parser:
    """The parser of the command line."""
    main = Parser(prog="mol-compactons", description="Compacton equations by the method of lines.")
    main.add_argument("--version", action="version", version=f"%(prog)s {version('mol_compactons')}")
    commands = main.add_subparsers(dest="command", required=True, metavar="COMMAND")

    run = commands.add_parser("run", help="integrate a scenario, or repeat a result, into a NetCDF file")
    run.add_argument("scenario", metavar="SCENARIO.py|RESULT.nc", help="a script, the name of a scenario, or a result")
    run.add_argument("-o", "--output", metavar="FILE.nc", help="where to write (default: the scenario's name)")
    run.add_argument("--set", dest="changes", action="append", default=[], metavar="FIELD=VALUE", help=SET_HELP)
    run.add_argument("--overwrite", action="store_true", help="replace a file that exists")
    run.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    run.add_argument("--keep-subnormals", action="store_true", help="do not count numbers below 2.2e-308 as zero")
    run.set_defaults(handle=_run)

    info = commands.add_parser("info", help="say what is in a result")
    info.add_argument("result", metavar="FILE.nc")
    info.set_defaults(handle=_info)

    plot = commands.add_parser("plot", help="draw a result: the waterfall and the drift of the invariants")
    plot.add_argument("result", metavar="FILE.nc")
    plot.add_argument("-o", "--output", metavar="FILE.png", help="where to write (default: the result's name)")
    plot.add_argument("--overwrite", action="store_true", help="replace a file that exists")
    plot.set_defaults(handle=_plot)

    converge = commands.add_parser("converge", help="run a family of a scenario, and say what of its result is converged")
    converge.add_argument("scenario", metavar="SCENARIO.py|RESULT.nc", help="a script, the name of a scenario, or a result")
    converge.add_argument("-o", "--output", metavar="STUDY.nc|STUDY.png", help="store the study (default), or draw it")
    for name, example in FAMILY_OPTIONS.items():
        converge.add_argument(f"--{name.replace('_', '-')}", metavar="A,B,...", help=example)
    converge.add_argument("--set", dest="changes", action="append", default=[], metavar="FIELD=VALUE", help=SET_HELP)
    converge.add_argument("--overwrite", action="store_true", help="replace a file that exists")
    converge.add_argument("--quiet", action="store_true", help="no line for each member")
    converge.set_defaults(handle=_converge)

    stability = commands.add_parser("stability", help="report on the stability of a compacton")
    stability.add_argument(
        "changes", nargs="*", metavar="FIELD=VALUE", help="n=3, speed=1, sizes=100,200,400, scheme.viscosity=0"
    )
    stability.add_argument("-o", "--output", metavar="FILE.nc|FILE.png", help="store the report, or draw it")
    stability.add_argument("--overwrite", action="store_true", help="replace a file that exists")
    stability.set_defaults(handle=_stability)

    scenarios = commands.add_parser("scenarios", help="list the scenarios that come with the package")
    scenarios.set_defaults(handle=_scenarios)
    return main


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status: 0 fine, 1 the solver gave up, 2 bad input, 130 interrupted."""
    options = parser().parse_args(arguments)
    try:
        with nullcontext() if getattr(options, "quiet", False) else announcing_compilation(_say_that_it_compiles):
            options.handle(options)
        sys.stdout.flush()
    except InputError as error:
        print(f"mol-compactons: {error}", file=sys.stderr)
        return 2
    except IntegrationError as error:
        print(f"mol-compactons: {error}", file=sys.stderr)
        return 1
    except MemoryError:
        print("mol-compactons: there is not enough memory; choose a smaller grid.size.", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        kept = "the frames written so far are kept" if options.command == "run" else "nothing was written"
        print(f"mol-compactons: interrupted; {kept}.", file=sys.stderr)
        return 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 0


def _say_that_it_compiles() -> None:
    print("compiling the kernels, which takes some seconds and is done once", flush=True)


def _run(options: argparse.Namespace) -> None:
    from mol_compactons import scenarios
    from mol_compactons.configuration import assign
    from mol_compactons.simulation import run
    from mol_compactons.store import check_target

    simulation = assign(scenarios.load(options.scenario), _assignments(options.changes))
    path = Path(options.output or f"{Path(options.scenario).stem}.nc")
    check_target(path, options.overwrite)
    if path.suffix.lower() != ".nc":
        raise InputError(f"{path} must end in .nc: a result is a NetCDF file.")
    with progress_bar(simulation.t_end, options.quiet) as report:
        flush = not options.keep_subnormals
        dataset = run(simulation, path, overwrite=options.overwrite, report=report, flush_subnormals=flush)
    if not options.quiet:
        print(f"wrote {path}: {contents(dataset)}", kept(dataset), cost(dataset), sep="\n")
    dataset.close()


def _assignments(changes: list[str]) -> dict[str, str]:
    result = {}
    for change in changes:
        field, equals, value = change.partition("=")
        if not equals:
            raise InputError(f"{change!r} lacks a value; write FIELD=VALUE.")
        if field.strip() in result:
            raise InputError(f"{field.strip()} is given twice; give it once.")
        result[field.strip()] = value
    return result


def _info(options: argparse.Namespace) -> None:
    from mol_compactons.scenarios import open_result
    from mol_compactons.simulation import Simulation

    with open_result(Path(options.result)) as dataset:
        if "family" in dataset.attrs:
            _print_study(Path(options.result))
            return
        print(dataset.attrs["title"], contents(dataset), kept(dataset), cost(dataset), sep="\n")
        simulation = Simulation.from_json(str(dataset.attrs["simulation"]))
        for field in ("equation", "grid", "scheme", "integrator"):
            print(f"{field}: {getattr(simulation, field)}")
        for wave in simulation.initial:
            print(f"initial: {str(wave)[:120]}")
        print(dataset.attrs["history"])


def _plot(options: argparse.Namespace) -> None:
    from mol_compactons.plots import convergence_overview, overview
    from mol_compactons.scenarios import open_result, open_study
    from mol_compactons.store import check_target

    path = Path(options.output or Path(options.result).with_suffix(".png"))
    with open_result(Path(options.result)) as dataset:
        if "family" in dataset.attrs:
            check_target(path, options.overwrite)
            with open_study(Path(options.result)) as tree:
                _save(convergence_overview(tree), path)
            return
        if dataset.sizes["t"] < 2:
            raise InputError(f"{options.result} holds {dataset.sizes['t']} frame(s); at least 2 are needed for a picture.")
        check_target(path, options.overwrite)
        _save(overview(dataset), path)


def _save(figure: Figure, path: Path) -> None:
    allowed = figure.canvas.get_supported_filetypes()
    if path.suffix.lstrip(".").lower() not in allowed:
        raise InputError(f"{path} has no picture format; end its name in {', '.join(sorted(allowed))}.")
    figure.savefig(path, dpi=150)
    print(f"wrote {path}")


def _converge(options: argparse.Namespace) -> None:
    from mol_compactons import scenarios
    from mol_compactons.configuration import assign
    from mol_compactons.convergence import converge
    from mol_compactons.family import Family
    from mol_compactons.plots import convergence_overview
    from mol_compactons.report import report
    from mol_compactons.store import check_target, write_tree

    simulation = assign(scenarios.load(options.scenario), _assignments(options.changes))
    asked = {name: getattr(options, name) for name in FAMILY_OPTIONS if getattr(options, name) is not None}
    lists = {name: text if name == "accuracy" or text[:1] in "[(" else f"[{text}]" for name, text in asked.items()}
    family = assign(Family(), lists)
    path = Path(options.output or f"{Path(options.scenario).stem}_study.nc")
    check_target(path, options.overwrite)
    if path.suffix.lower() not in (".nc", ".png"):
        raise InputError(f"{path} must end in .nc, to store the study, or .png, to draw it.")
    tree = converge(simulation, family, (lambda line: None) if options.quiet else print)
    if path.suffix.lower() == ".nc":
        write_tree(tree, path)
        print(*report(tree), f"wrote {path}", sep="\n")
    else:
        print(*report(tree), sep="\n")
        _save(convergence_overview(tree), path)


def _print_study(path: Path) -> None:
    from mol_compactons.report import report
    from mol_compactons.scenarios import open_study

    with open_study(path) as tree:
        members = tree["members"].children.values()
        print(tree.attrs["title"], *(f"member: {member.attrs['label']}" for member in members), *report(tree), sep="\n")


def _stability(options: argparse.Namespace) -> None:
    from mol_compactons import stability
    from mol_compactons.configuration import assign
    from mol_compactons.plots import stability_overview
    from mol_compactons.store import check_target

    study = assign(stability.StabilityStudy(), _assignments(options.changes))
    path = Path(options.output) if options.output else None
    if path:
        check_target(path, options.overwrite)
        if path.suffix.lower() not in (".nc", ".png"):
            raise InputError(f"{path} must end in .nc, to store the report, or .png, to draw it.")
    dataset = stability.report(study)
    print(*stability.verdicts(dataset), sep="\n")
    if not path:
        return
    if path.suffix.lower() == ".nc":
        dataset.to_netcdf(path)
    else:
        stability_overview(dataset).savefig(path, dpi=150)
    print(f"wrote {path}")


def _scenarios(options: argparse.Namespace) -> None:
    from mol_compactons import scenarios

    for name, line in scenarios.listing().items():
        print(f"{name:22} {line}")


def contents(dataset: xr.Dataset) -> str:
    """One line: what is in a result."""
    from mol_compactons.dataset import field_names

    fields = field_names(dataset)
    space = dataset[fields[0]].dims[1]
    last = float(dataset["t"][-1]) if dataset.sizes["t"] else 0.0
    names = " and ".join(f"{name}(t, {space})" for name in fields)
    return f"{names}, {dataset.sizes['t']} frames on {dataset.sizes[space]} points to t = {last:g}, {dataset.attrs['status']}"


def kept(dataset: xr.Dataset) -> str:
    """One line: how well the conserved quantities were kept."""
    from mol_compactons.invariants import drift

    changes = drift(dataset)
    if not changes.sizes["t"]:
        return "kept nothing: there is no frame"
    return "kept " + ", ".join(f"{name} to {float(abs(change).max()):.1e}" for name, change in changes.data_vars.items())


def cost(dataset: xr.Dataset) -> str:
    """One line: what a run cost."""
    attributes = dataset.attrs
    if "solver_steps" not in attributes:
        return "cost unknown: the run has not ended"
    counts = ("steps", "evaluations", "jacobians", "failures", "warnings")
    numbers = ", ".join(f"{attributes[f'solver_{count}']} {count}" for count in counts)
    warning = f"; first warning: {attributes['solver_first_warning']}" if attributes["solver_warnings"] else ""
    return f"cost {numbers}; {attributes['cpu_seconds']:.2f} s of CPU time{warning}"


@contextmanager
def progress_bar(t_end: float, quiet: bool) -> Iterator[Report]:
    """A progress bar in simulated time, with its rate and the time left; it appears with the first report."""
    from tqdm import tqdm

    from mol_compactons.integrators.progress import no_report

    layout = "{desc}{percentage:3.0f}%|{bar}| t = {n:.4g} / {total:.4g}, {rate_fmt}, {remaining} left"
    bar = None

    def report(t: float) -> None:
        nonlocal bar
        bar = bar or tqdm(total=t_end, unit="t", bar_format=layout, leave=False, dynamic_ncols=True)
        bar.update(t - bar.n)

    try:
        yield no_report if quiet else report
    finally:
        if bar:
            bar.close()
