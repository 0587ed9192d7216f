"""The cells of a shell in the pages: `%%bash -e` as in IPython, whose own one cuts what a command prints into pieces."""

from __future__ import annotations

import subprocess
from typing import Any


def bash(line: str, cell: str) -> None:
    """Run a cell in bash, print what it printed without its progress, and raise an error where it fails with -e."""
    done = subprocess.run(["bash", *line.split(), "-c", cell], capture_output=True, text=True, check=False)
    print(done.stdout, end="")
    if "-e" in line.split() and done.returncode:
        raise RuntimeError(f"exit status {done.returncode}: {done.stderr}")


def load_ipython_extension(shell: Any) -> None:
    """What `%load_ext notebook_shell` calls."""
    shell.register_magic_function(bash, "cell", "bash")
