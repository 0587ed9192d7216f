from __future__ import annotations

import threading
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from mol_compactons import (
    Compacton,
    ConservativeScheme,
    FourierScheme,
    GaussLegendre,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    IntegrationError,
    Lattice,
    Midpoint,
    PowerContact,
    Rosenbrock,
    Samples,
    Simulation,
    SolitaryWave,
    Symplectic,
    course,
    run,
)
from mol_compactons.analysis.drift import drift
from mol_compactons.integrators import CVODE, IDA, Integrator
from mol_compactons.integrators.midpoint import MidpointIntegration
from mol_compactons.results import checkpoint, running_file

WAVE = Simulation(GranularCompacton(3), Grid(30, 75), [Compacton(1, 6)], 1, ConservativeScheme(4, grid_viscosity=0.03), 6)
RING = Grid(2 * np.pi, 16)
HILL = Samples(np.sqrt(2 + np.cos(RING.coordinates)))
SMOOTH = Simulation(GranularCompacton(3), RING, [HILL], 1, FourierScheme(), 6, Midpoint(step=0.1))
CHAIN = Simulation(
    GranularChain(PowerContact(1.5)), Lattice(40), [SolitaryWave(1, 20)], 1, frames=6, integrator=Symplectic(0.03)
)

EXACT = [
    replace(WAVE, integrator=Rosenbrock()),
    replace(WAVE, integrator=Rosenbrock(max_step=0.01)),
    replace(WAVE, integrator=Midpoint(step=0.03)),
    replace(WAVE, integrator=Midpoint(step=0.1, order=6)),
    replace(WAVE, integrator=Midpoint(step=0.1, points=2)),
    SMOOTH,
    replace(WAVE, integrator=GaussLegendre(step=0.07)),
    replace(WAVE, integrator=GaussLegendre(step=0.2, order=6)),
    CHAIN,
    replace(CHAIN, integrator=Rosenbrock()),
    replace(CHAIN, integrator=Symplectic(0.05, order=2)),
]
"""Simulations by methods that go on as if they had not been interrupted."""


def same(one: xr.Dataset, other: xr.Dataset) -> bool:
    """Bit for bit."""
    return all(np.array_equal(one[name], other[name]) for name in one.variables)


def names(simulation: Simulation) -> str:
    return f"{simulation.integrator!r} {simulation.series_per_frame}"


