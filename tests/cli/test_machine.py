from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons.cli.machine import plain, records, tell_json
from mol_compactons.cli.parser import main

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)


@given(VALUES)
def test_every_value_is_json_that_comes_back(value: Any) -> None:
    def expected(one: Any) -> Any:
        if isinstance(one, dict):
            return {key: expected(item) for key, item in one.items()}
        if isinstance(one, list):
            return [expected(item) for item in one]
        return None if isinstance(one, float) and not math.isfinite(one) else one

    assert json.loads(json.dumps(plain(value), allow_nan=False)) == expected(value)


def test_arrays_and_records_are_plain(capsys: pytest.CaptureFixture[str]) -> None:
    tell_json({"a": np.array([[1.0, np.nan]]), "b": np.float64(2), "c": (np.int64(3),)})
    assert json.loads(capsys.readouterr().out) == {"a": [[1.0, None]], "b": 2.0, "c": [3]}
    table = xr.Dataset({"speed": ("wave", [1.0, 2.0]), "path": (("t", "wave"), [[1, 2], [3, 4]])}, {"wave": [0, 1]})
    assert records(table, "wave") == [{"wave": 0, "speed": 1.0, "path": [1, 3]}, {"wave": 1, "speed": 2.0, "path": [2, 4]}]


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("json") / "one.nc"
    changes = ["--set", "t_end=2", "--set", "frames=21", "--set", "grid.size=300"]
    assert main(["run", "two_bright", "-o", str(path), "--quiet", *changes]) == 0
    return path


def asked(capsys: pytest.CaptureFixture[str], *words: str, status: int = 0) -> Any:
    assert main([*words, "--json"]) == status
    captured = capsys.readouterr()
    assert captured.err == ""
    return json.loads(captured.out)


def test_info_of_a_result(result: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = asked(capsys, "info", str(result))
    assert told["status"] == "complete"
    assert told["sizes"] == {"t": 21, "x": 300}
    assert told["last_time"] == 2
    assert told["simulation"]["grid"]["size"] == 300
    assert [wave["speed"] for wave in told["waves"]] == [1, 0.25]
    assert 0 <= told["drift"]["mass"] < 1e-10


def test_track_and_doctor(result: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = asked(capsys, "track", str(result))
    assert len(told["t"]) == 21
    assert len(told["waves"]) == 2
    assert told["waves"][0]["position"][-1] - told["waves"][0]["position"][0] == pytest.approx(2, abs=0.1)
    assert told["collisions"][0]["phase_shift"] is None
    status = main(["doctor", str(result)])
    capsys.readouterr()
    findings = asked(capsys, "doctor", str(result), status=status)
    assert {"check", "verdict", "sentence"} == set(findings[0])
    assert any(finding["verdict"] == "contradicts" for finding in findings) == bool(status)


def test_converge_stability_and_what_they_store(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = ["converge", "single_compacton", "--set", "t_end=1", "--set", "frames=5", "--sizes", "75,150"]
    told = asked(capsys, *words, "--schemes", "ConservativeScheme,CompactScheme", "-o", str(tmp_path / "s.nc"))
    assert set(told["verdicts"]) == {"viscous"}
    assert {one["quantity"] for one in told["quantities"]} >= {"profile", "mass drift"}
    assert {(one["scheme"].split("(")[0], one["size"]) for one in told["schemes"]} == {
        (scheme, size) for scheme in ("ConservativeScheme", "CompactScheme") for size in (75, 150)
    }
    again = asked(capsys, "info", str(tmp_path / "s.nc"))
    assert again["quantities"] == told["quantities"]
    assert main(["plot", str(tmp_path / "s.nc"), "--kind", "schemes"]) == 0
    assert (tmp_path / "s.png").stat().st_size > 10_000
    capsys.readouterr()
    stability = asked(capsys, "stability", "sizes=30,60,120", "n=3")
    assert stability["verdicts"]


def test_a_sweep(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = ["sweep", "single_compacton", "--set", "t_end=0.2", "--set", "frames=3", "--vary", "grid.size=100,120"]
    assert main([*words, "--workers", "1", "--untracked", "--quiet", "-o", str(tmp_path / "s")]) == 0
    capsys.readouterr()
    told = asked(capsys, "info", str(tmp_path / "s"))
    assert told["varied"] == {"grid.size": ["100", "120"]}
    assert told["table"]["data_vars"]["status"]["data"] == ["complete", "complete"]
