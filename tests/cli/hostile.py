"""Command lines that are built of real commands and fields and of hostile values, for hypothesis."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator
from typing import Any

from hypothesis import strategies as st

from mol_compactons.cli.scenarios import listing, load

SCENARIOS = sorted(set(listing()) - {"bright_dark_study", "collision_study"})

QUICK = {"t_end": "0.01", "frames": "3", "grid.size": "60"}
"""What makes any scenario a short run."""

NUMBERS = [
    *(
        "0",
        "-1",
        "1",
        "2",
        "3",
        "1.5",
        "0.5",
        "7",
        "9",
        "12",
        "60",
        "1e-3",
        "1e-30",
        "1e-200",
        "1e-320",
        "1e9",
        "1e15",
        "1e30",
    ),
    *("1e99", "1e200", "1e308", "-1e308", "1e400", "nan", "inf", "-inf", "2**3", "1/3", "1/0", "1e200*1e200", "9" * 400),
    *("9" * 4000, "9" * 5000, "0x10", "1_000", "1j", "True", "None", "-0.0", "1e200/1e-200", "-" * 7 + "1"),
]

NESTED = [
    *("-" * 1000 + "1", "+".join("1" * 3000), "*".join(["9" * 3000] * 3), "[" * 150 + "]" * 150, "(" * 90 + "1" + ")" * 90),
    *(
        "f(" * 80 + ")" * 80,
        "[" * 40 + "1" + "]" * 40,
        "9" * 3000 + "*" + "9" * 3000,
        "-" * 4000,
        "a" * 4000,
        "a." * 1500 + "b",
    ),
]

CLASSES = [
    *(
        "Midpoint(step=1e-3)",
        "Midpoint(step=1e300)",
        "IDA(rtol=1e-30)",
        "IDA(rtol=1)",
        "CVODE",
        "Rosenbrock(rtol=1e-6)",
        "IDA(",
    ),
    *("CompactScheme(viscosity=1e300)", "ConservativeScheme(order=6)", "FourierScheme", "FourierScheme(viscosity=1e9)"),
    *("GranularCompacton(n=1.0001)", "GranularCompacton(n=1e6)", "RosenauHyman(2, 2)", "Nesterenko(n=1.5)", "Grid(1e9, 60)"),
    *("[Compacton(1, 1e300)]", "[Uniform(1e100)]", "[Ripple(1, 30)]", "[Uniform(1), Ripple(0.1, 3)]", "[Compacton(1, 5)]"),
    *("[Formula('sin(20*pi*x)')]", "[Formula('1/x')]", "[Samples([1, 2, 3])]", "[Samples(file='none.nc')]", "Lattice(12)"),
    *(
        "[Formula('" + "(" * 200 + "x" + ")" * 200 + "')]",
        "[Formula('" + "-" * 1000 + "x')]",
        "[Formula('x**1e9')]",
        "mine:Own(1)",
    ),
    *(
        "[PeriodicWave(1, 1.2)]",
        "[SolitaryWave(1, 20)]",
        "[Impact(1)]",
        "Compacton",
        "[1, 2]",
        "{'a': 1}",
        "{}",
        "[]",
        "''",
        "...",
    ),
    *(
        r"$\frac$",
        "\x1b[31mred",
        "\ud800",
        "é" * 500,
        "1(2)",
        "'\\d'",
        "b'x'",
        "lambda: 1",
        "[*a]",
        "f(**a)",
        "{**a}",
        "1 if 2 else 3",
    ),
]

TOO_LONG = {"frames", "grid.size"}
"""Fields of which a large value is allowed, and takes its time."""

values = st.one_of(st.sampled_from(NUMBERS), st.sampled_from(CLASSES), st.sampled_from(NESTED), st.text(max_size=30))


def fields_of(settings: Any, prefix: str = "") -> Iterator[str]:
    """The dotted paths in the JSON of a simulation."""
    items = enumerate(settings) if isinstance(settings, list) else settings.items() if isinstance(settings, dict) else ()
    for name, inner in items:
        if name != "type":
            yield f"{prefix}{name}"
            yield from fields_of(inner, f"{prefix}{name}.")


FIELDS = {name: sorted(fields_of(json.loads(load(name).to_json()))) for name in SCENARIOS}


def is_quick(field: str, value: str) -> bool:
    """Whether a value cannot ask for what is allowed and large."""
    if field not in TOO_LONG:
        return True
    with contextlib.suppress(ValueError, OverflowError):
        return float(value) < 200 or float(value) > 1e9
    return True


@st.composite
def command_lines(draw: st.DrawFn) -> list[str]:
    """``run SCENARIO --set ...`` with one to three hostile values."""
    scenario = draw(st.sampled_from(SCENARIOS))
    known = st.sampled_from(FIELDS[scenario])
    names = known if draw(st.integers(0, 9)) else st.text(max_size=8)
    hostile = draw(st.dictionaries(names, values, min_size=1, max_size=3))
    changes = QUICK | {field: value for field, value in hostile.items() if is_quick(field, value)}
    # A part that is replaced comes first, so that what makes the run short stays in force.
    ordered = sorted(changes.items(), key=lambda change: change[0] in QUICK)
    options = [word for field, value in ordered for word in ("--set", f"{field}={value}")]
    return ["run", scenario, *options, "-o", "new.nc", "--overwrite", "--quiet", "--stop", "WallClock(seconds=1)"]


@st.composite
def other_lines(draw: st.DrawFn) -> list[str]:
    """Words in any order behind a real command, and options with hostile values."""
    command = draw(
        st.sampled_from(["run", "info", "plot", "track", "doctor", "stability", "orbit", "converge", "scenarios", ""])
    )
    word = st.one_of(
        st.sampled_from(["none.nc", "two_bright.py", ".", "/", "", "-", "--set", "--help", "x" * 4000, *NUMBERS]), values
    )
    options = st.sampled_from(
        ["--set", "-o", "--stop", "--import", "--steps", "--speed", "--least-height", "--sizes", "--order"]
    )
    words = draw(st.lists(st.one_of(word, options), max_size=4))
    return [command, *(one for one in words if one not in SCENARIOS)]
