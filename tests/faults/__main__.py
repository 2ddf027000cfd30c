"""The fault suite: what happens to runs that are killed, starved, damaged or disturbed.

Usage: python3 tests/faults PROGRAM [--all] [--only ROW] [--kind KIND] [--try LABEL] [--seed N]

After each fault the surface has the bytes of an undisturbed run, or the program says what is wrong, everything that was
finished is still there, and the run can be resumed to the same bytes. docs/faults.md describes the rows.
"""

import argparse
import os
import shlex
import signal
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Optional

import calls
import damage
import intruders
import kills
import limits
import rights
import sharing
import signals
import streams
import surroundings
from common import SAME, STATED, Failed, Missed, Row, Skipped, Suite, Try
from kinds import KINDS

ROWS = [
    row
    for module in (kills, calls, limits, streams, damage, intruders, sharing, rights, signals, surroundings)
    for row in module.ROWS
]


# A fault at a random moment is tried that often until it hits, each time earlier.
MOST_ATTEMPTS = 12


class Count:
    """The tries of one row with one kind of run."""

    def __init__(self) -> None:
        self.outcomes = {SAME: 0, STATED: 0}
        self.failed, self.seconds = 0, 0.0
        self.skipped: Optional[str] = None

    def is_empty(self) -> bool:
        """Whether every try missed."""
        return self.skipped is None and not sum(self.outcomes.values()) + self.failed

    def line(self, row: Row, kind: str) -> str:
        if self.skipped is not None:
            return f"| {row.fault} | {kind} | skipped: {self.skipped} | | | | |"
        tries = sum(self.outcomes.values()) + self.failed
        cells = (tries, self.outcomes[SAME], self.outcomes[STATED], self.failed, f"{self.seconds:.0f}")
        return f"| {row.fault} | {kind} | " + " | ".join(map(str, cells)) + " |"


def attempt(suite: Suite, row: Row, chosen: Try, count: Count, options: argparse.Namespace) -> None:
    """Makes one try, and says what is needed to repeat it if it fails."""
    begun = time.monotonic()
    for number in range(MOST_ATTEMPTS if row.is_timed else 1):
        place = suite.place(row.name, chosen, number)
        try:
            count.outcomes[chosen.act(place)] += 1
            break
        except Missed:
            pass
        except (Failed, OSError) as error:
            count.failed += 1
            report(suite, row, chosen, f"{error}", place.history, options)
            break
        finally:
            place.end()
    count.seconds += time.monotonic() - begun


def report(suite: Suite, row: Row, chosen: Try, why: str, history: list, options: argparse.Namespace) -> None:
    """Says what failed, what was done before, and how to do it again."""
    again = ["python3", "tests/faults", str(options.program), "--seed", str(suite.seed), "--only", row.name]
    again += ["--kind", chosen.kind, "--try", chosen.label] + ["--all"] * suite.is_full
    lines = [f"FAILED {row.name}, {chosen.kind}, {chosen.label}: {why}", f"  again: {shlex.join(again)}"]
    say("\n".join([*lines, *(f"  {line}" for line in "\n".join(history).splitlines())]))


def say(text: str) -> None:
    """Prints lines on standard error in one piece, as other rows print meanwhile."""
    sys.stderr.write(f"{text}\n")
    sys.stderr.flush()


def make(suite: Suite, row: Row, options: argparse.Namespace) -> dict:
    """Makes all tries of a row, by the kind of run."""
    counts: dict = {}
    try:
        for chosen in row.tries(suite):
            if options.kind not in (None, chosen.kind) or getattr(options, "try") not in (None, chosen.label):
                continue
            attempt(suite, row, chosen, counts.setdefault(chosen.kind, Count()), options)
            if getattr(options, "try") is not None:
                break
    except Skipped as reason:
        counts.setdefault("all", Count()).skipped = str(reason)
        say(f"skipped: {row.name}: {reason}")
    except Failed as reason:
        counts.setdefault("all", Count()).failed += 1
        say(f"FAILED {row.name}: {reason}")
    for kind, count in counts.items():
        if count.is_empty():
            count.failed += 1
            say(f"FAILED {row.name}, {kind}: no fault hit a run")
        say(count.line(row, kind))
    return counts


def obey_signals() -> None:
    """Undoes that signals are ignored, as by `nohup` or in the background of a script: programs inherit it."""
    # Python ignores these itself, but not in the programs that it starts.
    for number in signal.valid_signals() - {signal.SIGPIPE, signal.SIGXFSZ}:
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL)


def main() -> int:
    names = [row.name for row in ROWS]
    parser = argparse.ArgumentParser(prog="python3 tests/faults", description=__doc__.splitlines()[0])
    parser.add_argument("program", type=Path, help="the stickslip to test")
    parser.add_argument("--all", action="store_true", help="the full counts, which take hours")
    parser.add_argument("--only", action="append", choices=names, metavar="ROW", help=f"one of: {', '.join(names)}")
    parser.add_argument("--kind", choices=KINDS, help="only runs of this kind")
    parser.add_argument("--try", metavar="LABEL", help="only the try of this name, as a failure shows it")
    parser.add_argument("--seed", type=int, default=1, help="of everything that is chosen at random")
    parser.add_argument("--seconds", type=float, help="begin no row later than this")
    parser.add_argument("--limit", type=float, default=600, help="seconds after which a command counts as hanging")
    options = parser.parse_args()
    obey_signals()
    # After the tries that are under way.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    begun = time.monotonic()
    rows = [row for row in ROWS if not options.only or row.name in options.only]

    def made(row: Row) -> dict:
        if options.seconds is None or time.monotonic() - begun <= options.seconds:
            return make(suite, row, options)
        left_out = Count()
        left_out.skipped = "no time"
        return {"all": left_out}

    with tempfile.TemporaryDirectory(prefix="stickslip-faults-") as scratch:
        suite = Suite(options.program, Path(scratch), options.seed, options.all, options.limit, options.kind)
        # Most tries keep one processor busy, and some wait.
        with ThreadPoolExecutor(len(os.sched_getaffinity(0)) + 1) as workers:
            try:
                counts = list(workers.map(made, rows))
            except BaseException:
                suite.is_ending = True
                raise
    lines = [count.line(row, kind) for row, of in zip(rows, counts) for kind, count in of.items()]
    failed = sum(count.failed for of in counts for count in of.values())
    print("| fault | kind of run | tries | same bytes | stated error | failed | seconds |")
    print("|---|---|---|---|---|---|---|")
    print("\n".join(lines))
    used = os.times()
    seconds = f"{time.monotonic() - begun:.0f} s, {used.children_user + used.children_system:.0f} s of processors"
    print(f"seed {options.seed}, {seconds}, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
