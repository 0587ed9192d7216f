from __future__ import annotations

from pathlib import Path

import pytest

from mol_compactons import run
from mol_compactons.cli.parser import main
from tests.figures.test_animation import by_pillow
from tests.systems import one_compacton


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(one_compacton(size=60, t_end=1, frames=12), tmp_path / "pair.nc").close()
    assert main(["animate", str(tmp_path / "pair.nc"), "--most-frames", "5", "--rate", "10", "--speed", "0.5"]) == 0
    assert "5 pictures, 0.5 s" in capsys.readouterr().out
    assert len(by_pillow(tmp_path / "pair.webp")) == 5
    assert main(["animate", str(tmp_path / "pair.nc")]) == 2
    assert "exists" in capsys.readouterr().err
    assert main(["animate", str(tmp_path / "pair.nc"), "-o", str(tmp_path / "x.avi")]) == 2
    assert "must end in .mp4, .gif or .webp" in capsys.readouterr().err
    assert not (tmp_path / "x.avi").exists()
