from __future__ import annotations

import os
import subprocess
import sys

import pytest

LOADING = """
import os, signal, sys

class Interrupting:
    def find_spec(self, name, path, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupting())
signal.signal(signal.SIGINT, {before})
sys.argv = ["mol-compactons", "scenarios"]
from mol_compactons.cli import program
sys.exit(program())
"""
"""A command that Ctrl-C meets just as it loads a module."""


def loading(module: str, before: str) -> subprocess.CompletedProcess[str]:
    code = LOADING.format(module=module, before=before)
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("module", ["numpy", "scipy", "numba", "mol_compactons.simulation", "mol_compactons.cli.studies"])
def test_an_interrupt_while_the_program_loads_is_one_sentence(module: str) -> None:
    done = loading(module, "signal.default_int_handler")
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "mol-compactons: interrupted; nothing was written.\n"


def test_an_interrupt_that_was_ignored_before_stays_ignored() -> None:
    done = loading("numpy", "signal.SIG_IGN")
    assert (done.returncode, done.stderr) == (0, "")
    assert "two_bright" in done.stdout


def test_a_closed_pipe_is_no_error() -> None:
    command = f"{sys.executable} -m mol_compactons scenarios | head -c 1"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, env=os.environ, check=False)
    assert done.stderr == ""


def test_a_pipe_that_is_closed_before_the_first_word_is_none_either() -> None:
    """What was asked for went nowhere, which the status says as those of other programs do."""
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "mol_compactons", "scenarios"]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writer)
    assert (done.returncode, done.stderr) == (141, "")