@pytest.mark.parametrize("simulation", EXACT, ids=names)
def test_five_and_five_are_ten(simulation: Simulation, tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    with run(simulation, path) as half:
        assert float((half - half.isel(t=0)).to_array().max()) > 0
    ten = simulation.extended(2)
    assert ten.frames == 11
    with run(replace(simulation, t_end=2), path, resume=True) as done:
        assert done.attrs["status"] == "complete"
        assert Simulation.from_json(done.attrs["simulation"]) == ten
        assert "went on from t = " in done.attrs["history"].splitlines()[1]
        assert same(done, run(ten))
        cost = [run(ten).attrs[f"solver_{name}"] for name in ("steps", "evaluations")]
        assert [done.attrs[f"solver_{name}"] for name in ("steps", "evaluations")] == pytest.approx(cost, abs=8)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    "simulation",
    [*EXACT[:4], EXACT[6], CHAIN, *(replace(one, series_per_frame=3) for one in (EXACT[0], EXACT[2], CHAIN))],
    ids=names,
)
@pytest.mark.parametrize("after", [0.35, 0.95])
def test_what_was_interrupted_between_two_frames_goes_on_as_if_it_had_not_been(
    simulation: Simulation, after: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(course, "CHECKPOINT_SECONDS", -1.0)
    path = tmp_path / "a.nc"

    def interrupt(t: float) -> None:
        if t > after:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(simulation, path, report=interrupt)
    found = checkpoint.last(path)
    assert found is not None
    assert 0 < found.t < 1.2
    with xr.open_dataset(path) as left:
        assert left.attrs["status"].startswith("interrupted at t = ")
        assert 0 < left.sizes["t"] < simulation.frames
    with run(simulation, path, resume=True) as done:
        assert same(done, run(simulation))
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("integrator", [IDA(), IDA(linear_solver="sparse"), CVODE(rtol=1e-6)], ids=repr)
def test_sundials_goes_on_to_its_tolerance(integrator: Integrator, tmp_path: Path) -> None:
    simulation = replace(WAVE, integrator=integrator)
    path = tmp_path / "a.nc"
    run(simulation, path).close()
    with run(replace(simulation, t_end=3), path, resume=True) as done:
        exact = run(simulation.extended(3))
        assert np.array_equal(done.t, exact.t)
        assert same(done.isel(t=slice(6)), exact.isel(t=slice(6)))
        assert float(abs(done.W - exact.W).max()) < 10 * integrator.own_tolerance * float(exact.W.max())


@settings(max_examples=12)
@given(st.integers(0, 20), st.sampled_from([EXACT[0], EXACT[2], CHAIN]))
def test_any_number_of_interruptions_changes_nothing(seed: int, simulation: Simulation) -> None:
    import tempfile

    random = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "a.nc")
        for _ in range(4):
            steps = count()
            last = int(random.integers(1, 12))

            def interrupt(t: float, steps: Any = steps, last: int = last) -> None:
                if next(steps) >= last:
                    raise KeyboardInterrupt

            try:
                run(simulation, path, resume=True, report=interrupt).close()
            except KeyboardInterrupt:
                continue
        with run(simulation, path, resume=True) as done:
            assert same(done, run(simulation))


