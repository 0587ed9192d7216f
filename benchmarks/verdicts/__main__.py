"""Where `converge` says "converged", does its error bar hold the truth? `python -m benchmarks.verdicts [--only TEXT]`.

Families of runs with known answers: exact waves of all equations and of chains, under settings that suit them and under such
as invite a bar that is too small. Printed are, for each family, how many quantities were judged, how many were called
converged with a bar that holds the truth, how many with one that does not, and how many are as near to the truth as was asked
for and were not recognised. Each false one is printed with its value, its bar and the truth, and so, with --all, is
every quantity. Families made for a trap that one cannot see in the table say what of it is there: which members failed, how
far from the truth an early look is. The exit status is 1 if there is a false one, or if a family could not be run or does not
show its trap. All families take
about five minutes of one core.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from benchmarks.verdicts import chains, continua, traps
from benchmarks.verdicts.known import Known, NoTrapError, Row, rows
from mol_compactons import InputError, IntegrationError

FAMILIES: tuple[Callable[[], Known], ...] = continua.FAMILIES + chains.FAMILIES + traps.FAMILIES

LINE = "{:24} {:>8} {:>10} {:>6} {:>15}"


@dataclass(frozen=True)
class Tally:
    """How the verdicts of some quantities stand beside the truth.

    Parameters
    ----------
    judged : int
        Quantities whose truth is known, in each limit.
    converged : int
        Those called converged with a bar that holds the truth.
    false : int
        Those called converged with a bar that does not.
    unrecognised : int
        Those as near to the truth as was asked for that were not called converged.
    """

    judged: int
    converged: int
    false: int
    unrecognised: int

    @classmethod
    def of(cls, found: Iterable[Row]) -> Tally:
        """The tally of rows."""
        found = list(found)
        return cls(
            len(found),
            sum(row.is_right for row in found),
            sum(row.is_false for row in found),
            sum(row.is_unrecognised for row in found),
        )

    def line(self, name: str) -> str:
        """A line of the table."""
        return LINE.format(name, self.judged, self.converged, self.false, self.unrecognised)


def described(row: Row) -> str:
    """One line about a quantity."""
    mark = "FALSE " if row.is_false else "not recognised " if row.is_unrecognised else ""
    return (
        f"    {mark}{row.limit} {row.quantity}: {row.value:.7g} +- {row.bar:.1e}, truth {row.truth:.7g}, "
        f"{row.ratio:.2g} bars away, {row.verdict}: {row.reason}"
    )


def report(families: Sequence[Callable[[], Known]], every: bool = False, show: Callable[[str], None] = print) -> int:
    """Run families, and show the table.

    Parameters
    ----------
    families : sequence of callable
        Each makes a `Known`; its name is that of the family.
    every : bool
        Whether each quantity gets a line, not only the false ones.
    show : callable
        Called with each line.

    Returns
    -------
    int
        1 if any verdict is false or a family could not be run, else 0.
    """
    show(LINE.format("family", "judged", "converged", "FALSE", "not recognised"))
    everything: list[Row] = []
    broken = 0
    for family in families:
        seen: list[str] = []
        try:
            found = rows(family.__name__, family(), seen.append)
        except (InputError, IntegrationError, NoTrapError) as error:
            broken += 1
            show(f"{family.__name__} could not be run: {error}")
            continue
        everything += found
        show(Tally.of(found).line(family.__name__))
        for line in seen:
            show(f"    {line}")
        for row in found:
            if every or row.is_false:
                show(described(row))
    total = Tally.of(everything)
    show(total.line(f"sum of {len(families) - broken} families"))
    return int(total.false > 0 or broken > 0)


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="families whose name contains this text")
    parser.add_argument("--all", action="store_true", help="a line for each quantity")
    options = parser.parse_args()
    chosen = [family for family in FAMILIES if options.only in family.__name__]
    if not chosen:
        parser.error(f"no family has {options.only!r} in its name; there are {', '.join(f.__name__ for f in FAMILIES)}")
    return report(chosen, options.all, lambda line: print(line, flush=True))


if __name__ == "__main__":
    sys.exit(main())
