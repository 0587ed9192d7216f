"""Writing the page of whatever is given: a result, a study, a sweep, or a chain and its continuum."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from mol_compactons.errors import require
from mol_compactons.pages.document import Page, rendered
from mol_compactons.pages.result import page_of_result
from mol_compactons.pages.studies import page_of_study
from mol_compactons.pages.sweeps import page_of_sweep
from mol_compactons.results.form import check_form, reading, understanding
from mol_compactons.results.opening import open_result, open_study, status_of
from mol_compactons.results.places import check_target, written_whole
from mol_compactons.studies.store import plan_of, rows_of
from mol_compactons.studies.sweep import TABLE
from mol_compactons.studies.table import laid_out, table

if TYPE_CHECKING:
    import xarray as xr


def write_report(
    source: str | Path | xr.Dataset | xr.DataTree,
    path: str | Path,
    *,
    continuum: str | Path | xr.Dataset | None = None,
    overwrite: bool = False,
) -> Path:
    """Write a page that shows a result, a study or a sweep, and needs no network.

    Parameters
    ----------
    source : str, Path, xarray.Dataset or xarray.DataTree
        The file of a result or of a study, the folder of a sweep, or what `run` or `converge` returned.
    path : str or Path
        Where to; its name ends in ``.html``.
    continuum : str, Path or xarray.Dataset, optional
        The result of the continuum of a chain, to be shown beside it.
    overwrite : bool
        Whether a file that exists may be replaced.

    Returns
    -------
    Path
        Where it is.

    Raises
    ------
    InputError
        If the source cannot be read, holds fewer than two frames, does not belong to the continuum, the page cannot be
        written, or plotly or jinja2 is not installed.
    """
    path = Path(path)
    require(path.suffix.lower() in (".html", ".htm"), f"{path} must end in .html, to be a page.")
    check_target(path, overwrite)
    text = rendered(_page(source, continuum))
    with written_whole(path) as part:
        part.write_text(text, encoding="utf-8")
    return path


def _page(source: str | Path | xr.Dataset | xr.DataTree, continuum: str | Path | xr.Dataset | None) -> Page:
    """The page of what is given."""
    import xarray as xr

    if isinstance(source, xr.DataTree):
        return _alone(page_of_study(source), continuum)
    if isinstance(source, xr.Dataset):
        return _of_result(source, str(source.attrs.get("status", "")), continuum)
    place = Path(source)
    if place.is_dir():
        plan, rows = laid_out(plan_of(place), rows_of(place).values())
        require("axes" in plan, f"{place} holds the members of a convergence study that has not ended; run its command again.")
        return _alone(page_of_sweep(table(plan, rows).assign_attrs(_origin_of(place)), plan), continuum)
    with reading(place), open_result(place) as dataset:
        if "family" in dataset.attrs:
            with understanding(place, "study"), open_study(place) as tree:
                return _alone(page_of_study(tree), continuum)
        require("period" not in dataset.attrs, f"{place} is an orbit, which has no page; draw it with mol-compactons plot.")
        check_form(dataset, place)
        return _of_result(dataset, status_of(dataset, place), continuum)


def _origin_of(folder: Path) -> dict[str, Any]:
    """What made a sweep, as its table says; nothing where it has not ended."""
    path = folder / TABLE
    if not path.is_file():
        return {}
    with reading(path), open_result(path) as dataset:
        return dict(dataset.attrs)


def _alone(page: Page, continuum: object) -> Page:
    require(continuum is None, "Only a chain has a continuum beside it; leave it out.")
    return page


def _of_result(dataset: xr.Dataset, status: str, continuum: str | Path | xr.Dataset | None) -> Page:
    if not isinstance(continuum, str | Path):
        return page_of_result(dataset, status, continuum)
    with reading(continuum), open_result(continuum) as other:
        check_form(other, continuum)
        return page_of_result(dataset, status, other)
