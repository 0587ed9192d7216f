import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from compliance_checker.runner import CheckSuite, ComplianceChecker

from mol_compactons import InputError, IntegrationError, run
from mol_compactons.integrators import IDA
from tests.systems import one_compacton


def test_the_file_passes_the_cf_checker(tmp_path: Path) -> None:
    path = tmp_path / "result.nc"
    run(one_compacton(), path).close()
    CheckSuite.load_all_available_checkers()
    report = tmp_path / "report.txt"
    passed, errors = ComplianceChecker.run_checker(str(path), ["cf:1.11"], 0, "strict", output_filename=str(report))
    assert passed, report.read_text()
    assert not errors


def test_plain_xarray_reads_it_without_this_package(tmp_path: Path) -> None:
    path = tmp_path / "result.nc"
    run(one_compacton(), path).close()
    program = (
        "import sys; sys.modules['mol_compactons'] = None\n"
        "import xarray\n"
        f"dataset = xarray.open_dataset({str(path)!r})\n"
        "assert dataset.W.dims == ('t', 'x')\n"
        "for name in ('t', 'x', 'W', 'mass', 'momentum', 'energy'):\n"
        "    assert dataset[name].attrs['units'] == '1' and dataset[name].attrs['long_name'], name\n"
        "assert dataset.attrs['status'] == 'complete'\n"
        "print(float(dataset.W.sel(t=1).max()))\n"
    )
    printed = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert float(printed) == pytest.approx(np.sqrt(2), rel=0.02)


def test_an_existing_file_is_replaced_only_when_asked(tmp_path: Path) -> None:
    path = tmp_path / "result.nc"
    path.write_text("precious")
    with pytest.raises(InputError, match="exists; pass --overwrite"):
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


def test_a_killed_run_leaves_a_readable_file(tmp_path: Path) -> None:
    """SIGKILL in the middle: every frame up to the last synchronisation is there."""
    path = tmp_path / "killed.nc"
    program = (
        "from tests.systems import one_compacton\nfrom mol_compactons import run\n"
        f"run(one_compacton(size=600, t_end=1000, frames=100001), {str(path)!r})"
    )
    process = subprocess.Popen([sys.executable, "-c", program], cwd=Path(__file__).parent.parent)
    deadline = time.monotonic() + 120
    while not (path.exists() and path.stat().st_size > 300_000):
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait()
    with xr.open_dataset(path) as dataset:
        assert dataset.attrs["status"] == "running"
        assert dataset.sizes["t"] >= 16
        assert np.isfinite(dataset.W[:16]).all()
        assert np.isfinite(dataset.energy[:16]).all()
