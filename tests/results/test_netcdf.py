import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from compliance_checker.runner import CheckSuite, ComplianceChecker

from mol_compactons import InputError, IntegrationError, Simulation, run
from mol_compactons.assignment import assign
from mol_compactons.cli import scenarios
from mol_compactons.integrators import IDA
from mol_compactons.results.opening import open_result, status_of
from mol_compactons.results.running_file import COUNT_PLACE, COUNT_SIZE
from tests.systems import one_compacton


def short(name: str) -> Simulation:
    """A scenario as it is, but for a short time."""
    return assign(scenarios.load(name), {"t_end": "0.01", "frames": "3"})


@pytest.mark.parametrize("name", list(scenarios.listing()))
def test_every_scenario_passes_the_cf_checker(name: str, tmp_path: Path) -> None:
    path = tmp_path / "result.nc"
    run(short(name), path).close()
    CheckSuite.load_all_available_checkers()
    report = tmp_path / "report.txt"
    passed, errors = ComplianceChecker.run_checker(str(path), ["cf:1.11"], 0, "strict", output_filename=str(report))
    assert passed, report.read_text()
    assert not errors


READER = """
import sys
sys.modules["mol_compactons"] = None
import xarray
for path in sys.argv[1:]:
    dataset = xarray.open_dataset(path)
    names = [name for name in dataset.variables]
    assert dataset.attrs["status"] == "complete"
    for name in names:
        assert dataset[name].attrs["units"] == "1" and dataset[name].attrs["long_name"], name
    print(*names)
"""


def test_plain_xarray_reads_every_scenario_without_this_package(tmp_path: Path) -> None:
    names = list(scenarios.listing())
    paths = [tmp_path / f"{name}.nc" for name in names]
    simulations = [short(name) for name in names]
    for simulation, path in zip(simulations, paths, strict=True):
        run(simulation, path).close()
    command = [sys.executable, "-I", "-c", READER, *map(str, paths)]
    printed = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path).stdout
    for simulation, line in zip(simulations, printed.splitlines(), strict=True):
        assert {"t", simulation.grid.dimension, "energy", *simulation.equation.variables} <= set(line.split())


def frames_counted(path: Path) -> int:
    with path.open("rb") as file:
        return int.from_bytes(file.read(COUNT_PLACE + COUNT_SIZE)[COUNT_PLACE:], "big")


def start_long_run(path: Path, size: int) -> subprocess.Popen[bytes]:
    """A run far too long for a test, in a process of its own, once its file has grown to some size and counts two frames."""
    arguments = ["run", "single_compacton", "-o", str(path), "--quiet", "--set", "t_end=1000", "--set", "frames=20001"]
    process = subprocess.Popen([sys.executable, "-m", "mol_compactons", *arguments], stderr=subprocess.PIPE)
    deadline = time.monotonic() + 120
    while not (path.exists() and path.stat().st_size > size and frames_counted(path) > 1):
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return process


def test_a_running_result_can_be_read(tmp_path: Path) -> None:
    path = tmp_path / "running.nc"
    process = start_long_run(path, 200_000)
    try:
        command = [sys.executable, "-m", "mol_compactons", "info", str(path)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    finally:
        process.kill()
        process.communicate()
    assert done.returncode == 0, done.stderr
    assert ", running" in done.stdout


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_a_run_in_order(number: signal.Signals, tmp_path: Path) -> None:
    path = tmp_path / "interrupted.nc"
    process = start_long_run(path, 100_000)
    process.send_signal(number)
    _, complaint = process.communicate(timeout=60)
    assert process.returncode == 128 + number
    assert b"interrupted" in complaint
    with xr.open_dataset(path) as dataset:
        assert dataset.attrs["status"].startswith("interrupted at t = ")
        assert np.isfinite(dataset.W).all()


def test_an_existing_file_is_replaced_only_when_asked(tmp_path: Path) -> None:
    path = tmp_path / "result.nc"
    path.write_text("precious")
    with pytest.raises(InputError, match="exists; allow overwriting"):
        run(one_compacton(), path)
    assert path.read_text() == "precious"
    run(one_compacton(), path, overwrite=True).close()
    assert xr.open_dataset(path).attrs["status"] == "complete"


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not exist"):
        run(one_compacton(), tmp_path / "nowhere" / "result.nc")
    with pytest.raises(InputError, match="is a folder"):
        run(one_compacton(), tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_failed_run_keeps_its_frames_and_says_so(tmp_path: Path) -> None:
    path = tmp_path / "failed.nc"
    simulation = one_compacton(
        size=600, t_end=2, frames=21, second_difference="nearest", viscosity=0.0, integrator=IDA(max_steps=800)
    )
    with pytest.raises(IntegrationError):
        run(simulation, path)
    with xr.open_dataset(path) as dataset:
        assert dataset.attrs["status"].startswith("failed at t = 0.")
        assert 0 < dataset.sizes["t"] < 21
        assert np.isfinite(dataset.W).all()


def test_an_interrupted_run_keeps_its_frames_and_says_so(tmp_path: Path) -> None:
    path = tmp_path / "interrupted.nc"

    def interrupt(t: float) -> None:
        if t > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(one_compacton(frames=11), path, report=interrupt)
    with xr.open_dataset(path) as dataset:
        assert dataset.attrs["status"].startswith("interrupted at t = 0.")
        assert 0 < dataset.sizes["t"] < 11


@pytest.mark.parametrize("size", [150_000, 400_000])
def test_a_killed_run_leaves_a_readable_file_and_looks_dead(size: int, tmp_path: Path) -> None:
    """SIGKILL in the middle: every frame that is counted is there."""
    path = tmp_path / "killed.nc"
    process = start_long_run(path, size)
    assert status_of(open_result(path), path) == "running"
    process.kill()
    process.communicate()
    with xr.open_dataset(path) as dataset:
        assert dataset.attrs["status"] == "running"
        assert dataset.sizes["t"] > 1
        assert np.isfinite(dataset.W).all()
        assert np.isfinite(dataset.energy).all()
        assert np.array_equal(dataset.t, np.arange(dataset.sizes["t"]) / 20)
        assert status_of(dataset, path) == f"killed after t = {float(dataset.t[-1]):.6g}"
