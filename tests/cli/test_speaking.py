from __future__ import annotations

import io
import logging
import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons.cli import speaking
from mol_compactons.cli.parser import main
from mol_compactons.cli.speaking import LONGEST_SENTENCE, ListenerLostError, complain, printable, remark, tell
from mol_compactons.errors import InputError
from tests.cli.conftest import QUICK

COMMAND = [sys.executable, "-m", "mol_compactons"]


class Broken(io.StringIO):
    """A stream that takes nothing."""

    def __init__(self, error: Exception) -> None:
        super().__init__()
        self._error = error

    def write(self, text: str) -> int:
        raise self._error


def test_what_was_asked_for_must_arrive_and_a_remark_need_not(monkeypatch: pytest.MonkeyPatch) -> None:
    for stream, expected in (
        (Broken(BrokenPipeError()), ListenerLostError),
        (Broken(OSError(28, "full")), InputError),
        (None, InputError),
    ):
        monkeypatch.setattr(sys, "stdout", stream)
        monkeypatch.setattr(sys, "stderr", stream)
        with pytest.raises(expected):
            tell("a")
        remark("a")
        complain("a")


@given(st.text(), st.sampled_from(["utf-8", "ascii", "latin-1"]))
def test_a_text_says_nothing_to_the_terminal(text: str, encoding: str) -> None:
    shown = printable(text, encoding)
    assert all(c == "\n" or c.isprintable() or c == " " for c in shown)
    shown.encode(encoding)
    assert printable("plain, text 1.5", encoding) == "plain, text 1.5"


def test_a_complaint_is_one_line_of_a_bounded_length(capsys: pytest.CaptureFixture[str]) -> None:
    complain("the beginning " + "very " * 1000 + "\nlong \x1b[31m\ncure.")
    printed = capsys.readouterr().err
    assert len(printed.splitlines()) == 1
    assert len(printed) <= LONGEST_SENTENCE + len("mol-compactons: \n") + 10
    assert printed.startswith("mol-compactons: the beginning")
    assert printed.endswith("cure.\n")
    assert "\x1b" not in printed
    assert speaking.LONGEST_SENTENCE == 400


@pytest.mark.parametrize(
    ("streams", "status"),
    [
        ("> /dev/full 2> /dev/full", 0),
        pytest.param(">&- 2>&-", 0, marks=pytest.mark.slow),
        ("0<&- >&- 2>&-", 0),
        pytest.param("2>&1 > /dev/null | head -c 10", 0, marks=pytest.mark.slow),
        ("| head -c 1", 0),
    ],
)
def test_a_run_needs_no_listener(streams: str, status: int) -> None:
    command = " ".join([*COMMAND, "run", "single_compacton", "-o", "a.nc", *QUICK])
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", f"{command} {streams}"], capture_output=True, text=True, check=False
    )
    assert done.returncode == status, done
    assert "Traceback" not in done.stderr
    said = subprocess.run([*COMMAND, "info", "a.nc"], capture_output=True, text=True, check=True).stdout
    assert "to t = 0.5, complete" in said


@pytest.mark.parametrize(
    ("streams", "status", "words"),
    [
        (
            "> /dev/full",
            2,
            "mol-compactons: Standard output cannot be written (No space left on device); send it to another place.\n",
        ),
        (">&-", 2, "mol-compactons: Standard output is closed, so that nothing can be printed; leave it open.\n"),
        ("> /dev/full 2> /dev/full", 2, ""),
    ],
)
def test_what_is_asked_for_and_lost_is_a_failure(streams: str, status: int, words: str) -> None:
    done = subprocess.run(
        ["bash", "-c", f"{' '.join(COMMAND)} scenarios {streams}"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (status, words)


def test_other_locales_and_names(tmp_path: Path) -> None:
    environment = os.environ | {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": "ascii"}
    command = [*COMMAND, "run", "single_compacton", "-o", "a.nc", *QUICK, "--set", "title=\x1b[31mrot é"]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    shown = subprocess.run([*COMMAND, "info", "a.nc"], capture_output=True, env=environment, check=True).stdout
    assert b"\x1b" not in shown
    assert b"\\x1b[31mrot \\xe9" in shown
    done = subprocess.run([*COMMAND, "run", "single_compacton", "-o", b"\xff.nc"], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "cannot be the name of a file" in done.stderr


def test_verbose_tells_on_standard_error_and_leaves_the_logger_as_it_was(capsys: pytest.CaptureFixture[str]) -> None:
    package = logging.getLogger("mol_compactons")
    before = package.level, list(package.handlers)
    assert main(["-v", "run", "single_compacton", *QUICK]) == 0
    told = capsys.readouterr().err.splitlines()
    assert [line.split(maxsplit=3)[2] for line in told] == ["INFO", "INFO"]
    assert "single_compacton.nc: complete" in told[1]
    assert main(["-vv", "run", "single_compacton", "--overwrite", *QUICK]) == 0
    assert "DEBUG single_compacton.nc: checkpoint at t = 0.5" in capsys.readouterr().err.replace(f"{Path.cwd()}/", "")
    assert (package.level, package.handlers) == before
