"""Examples of each command, which its help shows."""

from __future__ import annotations

import argparse
import shlex

EXAMPLES: dict[str, tuple[tuple[str, str], ...]] = {
    "run": (
        ("run two_bright -o two_bright.nc", "a scenario of the package"),
        ("run mine.py --set grid.size=1200 --set t_end=20", "your own script, with two fields changed"),
        ("run two_bright.nc -o again.nc", "a result repeats itself, bit for bit"),
        ("run two_bright -o two_bright.nc --resume --set t_end=80", "a result goes on"),
        ("run two_bright -o short.nc --stop CollisionOver --stop WallClock(seconds=3600)", "rules end it early"),
    ),
    "info": (
        ("info two_bright.nc", "what is in a result, and how well it kept what is conserved"),
        ("info viscosity_sweep", "a sweep, also while it runs"),
        ("info two_bright.nc --json", "for another program"),
    ),
    "plot": (
        ("plot two_bright.nc -o two_bright.png", "the waterfall and the drift"),
        ("plot two_bright.nc --kind snapshots --times 0,10,20 --window 5:40 --style journal -o fig.pdf", "for a paper"),
        ("plot two_bright.nc --kind map -o map.png", "the space-time map"),
        ("plot lattice_collision.nc lattice_collision_continuum.nc -o both.png", "a chain as marks on its continuum"),
    ),
    "animate": (
        ("animate two_bright.nc -o two_bright.webp", "a film"),
        ("animate coarse.nc fine.nc --together -o both.mp4", "two runs on one axis"),
        ("animate two_bright.nc --speed 1 -o riding.gif", "seen from the wave of speed 1"),
    ),
    "report": (
        ("report two_bright.nc", "a page for the browser, that needs no network"),
        ("report viscosity_sweep -o viscosity.html", "a sweep"),
        ("report lattice_collision.nc lattice_collision_continuum.nc", "a chain and its continuum"),
    ),
    "track": (
        ("track two_bright.nc", "speeds, heights and phase shifts"),
        ("track two_bright.nc --json", "for another program"),
    ),
    "doctor": (("doctor two_bright.nc", "what contradicts what is known"),),
    "converge": (
        ("converge two_bright --sizes 300,600,1200 -o study.nc --workers 2", "how much of it is real"),
        ("converge no_viscosity --schemes ConservativeScheme(order=4),ConservativeScheme(order=6)", "schemes side by side"),
    ),
    "sweep": (
        ("sweep two_bright --vary grid.size=300,600 --vary scheme.viscosity=geomspace(1e-4,1e-2,5) -o viscosity", "all pairs"),
        ("sweep two_bright --draw initial.0.speed=0.5,2 --count 50 --seed 1", "at random"),
        ("sweep two_bright --refine scheme.viscosity=1e-5,1e-2 --outcome momentum_drift>0.1", "where it changes"),
    ),
    "stability": (("stability n=3", "of the compacton of an equation"), ("stability n=3/2 -o stability.png", "as a picture")),
    "orbit": (("orbit no_viscosity -o orbit.nc", "the Floquet multipliers of its wave"),),
    "scenarios": (("scenarios", "all of them"), ("scenarios two_bright", "the script of one")),
    "new": (("new mine.py", "a script to start from"),),
}
"""For each command what is typed after the name of the program, and what it is for."""


def words_of(example: str) -> list[str]:
    """The words of an example; none has a space inside."""
    return example.split()


def examples_of(command: str) -> str:
    """The end of the help of a command, as it would be typed in a shell."""
    lines = ["examples:"]
    for typed, meaning in EXAMPLES[command]:
        lines += [f"  mol-compactons {shlex.join(words_of(typed))}", f"      {meaning}"]
    return "\n".join(lines)


class ExamplesFormatter(argparse.HelpFormatter):
    """Wraps what a command says of itself, and leaves its examples as they are."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return text if text.startswith("examples:") else super()._fill_text(text, width, indent)
