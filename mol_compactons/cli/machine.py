"""What commands say for other programs: JSON, in which a number that is none is null."""

from __future__ import annotations

import argparse
import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from mol_compactons.cli.speaking import tell

if TYPE_CHECKING:
    import xarray as xr


def add_json(parser: argparse.ArgumentParser) -> None:
    """The option that asks for JSON."""
    parser.add_argument("--json", action="store_true", help="print JSON, for other programs")


def tell_json(value: Any) -> None:
    """Print a value as JSON.

    Raises
    ------
    ListenerLostError, InputError
        As `tell`.
    """
    tell(json.dumps(plain(value), indent=1, allow_nan=False))


def plain(value: Any) -> Any:
    """A value of dicts, lists, numbers, texts and arrays as JSON has it; NaN and infinity are None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def records(dataset: xr.Dataset, along: str) -> list[dict[str, Any]]:
    """A Dataset as a list of what stands at each place along a dimension."""
    names = [*dataset.coords, *dataset.data_vars]
    places = (dataset.isel({along: index}) for index in range(dataset.sizes[along]))
    return [{str(name): place[name].values.tolist() for name in names} for place in places]
