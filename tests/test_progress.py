"""How far a piece of work is: a bar in a terminal or a notebook, lines in a log, and silence where nobody looks."""

from __future__ import annotations

import fcntl
import io
import struct
import sys
import termios
import threading
import time
import types
from pathlib import Path

import numpy as np
import pytest

from mol_compactons import Family, InputError, Rosenbrock, converge, run, sweep
from mol_compactons.progress import MEMBERS, TIME, VARIABLE, Bar, Lines, Wording, beside_bars, in_words, showing_progress
from tests.screen import terminal
from tests.systems import one_compacton

SHORT = one_compacton(t_end=0.2, frames=3, integrator=Rosenbrock())


def test_a_bar_reaches_the_end_and_goes() -> None:
    with terminal() as screen:
        with showing_progress(4.0, TIME, wanted=True) as show:
            for t in np.linspace(0, 4, 5):
                show(float(t))
        shown = screen()
    assert "t = 0 / 4" in shown
    assert shown.endswith("\r")


def test_a_bar_is_as_wide_as_the_terminal_even_if_that_changes() -> None:
    widths = []
    with terminal() as screen, showing_progress(4.0, TIME, wanted=True) as show:
        for t, columns in enumerate((60, 100, 80)):
            fcntl.ioctl(sys.stderr.fileno(), termios.TIOCSWINSZ, struct.pack("4H", 24, columns, 0, 0))
            show(float(t))
            widths.append(len(screen().rpartition("\r")[2].rstrip()))
            time.sleep(0.12)
    assert np.diff(widths).tolist() == [40, -20]


def test_what_was_done_before_counts_for_no_rate() -> None:
    """A run that goes on from t = 3 has not been as fast as that."""
    with terminal() as screen, showing_progress(4.0, TIME, wanted=True) as show:
        show(3.0)
        assert "75%" in (told := screen())
        assert "?t/s" in told


@pytest.mark.parametrize(("wanted", "said", "expected"), [
    (None, None, False), (None, "1", True), (None, "no", False), (False, "1", False), (True, "0", True), (True, None, True),
])  # fmt: skip
def test_it_is_shown_where_the_call_or_the_environment_says_so(
    wanted: bool | None, said: str | None, expected: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    if said is not None:
        monkeypatch.setenv(VARIABLE, said)
    with terminal() as screen:
        run(SHORT, progress=wanted)
        assert ("t = 0 / 0.2" in screen()) == expected


def test_it_is_shown_in_an_interactive_interpreter(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setattr(sys, "ps1", ">>> ", raising=False)
    with terminal() as screen:
        run(SHORT)
        assert "t = 0 / 0.2" in screen()


def test_the_environment_may_not_say_anything(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(VARIABLE, "perhaps")
    with pytest.raises(InputError, match=f"{VARIABLE} = 'perhaps' must be one of 1, yes, true"):
        run(SHORT, tmp_path / "a.nc")
    assert list(tmp_path.iterdir()) == []


def test_studies_show_their_members_and_these_nothing_of_their_own(tmp_path: Path) -> None:
    with terminal() as screen:
        sweep(SHORT, {"initial.0.speed": [0.5, 1.0, -1.0]}, tmp_path / "sweep", progress=True)
        told = screen()
        assert "0 / 3 members" in told
        assert "t =" not in told
        converge(SHORT, Family(sizes=(75, 150)), progress=True)
        assert "0 / " in (told := screen())
        assert "t =" not in told


def test_work_inside_of_other_work_is_silent_and_another_thread_is_not() -> None:
    with terminal() as screen:
        with showing_progress(3, MEMBERS, wanted=True) as show:
            show(0)
            with showing_progress(1.0, Wording("inner", "inner"), wanted=True) as inner:
                inner(0.5)
            show(1)
        assert "inner" not in screen()

        def work() -> None:
            with showing_progress(1.0, Wording("elsewhere", "elsewhere"), wanted=True) as show:
                show(0.5)

        thread = threading.Thread(target=work)
        with showing_progress(3, MEMBERS, wanted=True) as show:
            show(0)
            thread.start()
            thread.join()
        assert "elsewhere" in screen()


def test_a_line_is_said_beside_the_bar() -> None:
    with terminal() as screen, showing_progress(3, MEMBERS, wanted=True) as show:
        show(1)
        screen()
        with beside_bars():
            print("a line", file=sys.stderr)
        told = screen()
    assert "\ra line" in told.replace("\x1b[A", "").replace(" ", "").replace("aline", "a line")


def test_a_log_gets_a_line_for_each_tenth_and_none_for_short_work() -> None:
    clock, stream = [0.0], io.StringIO()
    lines = Lines(0.0, TIME, stream, lambda: clock[0])
    for t in np.linspace(0, 40, 401):
        clock[0] = 2.5 * t  # 100 s in all
        lines.show(float(t), 40.0, "")
    told = stream.getvalue().splitlines()
    assert told[0] == "mol-compactons: t = 4 of 40, 10 %, about 90 s left"
    assert len(told) == 10
    short = io.StringIO()
    quick = Lines(0.0, TIME, short, lambda: 9.0)
    for t in range(41):
        quick.show(float(t), 40.0, "")
    assert short.getvalue() == ""


def test_a_long_silence_is_broken() -> None:
    clock, stream = [0.0], io.StringIO()
    lines = Lines(20.0, MEMBERS, stream, lambda: clock[0])
    for clock[0] in (100.0, 299.0, 301.0):
        lines.show(21.0, 1000.0, "1 failed")
    assert stream.getvalue() == "mol-compactons: 21 of 1000 members, 2 %, about 82 h left, 1 failed\n"


class Full(io.StringIO):
    """A terminal that takes nothing."""

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> int:
        raise OSError(28, "No space left on device")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # of a bar that tqdm 4.65 has half made
def test_a_stream_that_cannot_be_written_ends_no_run(monkeypatch: pytest.MonkeyPatch) -> None:
    closed = io.StringIO()
    closed.close()
    for stream in (Full(), closed, None):
        monkeypatch.setattr(sys, "stderr", stream)
        assert run(SHORT, progress=True).attrs["status"] == "complete"


def test_a_notebook_without_widgets_gets_a_bar_of_signs(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shell = type("ZMQInteractiveShell", (), {})
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=shell))
    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    with showing_progress(4.0, TIME, wanted=True) as show:
        show(2.0)
        assert "50%" in capsys.readouterr().err


def test_a_bar_takes_a_new_total() -> None:
    with terminal() as screen:
        bar = Bar(0, 10, MEMBERS)
        bar.show(5, 20, "2 failed")
        bar._bar.refresh()
        assert "5 / 20 members" in (told := screen())
        assert "2 failed" in told
        bar.close()


@pytest.mark.parametrize(("seconds", "words"), [(0, "0 s"), (119, "119 s"), (121, "2 min"), (7300, "2 h")])
def test_times_in_words(seconds: float, words: str) -> None:
    assert in_words(seconds) == words
