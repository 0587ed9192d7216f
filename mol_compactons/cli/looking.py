"""The commands that look at what there is: scenarios, results, studies."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mol_compactons.analysis.drift import largest_drifts
from mol_compactons.analysis.summary import TRACK_COLUMNS, contents, cost, kept, waves_of
from mol_compactons.analysis.wave_orbits import report_orbit
from mol_compactons.cli.common import add_import, save
from mol_compactons.cli.machine import add_json, records, tell_json
from mol_compactons.cli.scenarios import import_module
from mol_compactons.cli.speaking import tell
from mol_compactons.cli.studies import print_study
from mol_compactons.cli.sweeps import is_sweep, picture_of_sweep, print_sweep
from mol_compactons.errors import InputError, require
from mol_compactons.results.form import check_form, reading, settings_of, understanding
from mol_compactons.results.opening import open_result, open_study, status_of
from mol_compactons.results.places import check_target

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from mol_compactons.cli.common import Commands


LONGEST_LINE = 120
"""How much of a wave is shown."""


RESULT_KINDS = ("waterfall", "map", "snapshots", "paths", "drift", "spectrum", "portrait")
STUDY_KINDS = ("ladder", "schemes")
"""What is drawn of a result, and of a study."""


def add_info(commands: Commands) -> None:
    """The command info."""
    parser = commands.add_parser("info", help="say what is in a result, a study or a sweep")
    parser.add_argument("result", metavar="FILE.nc|FOLDER")
    add_json(parser)
    parser.set_defaults(handle=_info)


def add_doctor(commands: Commands) -> None:
    """The command doctor."""
    parser = commands.add_parser(
        "doctor",
        help="say what of a result contradicts what is known",
        description="One line for each thing looked at: its verdict, and what was seen beside what is known. The exit status "
        "is 1 if anything contradicts what is known.",
    )
    parser.add_argument("result", metavar="FILE.nc")
    add_import(parser)
    add_json(parser)
    parser.set_defaults(handle=_doctor)


def add_track(commands: Commands) -> None:
    """The command track."""
    parser = commands.add_parser(
        "track",
        help="follow the waves of a result, and say which are compactons",
        description="A line for each wave, as it was when it was last clear of all others: its place, height and speed, the "
        "speed that belongs to the height, and how far its profile is from the exact wave; then the phase shifts by which "
        "collisions moved them, and what is not sure.",
    )
    parser.add_argument("result", metavar="FILE.nc")
    parser.add_argument("--least-height", type=float, metavar="HEIGHT", help="peaks lower than this are ripples")
    add_import(parser)
    add_json(parser)
    parser.set_defaults(handle=_track)


def add_plot(commands: Commands) -> None:
    """The command plot."""
    parser = commands.add_parser(
        "plot", help="draw a result (the waterfall and the drift of the invariants), a study or a sweep"
    )
    parser.add_argument("result", metavar="FILE.nc|FOLDER")
    parser.add_argument(
        "beside", nargs="?", metavar="OTHER.nc", help="of snapshots: another result below them, or the continuum of a chain"
    )
    parser.add_argument(
        "--kind",
        choices=(*RESULT_KINDS, *STUDY_KINDS),
        help=f"what is drawn: of a result {', '.join(RESULT_KINDS)} (default: waterfall and drift); of a study "
        f"{', '.join(STUDY_KINDS)} (default: ladder)",
    )
    parser.add_argument("--times", metavar="T,...", help="of snapshots and a portrait: the times that are shown")
    parser.add_argument(
        "--window", metavar="FROM:TO", help="the points between which a result is shown; either may be missing"
    )
    parser.add_argument(
        "--style",
        choices=("screen", "journal", "journal-wide"),
        default="screen",
        help="for the screen, or for one or two columns of a journal",
    )
    parser.add_argument(
        "-o", "--output", metavar="FILE.png|FILE.pdf|FILE.svg", help="where to (default: the result's name, .png)"
    )
    parser.add_argument("--overwrite", action="store_true", help="replace a file that exists")
    parser.set_defaults(handle=_plot)


def _info(options: argparse.Namespace) -> None:
    result = Path(options.result)
    if result.is_dir():
        print_sweep(result, options.json)
        return
    with reading(options.result), open_result(result) as dataset:
        if "family" in dataset.attrs:
            with understanding(options.result, "study"):
                print_study(result, options.json)
            return
        if "period" in dataset.attrs:
            with understanding(options.result, "orbit"):
                lines = report_orbit(dataset)
            tell_json({"attributes": dataset.attrs, "report": lines}) if options.json else tell(*lines)
            return
        check_form(dataset, options.result)
        dataset.attrs["status"] = status_of(dataset, options.result)
        tell_json(_of_result(dataset)) if options.json else tell(*_lines_of_result(dataset))


def _of_result(dataset: xr.Dataset) -> dict[str, Any]:
    """What is in a result."""
    attributes = {name: value for name, value in dataset.attrs.items() if name not in ("simulation", "waves")}
    return {
        **attributes,
        "sizes": dict(dataset.sizes),
        "last_time": float(dataset["t"][-1]) if dataset.sizes["t"] else None,
        "drift": largest_drifts(dataset),
        "simulation": settings_of(str(dataset.attrs["simulation"])),
        "waves": json.loads(str(dataset.attrs.get("waves", "[]"))),
    }


def _lines_of_result(dataset: xr.Dataset) -> list[str]:
    """The same in lines."""
    lines = [str(dataset.attrs["title"]), contents(dataset), kept(dataset), cost(dataset)]
    simulation = settings_of(str(dataset.attrs["simulation"]))
    lines += [f"{field}: {shown(simulation[field])}" for field in ("equation", "grid", "scheme", "integrator")]
    lines += [f"initial: {shown(wave)[:LONGEST_LINE]}" for wave in simulation["initial"]]
    return [*lines, f"source: {dataset.attrs.get('source', 'not stated')}", str(dataset.attrs.get("history", "no history"))]


def _doctor(options: argparse.Namespace) -> int:
    from mol_compactons.analysis.checkup import check_up

    for module in options.imports:
        import_module(module)
    with reading(options.result), open_result(Path(options.result)) as dataset:
        check_form(dataset, options.result)
        findings = check_up(dataset)
    if options.json:
        tell_json([asdict(finding) for finding in findings])
    else:
        tell(*(f"{finding.verdict:12} {finding.check}: {finding.sentence}" for finding in findings))
    return int(any(finding.verdict == "contradicts" for finding in findings))


def _track(options: argparse.Namespace) -> None:
    from mol_compactons.analysis.collisions import first_collision
    from mol_compactons.analysis.tracking import track

    for module in options.imports:
        import_module(module)
    with reading(options.result), open_result(Path(options.result)) as dataset:
        check_form(dataset, options.result)
        tracks = track(dataset, least_height=options.least_height)
    collisions = first_collision(tracks)
    if options.json:
        of_waves = [name for name, one in tracks.data_vars.items() if "wave" in one.dims]
        tell_json(
            {
                "t": tracks["t"].values,
                "waves": records(tracks[of_waves].drop_vars("t"), "wave"),
                "collisions": records(collisions[[name for name, one in collisions.items() if one.dims == ("wave",)]], "wave"),
                **{name: tracks.attrs[name] for name in ("lost", "doubtful")},
            }
        )
        return
    tell(f"wave {'since':>9}" + "".join(f"{name:>13}" for name in TRACK_COLUMNS) + f"{'compacton':>11}")
    tell(*map(_line_of, waves_of(tracks)))
    collided = collisions.dropna("wave", subset=["phase_shift"])
    for wave, shift, moment in zip(*(collided[name].values for name in ("wave", "phase_shift", "moment")), strict=True):
        tell(f"wave {wave} is {shift:.5g} ahead of its free flight after its first collision, at t = {moment:.5g}")
    tell(*(str(tracks.attrs[name]) for name in ("lost", "doubtful") if tracks.attrs[name]))


def _line_of(row: dict[str, Any]) -> str:
    values = "".join(f"{row[name]:>13.6g}" for name in TRACK_COLUMNS)
    return f"{row['wave']:<4} {row['first_seen']:>9.5g}{values}{'yes' if row['compacton'] else 'no':>11}"


def shown(part: Any) -> str:
    """A part of a simulation from its JSON, which may name a class that is not loaded."""
    if isinstance(part, dict) and "type" in part:
        fields = ", ".join(f"{name}={shown(value)}" for name, value in part.items() if name != "type")
        return f"{part['type']}({fields})"
    if isinstance(part, list):
        return "[" + ", ".join(shown(item) for item in part) + "]"
    return f"{part:.12g}" if isinstance(part, float) else repr(part)


def _plot(options: argparse.Namespace) -> None:
    from mol_compactons.figures import orbit_overview

    result = Path(options.result)
    if is_sweep(result):
        _check_options(options, "a sweep", ())
        path = Path(options.output or f"{result}.png")
        check_target(path, options.overwrite)
        save(picture_of_sweep(result), path)
        return
    with reading(result), open_result(result) as dataset:
        path = Path(options.output or result.with_suffix(".png"))
        if "family" in dataset.attrs:
            _check_options(options, "a study", STUDY_KINDS)
            check_target(path, options.overwrite)
            with understanding(result, "study"), open_study(result) as tree:
                figure = _picture_of_study(tree, options)
        elif "period" in dataset.attrs:
            _check_options(options, "an orbit", ())
            check_target(path, options.overwrite)
            with understanding(result, "orbit"):
                figure = orbit_overview(dataset)
        else:
            _check_options(options, "a result", RESULT_KINDS)
            check_form(dataset, result)
            if dataset.sizes["t"] < 2:
                raise InputError(f"{result} holds {dataset.sizes['t']} frame(s); at least 2 are needed for a picture.")
            check_target(path, options.overwrite)
            figure = _picture_of(dataset, options)
    save(figure, path)


def _check_options(options: argparse.Namespace, what: str, kinds: Sequence[str]) -> None:
    """Refuse options that say nothing for what is drawn."""
    allowed = f"choose a --kind among {', '.join(kinds)}" if kinds else "leave out --kind"
    require(options.kind is None or options.kind in kinds, f"{options.result} is {what}; {allowed}.")
    given = [name for name in ("times", "window") if getattr(options, name) is not None]
    given += ["style"] if options.style != "screen" else []
    require(options.beside is None or kinds == RESULT_KINDS, f"{options.result} is {what}; leave out {options.beside}.")
    require(
        not given or kinds == RESULT_KINDS,
        f"{options.result} is {what}; leave out {', '.join(f'--{name}' for name in given)}.",
    )


def _picture_of_study(tree: xr.DataTree, options: argparse.Namespace) -> Figure:
    from mol_compactons.figures import convergence_overview, schemes_overview

    if options.kind != "schemes":
        return convergence_overview(tree)
    require(
        "schemes" in tree.children,
        f"{options.result} has no schemes to compare: it is of a chain, or of an earlier version; run the study again.",
    )
    return schemes_overview(tree["schemes"].to_dataset())


def _picture_of(dataset: xr.Dataset, options: argparse.Namespace) -> Figure:
    """The picture of a result that the options describe."""
    from mol_compactons.figures import overview, picture, window

    part = _window(options.window) if options.window else (None, None)
    if options.kind is None and not options.times and not options.beside and options.style == "screen":
        return overview(dataset if part == (None, None) else window(dataset, *part))
    kind = options.kind or ("snapshots" if options.times or options.beside else "waterfall")
    times = _numbers("--times", options.times)
    if not options.beside:
        return picture(dataset, kind, times=times, part=part, style=options.style)
    with reading(options.beside), open_result(Path(options.beside)) as other:
        check_form(other, options.beside)
        called = Path(options.beside).stem
        return picture(dataset, kind, times=times, part=part, style=options.style, beside=other, called=called)


def _window(text: str) -> tuple[float | None, float | None]:
    """The ends of a window."""
    ends = text.split(":")
    try:
        start, end = (float(one) if one.strip() else None for one in ends)
    except ValueError:
        raise InputError(f"--window {text} is not understood; write FROM:TO, as 5:40 or 5:.") from None
    return start, end


def _numbers(option: str, text: str | None) -> list[float]:
    try:
        return [float(one) for one in text.split(",")] if text else []
    except ValueError:
        raise InputError(f"{option} {text} is not understood; write numbers, as 0,10,20.") from None
