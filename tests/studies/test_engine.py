from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from mol_compactons import InputError
from mol_compactons.studies.engine import ANSWER_SECONDS, MOST_ATTEMPTS, Cluster, Engine, Here, Lost, Processes, usable_cores
from tests.studies.sweeps import FATAL, doubled, forever, noted

CLUSTER = """
import sys, warnings
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""
"""A scheduler with two worker processes at a loopback address, until its standard input ends."""


@pytest.fixture(scope="session")
def address() -> Iterator[str]:
    command = [sys.executable, "-c", CLUSTER]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as cluster:
        assert cluster.stdout is not None
        yield cluster.stdout.readline().strip()
        assert cluster.stdin is not None
        cluster.stdin.close()
        cluster.wait(timeout=60)


@pytest.fixture(params=["here", "processes", "cluster"])
def engine(request: pytest.FixtureRequest) -> Engine:
    if request.param == "cluster":
        return Cluster(request.getfixturevalue("address"))
    return Here() if request.param == "here" else Processes(2)


def test_each_task_is_done_once(engine: Engine, tmp_path: Path) -> None:
    made = dict(engine.results(doubled, [(str(tmp_path), number) for number in range(20)]))
    assert made == {number: 2 * number for number in range(20)}
    assert sorted(map(int, noted(tmp_path))) == list(range(20))


EITHER = ["processes", pytest.param("cluster", marks=pytest.mark.slow)]
"""Where processes are killed: a small Dask cluster now and then loses its last worker so, and waits for another."""


@pytest.mark.parametrize("engine", EITHER, indirect=True)
def test_a_task_whose_process_is_killed_runs_again_and_no_other_does(engine: Engine, tmp_path: Path) -> None:
    for number in (3, 11):
        (tmp_path / f"{FATAL}-{number}").touch()
    made = dict(engine.results(doubled, [(str(tmp_path), number) for number in range(16)]))
    assert made == {number: 2 * number for number in range(16)}
    times = Counter(map(int, noted(tmp_path)))
    assert min(times[3], times[11]) >= 2
    if isinstance(engine, Processes):  # a scheduler runs again whatever the worker had, too
        assert times[3] == times[11] == 2
        assert sum(times.values()) == 18


@pytest.mark.parametrize("engine", EITHER, indirect=True)
def test_one_that_is_killed_each_time_is_lost_and_the_others_are_not(engine: Engine, tmp_path: Path) -> None:
    (tmp_path / f"{FATAL}-2-always").touch()
    made = dict(engine.results(doubled, [(str(tmp_path), number) for number in range(6)]))
    lost = made.pop(2)
    assert isinstance(lost, Lost)
    assert "killed" in lost
    assert made == {number: 2 * number for number in (0, 1, 3, 4, 5)}
    assert Counter(noted(tmp_path))["2"] == MOST_ATTEMPTS


@pytest.mark.slow
def test_a_scheduler_that_goes_is_one_sentence(tmp_path: Path) -> None:
    command = [sys.executable, "-c", CLUSTER]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as cluster:
        assert cluster.stdout is not None
        engine = Cluster(cluster.stdout.readline().strip())
        with pytest.raises(InputError, match="is gone; start it again"):
            dict(engine.results(forever, [str(tmp_path)], watch=cluster.kill))


def is_there(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def wait_for(condition: object, patience: float = 60) -> None:
    assert callable(condition)
    end = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def processes_in(folder: Path) -> list[int]:
    path = folder / "notes.txt"
    return [int(line.split()[1]) for line in path.read_text(encoding="utf-8").splitlines()] if path.exists() else []


def test_what_ends_a_study_ends_its_processes(tmp_path: Path) -> None:
    def watch() -> None:
        if noted(tmp_path):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        list(Processes(1).results(forever, [str(tmp_path)] * 3, watch))
    wait_for(lambda: not any(map(is_there, processes_in(tmp_path))))


def test_processes_do_not_outlive_a_study_that_is_killed(tmp_path: Path) -> None:
    code = (
        "from mol_compactons.studies.engine import Processes\nfrom tests.studies.sweeps import forever\n"
        f"if __name__ == '__main__':\n    list(Processes(2).results(forever, [{str(tmp_path)!r}] * 2))"
    )
    with subprocess.Popen([sys.executable, "-c", code]) as study:
        wait_for(lambda: len(processes_in(tmp_path)) == 2)
        study.send_signal(signal.SIGKILL)
    wait_for(lambda: not any(map(is_there, processes_in(tmp_path))))


def test_there_are_as_many_processes_as_cores() -> None:
    assert Processes().count == usable_cores() >= 1
    assert Processes(3).count == 3
    assert list(Processes(2).results(doubled, [])) == []


def test_what_cannot_begin_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    assert ANSWER_SECONDS < 10
    monkeypatch.setattr("mol_compactons.studies.engine.ANSWER_SECONDS", 1)
    with pytest.raises(InputError, match="workers = 0 must lie between 1 and 1000"):
        Processes(0)
    with pytest.raises(InputError, match=r"'tcp://127\.0\.0\.1:1' does not answer"):
        list(Cluster("tcp://127.0.0.1:1").results(doubled, [("", 1)]))
    with pytest.raises(InputError, match="does not answer; start it"):
        list(Cluster("nowhere.json").results(doubled, [("", 1)]))
    with pytest.raises(InputError, match="does not answer; start it"):
        list(Cluster("no address").results(doubled, [("", 1)]))
