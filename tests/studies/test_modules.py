from __future__ import annotations

import sys
from pathlib import Path

import pytest

from mol_compactons import InputError
from mol_compactons.configuration import encode
from mol_compactons.studies.modules import load, modules_of
from tests.studies.sweeps import small

MINE = """
from dataclasses import dataclass

@dataclass(frozen=True)
class Thing:
    a: int = 1
"""


def test_classes_of_this_package_need_no_module_and_others_their_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert modules_of(encode(small())) == {}
    (tmp_path / "things_of_mine.py").write_text(MINE, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    __import__("things_of_mine")
    tree = {"type": "Simulation", "initial": [{"type": "things_of_mine:Thing", "a": 1}]}
    assert modules_of(tree, {"axes": [tree]}) == {"things_of_mine": str(tmp_path / "things_of_mine.py")}
    monkeypatch.delitem(sys.modules, "things_of_mine")


def test_a_module_is_loaded_by_its_name_or_from_its_file_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "found_by_file.py"
    path.write_text(MINE, encoding="utf-8")
    load({"found_by_file": str(path), "json": ""})
    module = sys.modules["found_by_file"]
    assert module.Thing().a == 1
    load({"found_by_file": str(path)})
    assert sys.modules["found_by_file"] is module
    monkeypatch.delitem(sys.modules, "found_by_file")


@pytest.mark.parametrize("content", ["1 / 0", "import nothing_of_this_name", "raise SystemExit"])
def test_one_that_cannot_be_loaded_is_one_sentence(content: str, tmp_path: Path) -> None:
    path = tmp_path / "broken_module.py"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match="cannot load the module broken_module"):
        load({"broken_module": str(path)})
    assert "broken_module" not in sys.modules
    with pytest.raises(InputError, match="put the classes into a module that it finds"):
        load({"module_of_a_notebook": ""})
