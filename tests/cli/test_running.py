from __future__ import annotations

from pathlib import Path

import pytest
import xarray as xr

from mol_compactons import Simulation
from mol_compactons.analysis.drift import drift
from mol_compactons.cli.parser import main
from tests.cli.conftest import QUICK, ROOT
from tests.screen import terminal


def test_a_run_says_what_it_wrote_what_it_kept_and_what_it_cost(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(ROOT / "scenarios" / "single_compacton.py"), "-o", "one.nc", *QUICK]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["wrote", "kept", "cost"]
    assert lines[0] == "wrote one.nc: W(t, x), 6 frames on 150 points to t = 0.5, complete"
    with xr.open_dataset("one.nc") as dataset:
        parts = [f"{name} to {float(abs(change).max()):.1e}" for name, change in drift(dataset).data_vars.items()]
        assert lines[1] == f"kept {', '.join(parts)}"
        counts = [dataset.attrs[f"solver_{name}"] for name in ("steps", "evaluations", "jacobians", "failures", "warnings")]
        assert [int(part.split()[-2]) for part in lines[2].split(";")[0].split(",")] == counts
        assert min(counts[:3]) > 0
        assert len({*counts[:3]}) == 3


def test_the_file_has_the_name_of_the_scenario_where_none_is_given() -> None:
    assert main(["run", "two_dark", "--quiet", *QUICK]) == 0
    assert [path.name for path in Path().iterdir()] == ["two_dark.nc"]


def test_what_is_set_is_what_is_run() -> None:
    changes = ["--set", "equation.n=2", "--set", "initial.0.speed=1/2", "--set", "integrator=Rosenbrock(rtol=1e-3)"]
    assert main(["run", "single_compacton", "-o", "set.nc", "--quiet", *QUICK, *changes]) == 0
    with xr.open_dataset("set.nc") as dataset:
        simulation = Simulation.from_json(dataset.attrs["simulation"])
        assert repr(simulation.equation) == "GranularCompacton(n=2.0)"
        assert repr(simulation.integrator) == "Rosenbrock(rtol=0.001, atol=None, max_step=None, max_steps=100000)"
        assert dataset.sizes == {"t": 6, "x": 150}
        # n = 2: M = (c (n+1) / 2)^(1/(n-1)) = 3 c / 2
        assert float(dataset.W[0].max()) == pytest.approx(0.75, rel=1e-2)


def test_a_result_repeats_itself_bit_for_bit() -> None:
    assert main(["run", "two_bright", "-o", "a.nc", "--quiet", *QUICK]) == 0
    assert main(["run", "a.nc", "-o", "again.nc", "--quiet"]) == 0
    with xr.open_dataset("a.nc") as first, xr.open_dataset("again.nc") as second:
        xr.testing.assert_equal(first, second)
        assert first.attrs["simulation"] == second.attrs["simulation"]


def test_quiet_says_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "single_compacton", "--quiet", *QUICK]) == 0
    printed = capfd.readouterr()
    assert (printed.out, printed.err) == ("", "")
    assert Path("single_compacton.nc").exists()


def test_a_terminal_gets_a_bar_in_simulated_time_and_a_log_none_for_so_short_a_run(capfd: pytest.CaptureFixture[str]) -> None:
    with terminal() as screen:
        assert main(["run", "single_compacton", *QUICK]) == 0
        assert "t = 0 / 0.5" in screen()
    assert main(["run", "single_compacton", "--overwrite", *QUICK]) == 0
    assert capfd.readouterr().err == ""


def test_an_existing_result_is_replaced_only_when_asked(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "single_compacton", "-o", "one.nc", "--quiet", *QUICK]) == 0
    before = Path("one.nc").read_bytes()
    assert main(["run", "single_compacton", "-o", "one.nc", "--quiet", *QUICK]) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert Path("one.nc").read_bytes() == before
    assert main(["run", "single_compacton", "-o", "one.nc", "--quiet", "--overwrite", *QUICK[2:], "--set", "t_end=0.25"]) == 0
    with xr.open_dataset("one.nc") as dataset:
        assert float(dataset.t[-1]) == 0.25
