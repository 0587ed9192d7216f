"""Whether the tests notice small faults: `python -m benchmarks.mutants [--count 200] [--seed 0] [--only PREFIX]`.

Puts random single faults into a copy of the package, one at a time, and runs the tests that reach the place: a sign, a factor,
an operator, a comparison, an index, a constant, a guard or a statement dropped, and so on. Each line of code that may have one
is as likely as any other. Prints each fault that no test notices, and the share of those that are noticed; the exit status is
1 if that is less than 95 %. A fault that makes no difference that can be seen is left out of the share if
`equivalents.toml` gives the reason.

With -o FILE.csv the outcomes are written down as they come, and those that stand there already are not tried again, but for
those that survived with --again. The same seed gives the same faults for the same sources. The first time, all tests run once
to record what each of them reaches, which takes a quarter of an hour; two hundred faults take about an hour. In a hurry the
slowest tests can be left aside with --without tests/outside and the like, and the survivors be tried --again with all.
"""

from __future__ import annotations

import argparse
import csv
import random
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

from benchmarks.mutants.faults import Fault, by_line
from benchmarks.mutants.reach import PACKAGE
from benchmarks.mutants.trial import Verdict, Workshop

ROOT = Path(__file__).parents[2]

WANTED = 0.95
"""The share that must be noticed."""

EQUIVALENTS = Path(__file__).with_name("equivalents.toml")

FIELDS = ("file", "line", "kind", "before", "after", "outcome", "test", "seconds")


@dataclass(frozen=True)
class Mutant:
    """A fault in its file, and how its lines read before and after."""

    file: str
    fault: Fault
    line: int
    before: str
    after: str

    @property
    def key(self) -> tuple[str, ...]:
        """What tells it from all others."""
        return self.file, str(self.line), self.fault.kind, self.before, self.after

    def difference(self) -> str:
        """The lines that differ, as a patch shows them."""
        return f"- {self.before}\n+ {self.after}"


def mutant(file: str, source: str, fault: Fault) -> Mutant:
    """A fault with the lines that it changes."""
    old, new = source.splitlines(), fault.put_into(source).splitlines()
    same = next((place for place, (left, right) in enumerate(zip(old, new, strict=False)) if left != right), 0)
    rest = next(place for place in range(len(old)) if old[-1 - place] != new[-1 - place])
    rest = min(rest, len(old) - same - 1, len(new) - same - 1)
    before, after = ("\n  ".join(line.strip() for line in lines[same : len(lines) - rest]) for lines in (old, new))
    return Mutant(file, fault, fault.line(source), before, after)


def choose(root: Path, only: Sequence[str], count: int, seed: int) -> list[Mutant]:
    """Random faults of different lines, in a random order."""
    sources = {
        path.relative_to(root).as_posix(): path.read_text(encoding="utf-8") for path in sorted(root.glob(f"{PACKAGE}/**/*.py"))
    }
    chosen = {file: by_line(source) for file, source in sources.items() if file.startswith(tuple(only))}
    places = [(file, line) for file, lines in chosen.items() for line in sorted(lines)]
    chance = random.Random(seed)
    picked = chance.sample(places, min(count, len(places)))
    return [mutant(file, sources[file], chance.choice(chosen[file][line])) for file, line in picked]


class Ledger:
    """The outcomes so far, in a file if one is named."""

    def __init__(self, path: Path | None, again: bool) -> None:
        self.path, self.rows = path, {}
        if path is not None and path.is_file():
            with path.open(newline="") as file:
                rows = list(csv.DictReader(file))
            self.rows = {key_of(row): row for row in rows if not again or row["outcome"] in ("noticed", "endless")}

    def enter(self, one: Mutant, verdict: Verdict, seconds: float) -> None:
        """Add an outcome, and write all of them."""
        values = (
            *(one.file, one.line, one.fault.kind, one.before, one.after),
            verdict.outcome,
            verdict.test,
            f"{seconds:.0f}",
        )
        row = dict(zip(FIELDS, map(str, values), strict=True))
        self.rows[key_of(row)] = row
        if self.path is not None:
            with self.path.open("w", newline="") as file:
                writer = csv.DictWriter(file, FIELDS)
                writer.writeheader()
                writer.writerows(self.rows.values())

    def verdict(self, one: Mutant) -> Verdict | None:
        """What became of a fault; None if it was not tried."""
        row = self.rows.get(one.key)
        return None if row is None else Verdict(row["outcome"], row["test"])


def key_of(row: dict[str, str]) -> tuple[str, ...]:
    """The key of the fault of a row."""
    return tuple(row[name] for name in FIELDS[:5])


