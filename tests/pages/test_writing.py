from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import xarray as xr

from mol_compactons import InputError, run, write_report, write_tree
from tests.pages.conftest import PAIR


def test_files_and_what_is_in_memory_make_the_same_page(pair: xr.Dataset, study: xr.DataTree, tmp_path: Path) -> None:
    with run(PAIR, tmp_path / "pair.nc") as stored:
        write_report(stored, tmp_path / "memory.html")
    write_report(tmp_path / "pair.nc", tmp_path / "file.html")
    assert (tmp_path / "memory.html").read_bytes() == (tmp_path / "file.html").read_bytes()
    write_tree(study, tmp_path / "study.nc")
    write_report(tmp_path / "study.nc", tmp_path / "s.html")
    write_report(study, tmp_path / "t.html")
    assert (tmp_path / "s.html").read_bytes() == (tmp_path / "t.html").read_bytes()


def test_a_sweep_says_what_made_it_and_how_it_is_cited(swept: Path, tmp_path: Path) -> None:
    text = write_report(swept, tmp_path / "a.html").read_text(encoding="utf-8")
    with xr.open_dataset(swept / "table.nc") as table:
        assert f"<p>{table.attrs['source']}</p>" in text
        assert f"To be cited: {table.attrs['references']}." in text
    going_on = tmp_path / "going_on"
    shutil.copytree(swept, going_on)
    (going_on / "table.nc").unlink()
    text = write_report(going_on, tmp_path / "b.html").read_text(encoding="utf-8")
    assert "The source is not stated." in text


def test_a_page_is_replaced_only_when_asked(pair: xr.Dataset, tmp_path: Path) -> None:
    path = tmp_path / "a.html"
    path.write_text("precious")
    with pytest.raises(InputError, match="exists"):
        write_report(pair, path)
    assert path.read_text() == "precious"
    assert write_report(pair, path, overwrite=True) == path
    assert path.read_text().startswith("<!doctype html>")


def test_what_has_no_page_is_one_sentence(pair: xr.Dataset, study: xr.DataTree, swept: Path, tmp_path: Path) -> None:
    page = tmp_path / "a.html"
    for source, words in [
        (tmp_path / "no.nc", "There is no file"),
        (tmp_path, "holds no study"),
    ]:
        with pytest.raises(InputError, match=words):
            write_report(source, page)
    with pytest.raises(InputError, match=r"must end in \.html"):
        write_report(pair, tmp_path / "a.pdf")
    for other in (study, swept):
        with pytest.raises(InputError, match="Only a chain has a continuum"):
            write_report(other, page, continuum=pair)
    with pytest.raises(InputError):
        write_report(pair, page, continuum=pair)
    assert list(tmp_path.iterdir()) == []
