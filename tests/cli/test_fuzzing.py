"""Hostile command lines, simulations and files: whatever comes in, one sentence goes out, or the answer.

Each input is run by `main` in this process. What is drawn is built of real commands, fields and files, so that most of it gets
past the parser and reaches what computes.
"""

from __future__ import annotations

import contextlib
import io
import random
import re
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mol_compactons import (
    Compacton,
    ConservativeScheme,
    GranularChain,
    GranularCompacton,
    Grid,
    Lattice,
    Midpoint,
    PowerContact,
    Simulation,
    run,
)
from mol_compactons.cli.parser import main
from mol_compactons.cli.speaking import LONGEST_SENTENCE
from tests.cli.damage import WELL_FORMED, Damage, flip_bits, forge_simulation, truncate
from tests.cli.hostile import QUICK, command_lines, other_lines

PATIENCE = 120
"""Seconds after which an input counts as one that hangs; the first of its kind compiles."""


class Hanging(Exception):  # noqa: N818
    """An input took longer than `PATIENCE`."""


@contextlib.contextmanager
def patience() -> Iterator[None]:
    def give_up(number: int, frame: FrameType | None) -> None:
        raise Hanging

    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(PATIENCE)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def insist_on_an_answer(arguments: list[str]) -> int:
    """Run a command; it must end with 0, 1 or 2, say at most one sentence, and leave no file half written."""
    told, said = io.StringIO(), io.StringIO()
    with patience(), contextlib.redirect_stdout(told), contextlib.redirect_stderr(said):
        try:
            status = main(arguments)
        except SystemExit as leaving:
            status = leaving.code if isinstance(leaving.code, int) else 3
    sentence = said.getvalue().rpartition("\r")[2]  # what a progress bar drew is gone
    assert status in (0, 1, 2), sentence
    assert sentence.count("\n") <= 1, sentence
    assert len(sentence.strip()) <= len("mol-compactons: ") + LONGEST_SENTENCE, sentence
    assert bool(sentence) == bool(status) or arguments[0] == "doctor", sentence
    assert not [path.name for path in Path().iterdir() if re.fullmatch(r"\..*\.\d+-\d+\.\w+", path.name)]
    return status


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a small result of an equation, and one of a chain."""
    folder = tmp_path_factory.mktemp("results")
    waves = [Compacton(speed=1, center=6), Compacton(speed=0.5, center=18)]
    step = Midpoint(step=0.05)
    scheme = ConservativeScheme(viscosity=1e-3)
    line = Simulation(GranularCompacton(n=3), Grid(30, 90), waves, t_end=2, frames=9, scheme=scheme, integrator=step)
    run(line, folder / "line.nc").close()
    chain = GranularChain(PowerContact(n=1.5))
    run(Simulation(chain, Lattice(40), [Compacton(1, 10)], t_end=2, frames=9, integrator=step), folder / "chain.nc").close()
    return folder


RESUME = ["run", "-o", "damaged.nc", "--resume", "--quiet", "--stop", "WallClock(seconds=1)"]

PLOT = ["plot", "-o", "new.png", "--overwrite"]

LOOKS = [["info"]] * 6 + [["track"]] * 4 + [["doctor"]] * 4 + [["run"]] * 4 + [RESUME] * 3 + [PLOT]
"""Pictures take longest."""


def look_at(name: str, words: list[str]) -> None:
    """A command that reads a file, made short where it is a run."""
    quick = [word for field, value in QUICK.items() for word in ("--set", f"{field}={value}")]
    more = (
        [*quick, "-o", "new.nc", "--overwrite", "--quiet", "--stop", "WallClock(seconds=1)"] if words == ["run"] else words[1:]
    )
    insist_on_an_answer([words[0], name, *more])


def check_settings(results: Path, arguments: list[str]) -> None:
    """A run that ends well has frames, and no NaN in them."""
    if insist_on_an_answer(arguments) == 0:
        with xr.open_dataset("new.nc") as dataset:
            assert dataset.sizes["t"] >= 1
            assert all(np.isfinite(variable).all() for variable in dataset.data_vars.values())


def check_words(results: Path, arguments: list[str]) -> None:
    """Any words behind any command."""
    insist_on_an_answer(arguments)


def check_json(results: Path, name: str, words: list[str], seed: int) -> None:
    """A result whose simulation is forged."""
    shutil.copy(results / name, "damaged.nc")
    forge_simulation(Path("damaged.nc"), random.Random(seed))
    look_at("damaged.nc", words)


def check_files(results: Path, name: str, damages: list[Damage], words: list[str], seed: int) -> None:
    """A result with one damage after the other; the first of two may take what the second one needs."""
    shutil.copy(results / name, "damaged.nc")
    chance = random.Random(seed)
    for damage in damages:
        with contextlib.suppress(KeyError, StopIteration, IndexError, ValueError):
            damage(Path("damaged.nc"), chance)
    look_at("damaged.nc", words)


DAMAGED: dict[str, Any] = {
    "name": st.sampled_from(["line.nc", "chain.nc"]),
    "words": st.sampled_from(LOOKS),
    "seed": st.integers(0, 2**32),
}

BROKEN = st.one_of(
    st.lists(st.sampled_from([truncate, flip_bits]), min_size=1, max_size=1),
    st.lists(st.sampled_from(WELL_FORMED), min_size=1, max_size=2),
)

PROPERTIES: dict[str, tuple[Callable[..., None], dict[str, Any], int, int]] = {
    "settings": (check_settings, {"arguments": command_lines()}, 90, 1500),
    "words": (check_words, {"arguments": other_lines()}, 90, 2300),
    "simulations": (check_json, DAMAGED, 50, 600),
    "files": (check_files, DAMAGED | {"damages": BROKEN}, 50, 600),
}
"""What is checked, with what, and for how many inputs in the normal suite and in the long one, 5,000 in all."""


@pytest.mark.parametrize("name", PROPERTIES)
@pytest.mark.parametrize("long", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_every_input_has_an_answer_of_one_sentence(results: Path, name: str, long: bool) -> None:
    check, strategies, few, many = PROPERTIES[name]

    @settings(max_examples=many if long else few, suppress_health_check=list(HealthCheck))
    @given(**strategies)
    def inputs(**drawn: Any) -> None:
        check(results, **drawn)

    inputs()
