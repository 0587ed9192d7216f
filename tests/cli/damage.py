"""Damage to the files of results: bytes, attributes, variables, values, and the simulations that they carry."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from tests.cli.hostile import fields_of

Damage = Callable[[Path, random.Random], None]


def truncate(path: Path, chance: random.Random) -> None:
    """Cut the end off."""
    whole = path.read_bytes()
    path.write_bytes(whole[: chance.randrange(len(whole))])


def flip_bits(path: Path, chance: random.Random) -> None:
    """Flip one to eight bits."""
    content = bytearray(path.read_bytes())
    for _ in range(chance.choice((1, 1, 1, 2, 8))):
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    path.write_bytes(content)


def remove_attributes(path: Path, chance: random.Random) -> None:
    """Take away an attribute of the file or of a variable."""
    with netCDF4.Dataset(path, "a") as file:
        owner: Any = chance.choice([file, file, *file.variables.values()])
        names = [name for name in owner.ncattrs() if not name.startswith("_")]
        for name in chance.sample(names, min(len(names), chance.choice((1, 1, 3)))):
            owner.delncattr(name)


def forge_attributes(path: Path, chance: random.Random) -> None:
    """Give an attribute a value of another kind."""
    with netCDF4.Dataset(path, "a") as file:
        owner: Any = chance.choice([file, file, *file.variables.values()])
        names = [name for name in owner.ncattrs() if not name.startswith("_")]
        if names:
            forged = chance.choice(
                ["", "x" * 5000, "{}", "[]", "null", "[1]", '{"type": 1}', 7, -1, 1e300, np.nan, r"$\frac$"]
            )
            owner.setncattr(chance.choice(names), forged)


def changed(path: Path, change: Callable[[xr.Dataset], xr.Dataset]) -> None:
    with xr.open_dataset(path) as dataset:
        whole = dataset.load()
    whole.encoding.clear()
    path.unlink()
    change(whole).to_netcdf(path, engine="netcdf4")


def remove_variables(path: Path, chance: random.Random) -> None:
    """Take away a variable or a coordinate."""
    changed(path, lambda dataset: dataset.drop_vars(chance.choice(sorted(map(str, dataset.variables)))))


def reshape(path: Path, chance: random.Random) -> None:
    """Give a variable one dimension more or less, or take away frames and points."""

    def change(dataset: xr.Dataset) -> xr.Dataset:
        name = chance.choice(sorted(map(str, dataset.data_vars)))
        space = next(str(one) for one in dataset[name].dims or ("t",))
        changes: list[Callable[[], xr.Dataset]] = [
            lambda: dataset.assign({name: dataset[name].expand_dims(z=2)}),
            lambda: dataset.assign({name: dataset[name].isel({space: 0}, drop=True)}),
            lambda: dataset.isel({space: slice(0, chance.choice((0, 1, 2, 5)))}),
            lambda: dataset.isel({space: slice(None, None, 2)}),
            lambda: dataset.rename({space: "z"}),
        ]
        return chance.choice(changes)()

    changed(path, change)


def spoil(path: Path, chance: random.Random) -> None:
    """Put NaN, infinity, something huge or equal numbers, or texts, in the place of values."""

    def change(dataset: xr.Dataset) -> xr.Dataset:
        name = chance.choice(sorted(map(str, dataset.variables)))
        array = dataset[name].values.copy()
        if chance.random() < 0.2:
            return dataset.assign(
                {name: (dataset[name].dims, np.full(array.shape, "text", dtype=object), dataset[name].attrs)}
            )
        places = slice(None) if chance.random() < 0.4 else chance.randrange(len(array))
        array[places] = chance.choice((np.nan, np.inf, 1e300, -1e308, 0.0, 1e-300))
        return dataset.assign({name: (dataset[name].dims, array, dataset[name].attrs)})

    changed(path, change)


LITERALS: list[Any] = [
    None,
    True,
    "",
    "x" * 4000,
    -1,
    0,
    3,
    1e8,
    10**8,
    1e200,
    -1e308,
    [],
    {},
    [[]],
    {"type": "Grid"},
    {"type": 1},
]


def forge_json(text: str, chance: random.Random) -> str:
    """The JSON of a simulation with one to three values replaced or left out, or with digits and levels beyond measure."""
    settings = json.loads(text)
    for _ in range(chance.choice((1, 1, 3))):
        *way, last = chance.choice(sorted(fields_of(settings)) or ["type"]).split(".")
        branch = settings
        for step in way:
            branch = branch[int(step)] if isinstance(branch, list) else branch[step]
        place: Any = int(last) if isinstance(branch, list) else chance.choice((last, last, last, "type"))
        if chance.random() < 0.2:
            branch.pop(place, None) if isinstance(branch, dict) else branch.pop(place)
        else:
            branch[place] = chance.choice([*LITERALS, "MARK", "MARK"])
    deep = chance.choice(["9" * 5000, "[" * 1500 + "]" * 1500, '{"a":' * 1500 + "1" + "}" * 1500, "NaN", "1e999", "["])
    return json.dumps(settings).replace('"MARK"', deep)


def forge_simulation(path: Path, chance: random.Random) -> None:
    """Put a forged simulation into a result."""
    with netCDF4.Dataset(path, "a") as file:
        file.setncattr("simulation", forge_json(file.getncattr("simulation"), chance))


WELL_FORMED: list[Damage] = [remove_attributes, forge_attributes, remove_variables, reshape, spoil]
