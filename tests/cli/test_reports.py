from __future__ import annotations

from pathlib import Path

import pytest

from mol_compactons.cli.parser import main
from tests.cli.conftest import QUICK


def test_a_page_is_written_beside_the_result_and_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "single_compacton", "--quiet", *QUICK]) == 0
    assert main(["report", "single_compacton.nc"]) == 0
    assert capsys.readouterr().out.startswith("wrote single_compacton.html: ")
    assert Path("single_compacton.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    assert main(["report", "single_compacton.nc"]) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert main(["report", "single_compacton.nc", "--overwrite"]) == 0
    assert main(["report", "single_compacton.nc", "single_compacton.nc", "-o", "b.html"]) == 2
    assert main(["report", "nothing.nc", "-o", "b.html"]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 2
    assert not Path("b.html").exists()
