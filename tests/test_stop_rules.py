from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from mol_compactons import (
    IDA,
    BlowUp,
    Compacton,
    ConservativeScheme,
    DriftBound,
    GranularCompacton,
    Grid,
    InputError,
    Midpoint,
    Rosenbrock,
    Simulation,
    SteadyState,
    StopRule,
    Uniform,
    WallClock,
    drift,
    run,
)
from mol_compactons.semidiscrete import SemiDiscretization
from mol_compactons.stop_rules import Patient, SoFar, Watcher
from tests.systems import Array, one_compacton

WAVE = replace(one_compacton(t_end=1, frames=11), integrator=Midpoint(step=0.05))


@dataclass(frozen=True)
class AtFrame(StopRule):
    """A rule of one's own."""

    number: int = 3

    def begin(self, system: SemiDiscretization, t: float, state: Array) -> Watcher:
        return _Counter(self.number)


class _Counter(Patient):
    def __init__(self, number: int) -> None:
        self._left = number

    def at_frame(self, t: float, state: Array, so_far: SoFar) -> str:
        self._left -= 1
        with so_far() as dataset:
            assert float(dataset.t[-1]) == t
            assert np.array_equal(dataset.W[-1], state[0])
        return "enough" if self._left == 0 else ""


@pytest.mark.parametrize("place", ["memory", "file"])
def test_a_run_that_was_stopped_says_so_and_goes_on(place: str, tmp_path: Path) -> None:
    path = tmp_path / "a.nc" if place == "file" else None
    with run(WAVE, path, stop=[WallClock(1000), AtFrame(4)]) as stopped:
        assert stopped.attrs["status"] == "stopped at t = 0.4: enough"
        assert stopped.sizes["t"] == 5
    if path:
        with run(WAVE, path, resume=True) as done:
            assert done.attrs["status"] == "complete"
            assert np.array_equal(done.W, run(WAVE).W)


def test_at_the_last_frame_there_is_nothing_to_stop() -> None:
    assert run(WAVE, stop=[AtFrame(10)]).attrs["status"] == "complete"


@pytest.mark.parametrize("integrator", [Midpoint(step=1e-3), IDA(max_step=1e-3), Rosenbrock(max_step=1e-3)])
def test_the_clock_stops_between_two_frames(
    integrator: Midpoint | IDA | Rosenbrock, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And the rest is done later."""
    simulation = replace(WAVE, frames=2, integrator=integrator)
    for module in ("rosenbrock", "sundials_integration"):
        monkeypatch.setattr(f"mol_compactons.integrators.{module}.REPORT_INTERVAL", 1e-4)
    with run(simulation, tmp_path / "a.nc", stop=[WallClock(1e-3)]) as stopped:
        assert stopped.attrs["status"].endswith(": 0.001 s have passed")
        assert stopped.sizes["t"] == 1
        assert 0 < float(stopped.attrs["status"].split("t = ")[1].split(":")[0]) < 1
    with run(simulation, tmp_path / "a.nc", resume=True) as done:
        whole = run(simulation)
        assert float(abs(done.W - whole.W).max()) <= (0 if integrator.exact_restart else 1e-4)


def test_a_state_that_stands_still_is_steady() -> None:
    simulation = Simulation(GranularCompacton(3), Grid(10, 40), [Uniform(0.5)], 50, ConservativeScheme(4), 51, Rosenbrock())
    assert run(simulation, stop=[SteadyState()]).attrs["status"] == "stopped at t = 1: the state stands still"
    assert run(WAVE, stop=[SteadyState()]).attrs["status"] == "complete"


def test_what_is_not_kept_stops_a_run() -> None:
    viscous = replace(WAVE, scheme=ConservativeScheme(4, viscosity=1e-2))
    whole = drift(run(viscous))
    bound = float(abs(whole.momentum[5])) * 0.999
    with run(viscous, stop=[DriftBound(bound, "momentum")]) as stopped:
        assert stopped.attrs["status"].startswith("stopped at t = 0.5: momentum has changed by ")
        assert stopped.sizes["t"] == 6
    with run(viscous, stop=[DriftBound(bound)]) as stopped:
        beyond = [bool(abs(whole[name][stopped.sizes["t"] - 1]) > bound) for name in whole.data_vars]
        before = [bool(abs(whole[name][stopped.sizes["t"] - 2]) > bound) for name in whole.data_vars]
        assert any(beyond)
        assert not any(before)
    assert run(viscous, stop=[DriftBound(bound, "mass")]).attrs["status"] == "complete"
    with pytest.raises(InputError, match="quantity = 'charge' is not conserved here; choose one of mass, momentum, energy"):
        run(viscous, stop=[DriftBound(quantity="charge")])


def growing(scheme: ConservativeScheme, equation: GranularCompacton, grid: Grid) -> SemiDiscretization:
    """A system that grows like e^t."""

    def rhs(t: float, state: Array, out: Array) -> None:
        out[:] = state

    return SemiDiscretization(grid.size, 1, 1, rhs, invariants=lambda state: {})


def test_growth_beyond_a_bound_is_a_blow_up(monkeypatch: pytest.MonkeyPatch) -> None:
    assert run(WAVE, stop=[BlowUp(2)]).attrs["status"] == "complete"
    monkeypatch.setattr(ConservativeScheme, "discretize", growing)
    with run(replace(WAVE, scheme=ConservativeScheme(4), t_end=5, frames=51), stop=[BlowUp(factor=20)]) as stopped:
        reached = float(stopped.t[-1])
        assert reached == pytest.approx(np.ceil(10 * np.log(20)) / 10)
        assert f"stopped at t = {reached:g}: the state is " in stopped.attrs["status"]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: WallClock(0), "seconds = 0 must be positive"),
        (lambda: BlowUp(1), "factor = 1 must be above 1"),
        (lambda: DriftBound(0), "bound = 0 must be positive"),
        (lambda: SteadyState(-1), "rate = -1 must be positive"),
    ],
)
def test_bad_settings_are_named(make: Callable[[], StopRule], words: str) -> None:
    with pytest.raises(InputError, match=words):
        make()


def test_what_observes_sees_each_frame_and_changes_nothing() -> None:
    seen: list[tuple[float, Array]] = []

    def observe(t: float, state: Array) -> None:
        seen.append((t, state.copy()))
        with pytest.raises(ValueError, match="read-only"):
            state[:] = 0

    dataset = run(WAVE, observe=observe)
    assert [t for t, _ in seen] == dataset.t.values.tolist()
    assert np.array_equal([state[0] for _, state in seen], dataset.W)
    xr.testing.assert_equal(dataset, run(WAVE))
    assert Compacton(1, 5).speed == 1


def test_a_rule_that_does_not_suit_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="quantity = 'charge'"):
        run(WAVE, tmp_path / "a.nc", stop=[DriftBound(quantity="charge")])
    assert list(tmp_path.iterdir()) == []
