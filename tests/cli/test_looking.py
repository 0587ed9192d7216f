from __future__ import annotations

import json
from pathlib import Path

import pytest
import xarray as xr

from mol_compactons import Compacton, run
from mol_compactons.cli.parser import main
from tests.analysis.painted import painted
from tests.cli.conftest import QUICK, ROOT
from tests.systems import one_compacton


@pytest.fixture
def result() -> str:
    """The name of a short result."""
    assert main(["run", "two_bright", "-o", "two.nc", "--quiet", *QUICK, "--set", "title=Two of them"]) == 0
    return "two.nc"


def test_info_says_what_is_in_a_result(result: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", result]) == 0
    lines = capsys.readouterr().out.splitlines()
    with xr.open_dataset(result) as dataset:
        assert lines[0] == dataset.attrs["title"]
        assert lines[-1] == dataset.attrs["history"]
    assert lines[0].startswith("Two of them: GranularCompacton(n=3); c = 1, 0.25; ")
    assert lines[1] == "W(t, x), 6 frames on 150 points to t = 0.5, complete"
    assert lines[2].startswith("kept mass to ")
    assert lines[3].startswith("cost ")
    assert lines[4] == "equation: GranularCompacton(n=3)"
    assert lines[5] == "grid: Grid(length=60, size=150, left=0)"
    assert [line for line in lines if line.startswith("initial: ")] == [
        "initial: Compacton(speed=1, center=5.5, sign=1)",
        "initial: Compacton(speed=0.25, center=15.5, sign=1)",
    ]


def test_info_shows_the_beginning_of_a_long_wave(result: str, capsys: pytest.CaptureFixture[str]) -> None:
    with xr.open_dataset(result) as dataset:
        long = dataset.load().copy()
    settings = json.loads(long.attrs["simulation"])
    settings["initial"] = [{"type": "elsewhere:Wave", "text": "x" * 200}]
    long.attrs["simulation"] = json.dumps(settings)
    long.to_netcdf("long.nc")
    assert main(["info", "long.nc"]) == 0
    (line,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("initial: ")]
    shown = line.removeprefix("initial: ")
    assert shown.startswith("elsewhere:Wave(text='xxx")
    assert len(shown) == 120


def test_plot_draws_beside_the_result_or_where_it_is_told(result: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plot", result]) == 0
    assert main(["plot", result, "-o", "other.pdf"]) == 0
    assert capsys.readouterr().out.splitlines() == ["wrote two.png", "wrote other.pdf"]
    assert Path("two.png").read_bytes().startswith(b"\x89PNG")
    assert Path("other.pdf").read_bytes().startswith(b"%PDF")


def test_a_picture_is_replaced_only_when_asked(result: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("two.png").write_text("precious")
    assert main(["plot", result]) == 2
    assert "two.png exists; allow overwriting" in capsys.readouterr().err
    assert Path("two.png").read_text() == "precious"
    assert main(["plot", result, "--overwrite"]) == 0
    assert Path("two.png").read_bytes().startswith(b"\x89PNG")


def test_one_frame_makes_no_picture(result: str, capsys: pytest.CaptureFixture[str]) -> None:
    with xr.open_dataset(result) as dataset:
        dataset.isel(t=slice(0, 1)).to_netcdf("short.nc")
    assert main(["plot", "short.nc"]) == 2
    assert "short.nc holds 1 frame(s); at least 2 are needed for a picture" in capsys.readouterr().err
    assert not Path("short.png").exists()
    assert main(["info", "short.nc"]) == 0


def test_scenarios_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scenarios"]) == 0
    listed = {line.split()[0]: line for line in capsys.readouterr().out.splitlines()}
    assert set(listed) == {path.stem for path in (ROOT / "scenarios").glob("*.py")}
    assert all(len(line.split()) > 3 for line in listed.values())


def test_a_picture_format_that_does_not_exist_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "single_compacton", "-o", "one.nc", "--quiet", *QUICK]) == 0
    assert main(["plot", "one.nc", "-o", "one.xyz"]) == 2
    assert "png" in capsys.readouterr().err
    assert not Path("one.xyz").exists()


def test_doctor_says_a_line_for_each_thing_and_fails_where_something_contradicts(
    result: str, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert main(["doctor", result]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "agrees       status: 6 frames to t = 0.5 of 0.5, complete."
    assert {line.split()[0] for line in lines} <= {"agrees", "doubtful"}
    with xr.open_dataset(result) as dataset:
        broken = dataset.load().copy(deep=True)
    broken.W[3] = float("nan")
    broken.to_netcdf("broken.nc")
    assert main(["doctor", "broken.nc"]) == 1
    assert capsys.readouterr().out.startswith("contradicts  frames: there are values that are no numbers, first at t = 0.3")
    assert main(["doctor", "nothing.nc"]) == 2
    assert capsys.readouterr().err == "mol-compactons: There is no file nothing.nc; give one that mol-compactons wrote.\n"


def test_track_prints_a_line_for_each_wave(capsys: pytest.CaptureFixture[str]) -> None:
    short = ["--set", "t_end=2", "--set", "frames=21", "--set", "grid.size=600"]
    assert main(["run", "two_bright", "-o", "two.nc", "--quiet", *short]) == 0
    capsys.readouterr()
    assert main(["track", "two.nc"]) == 0
    heads, *rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert heads == ["wave", "since", "t", "position", "height", "speed", "family_speed", "residual", "compacton"]
    assert [row[-1] for row in rows] == ["yes", "yes"]
    for row, (speed, center) in zip(rows, ((1, 5.5), (0.25, 15.5)), strict=True):
        _, since, t, position, height, measured, family, residual = (float(word) for word in row[:-1])
        assert (since, t) == (0, 1.9)
        assert position == pytest.approx(center + 1.9 * speed, abs=1e-2)
        assert height == pytest.approx((2 * speed) ** 0.5, rel=2e-3)
        assert measured == pytest.approx(speed, rel=0.03)
        assert family == pytest.approx(speed, rel=5e-3)
        assert 0 < residual < 5e-3
    assert main(["track", "two.nc", "--least-height", "-1"]) == 2
    assert "least_height = -1.0 must be positive" in capsys.readouterr().err
    assert main(["track", "nothing.nc"]) == 2


def test_track_tells_of_collisions_and_of_what_is_lost(capsys: pytest.CaptureFixture[str]) -> None:
    result = painted(3, [(Compacton(1, 8), 16, 2.5), (Compacton(0.25, 20), 16, -1.25)])
    result["W"][155:] = 0.0
    of_own_time = result.assign_attrs(status="complete", title="painted")
    of_own_time.to_netcdf("painted.nc")
    assert main(["track", "painted.nc"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 6
    assert [line.split()[:4] for line in lines[3:5]] == [["wave", "0", "is", "2.5"], ["wave", "1", "is", "-1.25"]]
    assert lines[5].startswith("Wave 0 is lost after t = 38.5")


@pytest.mark.parametrize("command", ["info", "plot", "track", "doctor"])
@pytest.mark.parametrize("name", [".", "..", "/", ""])
def test_a_folder_is_no_result(command: str, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, name]) == 2
    assert ("holds no study" if command == "info" else "There is no file ") in capsys.readouterr().err


def test_a_picture_of_another_kind_in_a_vector_format(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = tmp_path / "one.nc"
    run(one_compacton(size=60, t_end=1, frames=12), result).close()
    words = ["plot", str(result), "--overwrite", "-o"]
    pdf = str(tmp_path / "a.pdf")
    assert main([*words, pdf, "--kind", "snapshots", "--times", "0,1", "--window", "5:", "--style", "journal"]) == 0
    assert Path(pdf).read_bytes().startswith(b"%PDF")
    assert main([*words, str(tmp_path / "b.svg"), "--times", "0,1"]) == 0
    assert main(["plot", str(result), str(result), "-o", str(tmp_path / "c.svg")]) == 0
    assert "one" in (tmp_path / "c.svg").read_text()
    capsys.readouterr()
    for more, sentence in (
        (["--kind", "ladder"], "is a result; choose a --kind among waterfall"),
        (["--times", "a"], "--times a is not understood"),
        (["--window", "5"], "--window 5 is not understood; write FROM:TO"),
        (["--times", "9"], "t = 9 is beyond the result"),
    ):
        assert main([*words, pdf, *more]) == 2
        assert sentence in capsys.readouterr().err
    for second, more, sentence in (
        (str(tmp_path / "none.nc"), [], "There is no file"),
        (str(result), ["--kind", "map"], "shows one result; leave out the second"),
    ):
        assert main(["plot", str(result), second, *words[2:], pdf, *more]) == 2
        assert sentence in capsys.readouterr().err


def test_options_that_say_nothing_for_what_is_drawn_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    chain = ["converge", "head_on", "--set", "t_end=2", "--set", "frames=21", "--quiet", "-o", str(tmp_path / "chain.nc")]
    assert main(chain) == 0
    sweep = ["sweep", "single_compacton", "--set", "t_end=0.1", "--set", "frames=3", "--vary", "grid.size=60,80", "--quiet"]
    assert main([*sweep, "--untracked", "--workers", "1", "-o", str(tmp_path / "s")]) == 0
    capsys.readouterr()
    for words, sentence in (
        (["chain.nc", "--kind", "schemes"], "has no schemes to compare"),
        (["chain.nc", "--kind", "map"], "is a study; choose a --kind among ladder, schemes"),
        (["chain.nc", "--times", "1"], "is a study; leave out --times"),
        (["chain.nc", "other.nc"], "is a study; leave out other.nc"),
        (["s", "other.nc"], "is a sweep; leave out other.nc"),
        (["s", "--kind", "map"], "is a sweep; leave out --kind"),
        (["s", "--window", "1:2", "--style", "journal"], "is a sweep; leave out --window, --style"),
    ):
        assert main(["plot", str(tmp_path / words[0]), *words[1:]]) == 2
        assert sentence in capsys.readouterr().err
    assert not list(tmp_path.glob("*.png"))
