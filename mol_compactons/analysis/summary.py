"""A result in a few lines: what is in it, how well it kept what is conserved, what it cost, and which waves it has."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mol_compactons.analysis.drift import drift
from mol_compactons.results.reading import field_names, space_of

if TYPE_CHECKING:
    import xarray as xr

TRACK_COLUMNS = ("t", "position", "height", "speed", "family_speed", "residual")
"""What is told of a wave."""


def contents(dataset: xr.Dataset) -> str:
    """One line: what is in a result."""
    fields = field_names(dataset)
    space = space_of(dataset)
    last = float(dataset["t"].max()) if dataset.sizes["t"] else 0.0
    names = " and ".join(f"{name}(t, {space})" for name in fields)
    return f"{names}, {dataset.sizes['t']} frames on {dataset.sizes[space]} points to t = {last:g}, {dataset.attrs['status']}"


def kept(dataset: xr.Dataset) -> str:
    """One line: how well the conserved quantities were kept, and relative to what where that is not the first value."""
    changes = drift(dataset)
    if not dataset.sizes["t"]:
        return "kept nothing: there is no frame"
    if not changes.data_vars:
        return "nothing is conserved"
    parts = []
    for name, change in changes.data_vars.items():
        meaning = change.attrs["relative_to"]
        of = "" if meaning == "its first value" else f" of {meaning}"
        parts.append(f"{name} to {float(abs(change).max()):.1e}{of}")
    return "kept " + ", ".join(parts)


def cost(dataset: xr.Dataset) -> str:
    """One line: what a run cost."""
    attributes = dataset.attrs
    if "solver_steps" not in attributes:
        return "cost unknown: the run has not ended"
    counts = ("steps", "evaluations", "jacobians", "failures", "warnings")
    numbers = ", ".join(f"{attributes[f'solver_{count}']} {count}" for count in counts)
    warning = f"; first warning: {attributes['solver_first_warning']}" if attributes["solver_warnings"] else ""
    return f"cost {numbers}; {attributes['cpu_seconds']:.2f} s of CPU time{warning}"


def waves_of(tracks: xr.Dataset) -> list[dict[str, Any]]:
    """Each wave when it was last clear of others and had a speed or, without such a frame, when it was last seen.

    Parameters
    ----------
    tracks : xarray.Dataset
        What `mol_compactons.track` returns.

    Returns
    -------
    list of dict
        The number of the ``wave``, when it was ``first_seen``, the `TRACK_COLUMNS`, and whether it is a ``compacton``.
    """
    rows = []
    for wave in range(tracks.sizes["wave"]):
        track = tracks.isel(wave=wave)
        flight = track["isolated"] & track["speed"].notnull()
        known = np.flatnonzero(flight if flight.any() else track["position"].notnull())
        now = track.isel(t=known[-1] if known.size else -1)
        told: dict[str, Any] = {name: float(now[name]) for name in ("first_seen", *TRACK_COLUMNS)}
        rows.append({"wave": int(track["wave"]), **told, "compacton": bool(now["compacton"])})
    return rows