def test_a_finished_run_does_nothing(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    run(WAVE, path, resume=True).close()
    before = path.read_bytes(), path.stat().st_mtime_ns
    for t_end in (1.0, 0.4):
        with run(replace(WAVE, t_end=t_end), path, resume=True) as done:
            assert done.sizes["t"] == 6
    assert (path.read_bytes(), path.stat().st_mtime_ns) == before


def test_without_checkpoints_it_goes_on_from_the_last_frame(tmp_path: Path) -> None:
    """As where the file alone was copied to another machine."""
    path = tmp_path / "a.nc"
    simulation = replace(WAVE, integrator=Rosenbrock(rtol=1e-6))
    part = run(simulation).isel(t=slice(4)).assign_attrs(status="running")
    part.to_netcdf(path)
    with run(simulation, path, resume=True) as done:
        exact = run(simulation)
        assert done.attrs["status"] == "complete"
        assert float(abs(done.W - exact.W).max()) < 1e-5
        assert "went on from t = 0.6" in done.attrs["history"]


@pytest.mark.parametrize("damage", ["nan", "time"])
def test_frames_that_are_damaged_are_dropped_and_made_again(damage: str, tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    whole = run(EXACT[2])
    part = whole.load().copy(deep=True).assign_attrs(status="running")
    if damage == "nan":
        part.W[3, 7] = np.nan
    else:
        part = part.assign_coords(t=np.where(np.arange(6) == 3, 0.61, part.t))
    part.to_netcdf(path)
    with run(EXACT[2], path, resume=True) as done:
        assert "went on from t = 0.4" in done.attrs["history"]
        assert float(abs(done.W - whole.W).max()) < 1e-6


class Breaking(MidpointIntegration):
    """A midpoint rule that gives up in the middle of its eighth step."""

    def _part(self, step: float) -> None:
        super()._part(step)
        if self.counters.steps == 7:
            raise IntegrationError("It broke.", self._t)


def test_a_failure_in_the_middle_of_a_step_leaves_nothing_to_go_on_from_but_the_frames(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, simulation = tmp_path / "a.nc", EXACT[3]
    monkeypatch.setattr("mol_compactons.integrators.midpoint.MidpointIntegration", Breaking)
    with pytest.raises(IntegrationError, match="It broke"):
        run(simulation, path)
    monkeypatch.undo()
    with pytest.raises(OSError, match="group not found"):
        xr.open_dataset(path, group="restart")
    with run(simulation, path, resume=True) as done:
        assert "went on from t = 0.6" in done.attrs["history"]
        assert float(abs(done.W - run(simulation).W).max()) < 1e-10


def test_checkpoints_of_another_run_are_left_aside(tmp_path: Path) -> None:
    path, other = tmp_path / "a.nc", tmp_path / "b.nc"
    run(EXACT[2], path, keep_checkpoints=True).close()
    part = run(EXACT[2]).isel(t=slice(3)).assign_attrs(status="running")
    alien = replace(EXACT[2], initial=[Compacton(0.5, 12)])
    with pytest.raises(KeyboardInterrupt):
        run(alien, other, report=_interrupt_after(0.5))
    for mine, theirs in zip(checkpoint.places(path), checkpoint.places(other), strict=True):
        if theirs.exists():
            theirs.replace(mine)
    part.to_netcdf(path)
    with run(EXACT[2], path, resume=True) as done:
        assert float(abs(done.W - run(EXACT[2]).W).max()) < 1e-6


def _interrupt_after(t: float) -> Any:
    def report(now: float) -> None:
        if now > t:
            raise KeyboardInterrupt

    return report


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"initial": [Compacton(0.5, 6)]}, "The initial differs from that of"),
        ({"integrator": Rosenbrock(rtol=1e-3)}, "The integrator differs from that of"),
        ({"grid": Grid(30, 80)}, "The grid differs from that of"),
        ({"t_end": 1.3}, r"t_end = 1\.3 is no multiple of the distance of the frames, 0\.2; choose one, as 1\.2 or 1\.4\."),
        ({"frames": 50}, "frames = 50 differs from"),
    ],
)
def test_what_cannot_go_on_is_one_sentence_and_changes_nothing(changes: dict[str, Any], words: str, tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    run(WAVE, path).close()
    before = path.read_bytes()
    with pytest.raises(InputError, match=words):
        run(replace(WAVE, **changes), path, resume=True)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_run_that_is_alive_is_not_gone_on_from(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    seen: list[str] = []

    def look(t: float) -> None:
        if path.exists() and not seen:
            choices: list[dict[str, Any]] = [{"resume": True}, {"overwrite": True}]
            for options in choices:
                with pytest.raises(InputError, match="Another run is writing") as refused:
                    run(WAVE, path, **options)
                seen.append(str(refused.value))

    run(WAVE, path, report=look).close()
    assert len(seen) == 2


def test_resume_needs_a_file() -> None:
    with pytest.raises(InputError, match="resume goes on from a file; give its path"):
        run(WAVE, resume=True)


@given(
    st.integers(1, 40), st.integers(1, 40), st.sampled_from([0.1, 0.3, 0.75, 1 / 3, 14 / 0.7, 1e-5, 7.0]), st.integers(2, 30)
)
def test_output_times_are_the_same_as_far_as_both_go(short: int, more: int, spacing: float, frames: int) -> None:
    """Multiples of one number, each next to the exact one, whatever the end."""
    one = replace(WAVE, t_end=spacing * short, frames=frames)
    try:
        other = one.extended(one.t_end * (1 + more))
    except InputError:
        # A product that is not exact may lie between two output times.
        return
    assert np.array_equal(one.times, other.times[: one.frames])
    assert other.times[-1] == other.t_end
    assert (np.diff(other.times) > 0).all()


def test_the_times_are_decimal_where_the_settings_are() -> None:
    assert replace(WAVE, t_end=3, frames=31).times.tolist() == [index / 10 for index in range(31)]
    assert replace(WAVE, t_end=0.1, frames=2).extended(0.3).times.tolist() == [0, 0.1, 0.2, 0.3]


def test_the_memory_of_a_result_is_hidden_from_plain_xarray(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    run(EXACT[0], path).close()
    with xr.open_dataset(path) as dataset:
        assert set(dataset.variables) == {"t", "x", "W", "mass", "momentum", "energy"}
    with xr.open_dataset(path, group="restart") as group:
        kept = checkpoint.Checkpoint.from_bytes(group.checkpoint.values.tobytes())
        assert kept is not None
        assert kept.frames == 6
        assert 1 <= kept.t < 1.2


def test_the_old_result_stays_until_the_new_one_has_begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.nc"
    run(WAVE, path).close()
    before = path.read_bytes()
    with pytest.raises(KeyboardInterrupt):
        run(replace(WAVE, t_end=2), path, overwrite=True, report=_interrupt_after(-1))
    assert path.read_bytes() == before
    monkeypatch.setattr(running_file, "SYNC_SECONDS", -1.0)
    with pytest.raises(KeyboardInterrupt):
        run(replace(WAVE, t_end=2), path, overwrite=True, report=_interrupt_after(0.9))
    with xr.open_dataset(path) as begun:
        assert begun.attrs["status"].startswith("interrupted at t = ")
        assert Simulation.from_json(begun.attrs["simulation"]).t_end == 2


def test_two_threads_that_want_one_new_file_do_not_share_it(tmp_path: Path) -> None:
    """One of them gets it, the other is told so."""
    path, together = tmp_path / "a.nc", threading.Barrier(2)
    ends: list[str] = []

    def work() -> None:
        together.wait()
        try:
            with run(replace(WAVE, integrator=Midpoint(step=0.05)), path) as dataset:
                ends.append(dataset.attrs["status"])
        except Exception as error:
            ends.append(str(error))

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(end == "complete" for end in ends) == [False, True]
    assert any(word in " ".join(ends) for word in ("exists", "has made", "is writing", "has begun to write"))
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("simulation", [EXACT[0], EXACT[2], CHAIN], ids=names)
def test_output_times_of_ones_own_go_on_too(simulation: Simulation, tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    short = replace(simulation, output_times=[0, 0.1, 0.15, 1])
    longer = replace(simulation, output_times=[0, 0.1, 0.15, 1, 1.5, 4], t_end=4)
    with run(short, path) as dataset:
        assert dataset.t.values.tolist() == [0, 0.1, 0.15, 1]
        assert Simulation.from_json(dataset.attrs["simulation"]) == short
    with run(longer, path, resume=True) as done:
        assert same(done, run(longer))
    with pytest.raises(InputError, match="The output times differ from those of"):
        run(replace(simulation, output_times=[0, 0.2, 1, 5], t_end=5), path, resume=True)


def test_a_finished_run_without_room_for_its_memory_keeps_the_checkpoint_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To go on with nothing left to do changes nothing of what comes after."""
    path = tmp_path / "a.nc"

    def full(*arguments: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("mol_compactons.results.netcdf._compress", full)
    run(EXACT[0], path).close()
    monkeypatch.undo()
    assert len(list(tmp_path.iterdir())) == 2
    run(EXACT[0], path, resume=True).close()
    with run(replace(EXACT[0], t_end=2), path, resume=True) as done:
        assert same(done, run(EXACT[0].extended(2)))
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("lost", ["mass", "mass_series", "t_series"])
def test_a_result_that_lost_a_part_of_its_numbers_is_refused_and_nothing_is_left(lost: str, tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    simulation = replace(EXACT[0], series_per_frame=3)
    run(simulation).drop_vars(lost).to_netcdf(path)
    with pytest.raises(InputError, match=f"lacks {lost}, or a part of it, to go on from; run again with --overwrite"):
        run(replace(simulation, t_end=2), path, resume=True)
    assert list(tmp_path.iterdir()) == [path]
    with xr.open_dataset(path) as left:
        assert drift(left).energy.sizes["t"] == (16 if lost == "mass" else 6)
