"""What a solver says is heard; the streams and the environment of the process are as they were, for every thread."""

import ctypes
import os
import re
import sys
import tempfile
import threading
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mol_compactons.runtime import capture
from mol_compactons.runtime.capture import LOG_VARIABLES, Messages, import_sundae


def in_c(name: str) -> bytes | None:
    """The variable of the environment that C sees."""
    getenv = ctypes.CDLL(None).getenv
    getenv.restype = ctypes.c_char_p
    found: bytes | None = getenv(name.encode())
    return found


def run_into_a_wall(messages: Messages) -> list[str]:
    """How the lines begin that CVODE and IDA say at a jump: the one warns, the other gives up."""
    sundae = import_sundae()
    rng = np.random.default_rng(0)

    def rate(t: float, y: Any, out: Any) -> None:
        out[:] = -y if t < 0.5 else 1e100 * rng.random(y.size)

    def residual(t: float, y: Any, yp: Any, out: Any) -> None:
        rate(t, y, out)
        out[:] = yp - out

    start = np.ones(1)
    with messages.heard():
        for make, how, initial in ((sundae.cvode.CVODE, rate, (start,)), (sundae.ida.IDA, residual, (start, -start))):
            solver = make(how, rtol=1e-2, atol=1e-4)
            with messages.logged():
                solver.init_step(0.0, *initial)
            for _ in range(400):
                if solver.step(2.0, method="onestep").status < 0:
                    break
            del solver
            messages.lines()
    return [line.partition("]")[0].partition(",")[0] for line in messages.lines()]


def test_the_log_and_what_is_printed_are_heard_and_reach_no_stream(capfd: pytest.CaptureFixture[str]) -> None:
    messages, before = Messages(), dict(os.environ)
    assert run_into_a_wall(messages) == ["[WARNING"] * 11 + ["[IDAHandleFailure"]
    ctypes.CDLL(None).fflush(None)
    lines = messages.lines()
    assert sum("t + h = t" in line for line in lines) == 10
    assert all(line == line.strip() != "" for line in lines)
    assert messages.lines() == lines
    assert capfd.readouterr() == ("", "")
    assert dict(os.environ) == before
    assert [in_c(name) for name in LOG_VARIABLES] == [None, None]


def test_nothing_else_imports_what_must_find_our_print() -> None:
    package = Path(capture.__file__).parent.parent
    found = [path for path in package.rglob("*.py") if re.search(r"(from|import) sksundae", path.read_text(encoding="utf-8"))]
    assert found == [Path(capture.__file__)]


def test_only_the_thread_that_listens_is_heard(capsys: pytest.CaptureFixture[str]) -> None:
    messages, inner = Messages(), Messages()
    with messages.heard():
        other = threading.Thread(target=capture._say, args=("from elsewhere",))
        other.start()
        other.join()
        print("from this program")
        capture._say("\n[IDASolve] twice,\n  in two lines\n")
        with inner.heard():
            capture._say("within")
    capture._say("after")
    assert messages.lines() == ["[IDASolve] twice,", "in two lines"]
    assert inner.lines() == ["within"]
    assert capsys.readouterr().out == "from elsewhere\nfrom this program\nafter\n"


@pytest.mark.parametrize("stream", [None, "closed"])
def test_no_stream_is_needed(stream: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    broken: Any = None
    if stream:
        broken = open(os.devnull, "w")  # noqa: PTH123, SIM115  # it is to be closed
        broken.close()
    messages = Messages()
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", broken)
        patch.setattr(sys, "stderr", broken)
        heard = run_into_a_wall(messages)
    assert heard == ["[WARNING"] * 11 + ["[IDAHandleFailure"]


def test_a_needless_warning_is_dropped_where_somebody_listens_and_filters_stay_as_they_are() -> None:
    before = warnings.filters[:]
    with Messages().heard():
        capture._warn(f"{capture.NEEDLESS_WARNING} will be ignored.")
        with pytest.warns(UserWarning, match="something else"):
            capture._warn("something else")
    with pytest.warns(UserWarning, match="Jacobian"):
        capture._warn(f"{capture.NEEDLESS_WARNING} will be ignored.")
    assert warnings.filters == before


def refuse(*arguments: Any, **options: Any) -> Any:
    raise FileNotFoundError(2, "No usable temporary directory found")


@pytest.mark.parametrize("temporary", [tempfile.TemporaryFile, refuse])
def test_no_memory_file_and_no_temporary_folder_are_needed(
    temporary: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Without either the log is lost; what is printed is heard."""
    monkeypatch.setattr(os, "memfd_create", refuse, raising=False)
    monkeypatch.setattr(tempfile, "TemporaryFile", temporary)
    heard = run_into_a_wall(Messages())
    ctypes.CDLL(None).fflush(None)
    assert heard == (["[WARNING"] * 11 if temporary is not refuse else []) + ["[IDAHandleFailure"]
    assert capfd.readouterr() == ("", "")


def test_variables_that_were_set_are_set_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(LOG_VARIABLES[0], "mine")
    with Messages().logged():
        places = [in_c(name) for name in LOG_VARIABLES]
        assert os.environ[LOG_VARIABLES[0]] == "mine"
    assert places[0] == places[1] != b"mine"
    assert [in_c(name) for name in LOG_VARIABLES] == [b"mine", None]


def test_a_process_forked_meanwhile_has_neither_the_variables_nor_a_lock_that_never_opens() -> None:
    entered, enough = threading.Event(), threading.Event()

    def hold() -> None:
        with Messages().logged():
            entered.set()
            enough.wait(0.3)

    holder = threading.Thread(target=hold)
    holder.start()
    entered.wait()
    child = os.fork()
    if child == 0:
        status = int(any(in_c(name) for name in LOG_VARIABLES))
        with Messages().logged():
            os._exit(status)
    _, status = os.waitpid(child, 0)
    enough.set()
    holder.join()
    assert status == 0
