"""The examples in the help of each command."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from mol_compactons import continuum_of, run
from mol_compactons.cli.common import simulation_of
from mol_compactons.cli.examples import EXAMPLES, examples_of, words_of
from mol_compactons.cli.parser import main, parser
from mol_compactons.cli.scenarios import load
from mol_compactons.cli.studies import family_of
from mol_compactons.cli.sweeps import _refinement, _variation

COMMANDS: Any = next(action.choices for action in parser()._actions if isinstance(action.choices, dict))

ALL = [typed for examples in EXAMPLES.values() for typed, _ in examples]


def test_each_command_has_examples() -> None:
    assert set(EXAMPLES) == set(COMMANDS)


@pytest.mark.parametrize("typed", ALL)
def test_what_is_shown_is_understood(typed: str) -> None:
    assert parser().parse_args(words_of(typed)).command == words_of(typed)[0]


@pytest.mark.parametrize("command", EXAMPLES)
def test_a_shell_takes_the_lines_of_the_help_as_they_are(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main([command, "--help"])
    shown = capsys.readouterr().out
    assert examples_of(command) in shown
    lines = [line.strip() for line in examples_of(command).splitlines() if "mol-compactons" in line]
    assert [shlex.split(line)[1:] for line in lines] == [words_of(typed) for typed, _ in EXAMPLES[command]]


def test_those_of_looking_do_what_they_say() -> None:
    """On coarse results in the place of those that they name."""
    coarse = ["grid.size=200", "t_end=20", "frames=21", "integrator=Rosenbrock()"]
    assert main(["run", "two_bright", "--quiet", *(word for change in coarse for word in ("--set", change))]) == 0
    chain = replace(load("lattice_collision"), t_end=2.0, frames=5)
    run(chain, "lattice_collision.nc").close()
    run(continuum_of(chain, points_per_site=4), "lattice_collision_continuum.nc").close()
    for command in ("plot", "track"):
        for typed, _ in EXAMPLES[command]:
            assert main(words_of(typed)) == 0, typed
    pictures = {"two_bright.png", "fig.pdf", "map.png", "both.png"}
    assert {path.name for path in Path.cwd().iterdir() if path.suffix != ".nc"} == pictures


@pytest.mark.parametrize("typed", [typed for typed, _ in EXAMPLES["sweep"]])
def test_those_of_sweeps_vary_what_is_there(typed: str) -> None:
    options = parser().parse_args(words_of(typed))
    assert callable(_refinement(options) if options.refine else _variation(options))


@pytest.mark.parametrize("typed", [typed for typed, _ in EXAMPLES["converge"]])
def test_those_of_studies_are_families(typed: str) -> None:
    options = parser().parse_args(words_of(typed))
    assert len(list(family_of(options).completed(simulation_of(options)).members(simulation_of(options)))) > 1
