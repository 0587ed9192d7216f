from __future__ import annotations

import argparse
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from mol_compactons import InputError
from mol_compactons.cli import common, scenarios

names = st.text("abcdefg._0123", min_size=1, max_size=10)


@given(st.dictionaries(names, st.text(max_size=10), max_size=4))
def test_what_stands_before_the_first_equals_sign_is_the_field(changes: dict[str, str]) -> None:
    assert common.assignments([f"{field}={value}" for field, value in changes.items()]) == changes


def test_a_field_without_a_value_or_with_two_is_refused() -> None:
    assert common.assignments([" grid.size =1200", "title=a=b"]) == {"grid.size": "1200", "title": "a=b"}
    with pytest.raises(InputError, match=r"'grid\.size' lacks a value; write FIELD=VALUE"):
        common.assignments(["grid.size"])
    with pytest.raises(InputError, match=r"grid\.size is given twice; give it once"):
        common.assignments(["grid.size=1", "grid.size =2"])


def test_options_make_a_simulation() -> None:
    parser = argparse.ArgumentParser()
    common.add_scenario(parser)
    options = parser.parse_args(["single_compacton", "--set", "grid.size=150", "--set", "initial.0.speed=1/2"])
    simulation = common.simulation_of(options)
    assert simulation.grid.size == 150
    assert "speed=0.5" in repr(simulation.initial[0])
    assert simulation.title == scenarios.load("single_compacton").title


def test_a_module_is_imported_where_it_is_asked_for_or_named(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setattr(common, "import_module", asked.append)
    parser = argparse.ArgumentParser()
    common.add_scenario(parser)
    options = parser.parse_args(["single_compacton", "--import", "one", "--set", "equation=other:Thing(n=3)"])
    with pytest.raises(InputError, match="other:Thing is not loaded"):
        common.simulation_of(options)
    assert asked == ["one", "other"]


def test_a_picture_is_written_and_said(capsys: pytest.CaptureFixture[str]) -> None:
    common.save(Figure(figsize=(1, 1)), Path("empty.PNG"))
    assert capsys.readouterr().out == "wrote empty.PNG\n"
    assert Path("empty.PNG").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(InputError, match=r"empty\.xyz has no picture format; end its name in .*pdf.*png"):
        common.save(Figure(), Path("empty.xyz"))
