from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from mol_compactons import Compacton, IntegrationError, Simulation, first_collision, run, track
from mol_compactons.configuration import encode
from mol_compactons.results.schema import COMPLETE
from mol_compactons.studies import members
from mol_compactons.studies.members import Task, carry_out
from mol_compactons.studies.store import FAILED
from tests.studies.sweeps import peak, small


def task(simulation: Simulation, folder: Path, **settings: object) -> Task:
    return Task("n", "label", [[0]], {}, encode(simulation), str(folder / "n.nc"), **settings)  # type: ignore[arg-type]


def test_a_row_has_what_can_be_read_from_the_result(tmp_path: Path) -> None:
    simulation = replace(small(120), initial=[Compacton(1, 6), Compacton(0.25, 16)], t_end=2, frames=21)
    row = carry_out(task(simulation, tmp_path, quantities={"peak": peak}))
    dataset = run(simulation)
    collision = first_collision(track(dataset))
    assert (row["status"], row["reason"], row["places"]) == (COMPLETE, "", [[0]])
    numbers = row["quantities"]
    assert numbers["peak"] == float(dataset.W[-1].max())
    assert numbers["height_before"] == collision.height_before.values.tolist()
    assert numbers["solver_steps"] == dataset.attrs["solver_steps"]
    assert 0 < numbers["momentum_drift"] < 1e-2
    assert row["sizes"] == {"t": 21, "x": 120}


def test_one_that_was_cut_off_is_gone_on_with(tmp_path: Path) -> None:
    simulation = replace(small(), t_end=1, frames=11)
    seen: list[float] = []

    def stop(t: float, _: object) -> None:
        seen.append(t)
        if t > 0.4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(simulation, tmp_path / "n.nc", observe=stop)
    assert carry_out(task(simulation, tmp_path))["status"] == COMPLETE
    assert carry_out(task(simulation, tmp_path))["status"] == COMPLETE


@pytest.mark.parametrize("error", [IntegrationError("gave up", 1.0), ZeroDivisionError("a class of the user's own")])
def test_what_is_raised_becomes_a_reason(error: Exception, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(members, "run", failing)
    row = carry_out(task(small(), tmp_path))
    assert row["status"] == FAILED
    assert str(error) in row["reason"]


def test_layouts_differ_where_results_cannot_be_stacked(tmp_path: Path) -> None:
    rows = []
    slower, longer_run = replace(small(), initial=[Compacton(0.5, 10)]), replace(small(), t_end=0.3)
    for number, simulation in enumerate([small(), slower, small(80), longer_run]):
        (tmp_path / str(number)).mkdir()
        rows.append(carry_out(task(simulation, tmp_path / str(number), tracked=False)))
    first, alike, finer, longer = (row["layout"] for row in rows)
    assert first == alike
    assert len({first, finer, longer}) == 3