def reasons() -> dict[tuple[str, str, str], str]:
    """Why some faults make no difference, by their file and how their lines read before and after."""
    entries = tomllib.loads(EQUIVALENTS.read_text(encoding="utf-8"))["equivalent"]
    return {(entry["file"], entry["before"], entry["after"]): entry["reason"] for entry in entries}


def try_all(mutants: Sequence[Mutant], ledger: Ledger, options: argparse.Namespace) -> None:
    """Try the faults that were not tried, as many at a time as asked for, until the time is over."""
    waiting = [one for one in mutants if ledger.verdict(one) is None]
    shops: SimpleQueue[Workshop] = SimpleQueue()
    for number in range(options.jobs):
        shop = Workshop(ROOT, options.folder / str(number), options.folder / "reach", options.without)
        shop.prepare()
        shops.put(shop)
    begin = time.monotonic()

    def work(one: Mutant) -> None:
        if time.monotonic() - begin > 60 * options.minutes:
            return
        shop = shops.get()
        start = time.monotonic()
        try:
            verdict = shop.try_out(one.file, one.fault, options.patience)
        finally:
            shops.put(shop)
        ledger.enter(one, verdict, time.monotonic() - start)
        if not verdict.noticed:
            print(f"{one.file}:{one.line}: {one.fault.kind}, {verdict.outcome}\n{one.difference()}\n", flush=True)

    with ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(work, waiting))


def summary(mutants: Sequence[Mutant], ledger: Ledger) -> tuple[list[str], float]:
    """Lines about each folder, and the share noticed of all that make a difference."""
    known = reasons()
    total, noticed, same = Counter[str](), Counter[str](), Counter[str]()
    for one in mutants:
        verdict = ledger.verdict(one)
        if verdict is None:
            continue
        for folder in ("all", one.file.removeprefix(f"{PACKAGE}/").rpartition("/")[0] or "."):
            equivalent = not verdict.noticed and (one.file, one.before, one.after) in known
            same[folder] += equivalent
            noticed[folder] += verdict.noticed
            total[folder] += not equivalent
    lines = ["| folder | faults | noticed | no difference |", "|---|---|---|---|"]
    lines += [f"| {name} | {total[name] + same[name]} | {noticed[name]} | {same[name]} |" for name in sorted(total)]
    share = noticed["all"] / total["all"] if total["all"] else 1.0
    return [*lines, "", f"noticed: {100 * share:.1f} % of {total['all']}"], share


def survivors(mutants: Sequence[Mutant], ledger: Ledger) -> Iterator[str]:
    """Each fault that was not noticed, with the reason if there is one."""
    known = reasons()
    for one in mutants:
        verdict = ledger.verdict(one)
        if verdict is not None and not verdict.noticed:
            reason = known.get((one.file, one.before, one.after), verdict.outcome)
            yield f"{one.file}:{one.line}: {one.fault.kind}\n{one.difference()}\n  {reason}\n"


def parser() -> argparse.ArgumentParser:
    """The options."""
    made = argparse.ArgumentParser(prog="python -m benchmarks.mutants", description="Whether the tests notice small faults.")
    made.add_argument("--count", type=int, default=200, help="how many faults; default %(default)s")
    made.add_argument("--seed", type=int, default=0, help="which ones; default %(default)s")
    made.add_argument("--jobs", type=int, default=1, help="how many at a time; default %(default)s")
    made.add_argument(
        "--only", action="append", default=[], metavar="PREFIX", help="files whose path begins so; may be repeated"
    )
    made.add_argument(
        "--without", action="append", default=[], metavar="PREFIX", help="leave the tests aside whose path begins so"
    )
    made.add_argument("--minutes", type=float, default=float("inf"), help="begin no other fault after this time")
    made.add_argument("--patience", type=float, default=60, help="seconds of tests for each fault; default %(default)s")
    made.add_argument("--again", action="store_true", help="try those that survived in FILE.csv once more")
    made.add_argument("-o", dest="file", type=Path, metavar="FILE.csv", help="keep the outcomes, and go on from them")
    made.add_argument(
        "--folder", type=Path, default=Path(tempfile.gettempdir(), "mol_compactons_mutants"), help="for the copies"
    )
    return made


def main() -> int:
    """Try the faults, print those that survive, and return 1 if too many do."""
    options = parser().parse_args()
    mutants = choose(ROOT, options.only or [PACKAGE], options.count, options.seed)
    ledger = Ledger(options.file, options.again)
    try_all(mutants, ledger, options)
    print("Not noticed:\n")
    print("\n".join(survivors(mutants, ledger)))
    lines, share = summary(mutants, ledger)
    print("\n".join(lines))
    return int(share < WANTED)


if __name__ == "__main__":
    sys.exit(main())
