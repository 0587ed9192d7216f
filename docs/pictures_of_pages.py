"""The pictures of the pages, drawn anew with each build: `python docs/pictures_of_pages.py` puts them beside the pages too.

Pages that are read without Sphinx show the pictures that stand beside them, by the same functions. What takes seconds is run;
studies of half an hour are drawn from what was recorded of them: `discretisations.nc`, and the tables in `recorded`.
"""

from __future__ import annotations

import csv
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

FROM_SCENARIOS = {
    "two_bright.png": "two_bright",
    "lattice_single.png": "lattice_single",
    "lattice_single_n3.png": "lattice_single",
    "lattice_collision.png": "lattice_collision",
}
"""Pictures that a scenario of the gallery draws, and which."""


def rows_of(name: str) -> list[dict[str, str]]:
    """A recorded table."""
    with (HERE / "recorded" / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def discretisations(path: Path) -> None:
    """The errors of all schemes, from the study of `scenarios/discretisations.py`."""
    import xarray as xr

    from mol_compactons.figures import scheme_errors

    with xr.open_dataset(HERE / "discretisations.nc") as study:
        scheme_errors(study.load()).savefig(path)


def scheme_precision(path: Path) -> None:
    """Error against processor time for each scheme, from `python -m benchmarks W5`."""
    from benchmarks.matched_error import Row, picture

    rows = [
        Row(
            row["solver"], "", float(row["cpu_seconds"]), float(row["relative_l2_error"]), "", row["solver"].startswith("ours")
        )
        for row in rows_of("W5_points.csv")
    ]
    title = "W5: one compacton, t = 14, N = 75 to 1200, Rosenbrock"
    drawn = path.parent / "drawn"
    drawn.mkdir(exist_ok=True)
    picture(rows, title, drawn / path.name)
    (drawn / path.name).replace(path)
    shutil.rmtree(drawn)


def work_precision(path: Path) -> None:
    """Processor time at matched error, from `python -m benchmarks W1`."""
    from matplotlib.figure import Figure

    rows = rows_of("W1.csv")[::-1]
    figure = Figure(figsize=(7, 3.6), layout="constrained")
    axes = figure.subplots()
    seconds = [float(row["cpu_seconds"]) for row in rows]
    colors = ["C0" if row["solver"].startswith("ours") else "0.75" for row in rows]
    bars = axes.barh([row["solver"] for row in rows], seconds, color=colors)
    axes.bar_label(bars, [f"{value:.3g} s" for value in seconds], padding=3, fontsize=8)
    axes.set_xscale("log")
    axes.set(
        xlim=(0.05, 1000), xlabel="CPU seconds to a relative L2 error of 1e-5", title="W1: one compacton, N = 600, t = 14"
    )
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=110)


FROM_RECORDS = {
    "discretisations.png": discretisations,
    "scheme_precision.png": scheme_precision,
    "work_precision.png": work_precision,
}
"""Pictures of studies that take long, drawn from what was recorded."""


def draw(folder: Path, gallery: Path) -> list[Path]:
    """Put all pictures into a folder; those of the scenarios are found where the gallery has put them.

    Raises
    ------
    FileNotFoundError
        If a scenario has not drawn its picture.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name in FROM_SCENARIOS:
        shutil.copy(gallery / name, folder / name)
    for name, function in FROM_RECORDS.items():
        function(folder / name)
    return [folder / name for name in (*FROM_SCENARIOS, *FROM_RECORDS)]


def replace_pictures(folder: Path, images: Path) -> None:
    """Put fresh pictures in the place of those that stood beside the pages.

    Raises
    ------
    ValueError
        If a page shows a picture that no build has drawn.
    """
    fresh = {path.name for path in folder.glob("*.png")}
    stale = sorted({path.name for path in HERE.glob("*.png")} - fresh)
    if stale:
        raise ValueError(f"docs/{stale[0]} is drawn by no function of docs/pictures_of_pages.py; add one, or remove it.")
    for name in fresh:
        if (images / name).exists():
            shutil.copy(folder / name, images / name)


if __name__ == "__main__":
    for drawn_picture in draw(HERE.parent / "build" / "pictures", HERE.parent / "build" / "scenario_pictures"):
        shutil.copy(drawn_picture, HERE / drawn_picture.name)
