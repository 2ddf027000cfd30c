"""Two runners in one directory, and a directory that is moved or removed under a run."""

import re
import shutil
import signal
import subprocess
import time
from typing import Iterator

from common import (
    BUSY,
    DONE,
    INPUT_OUTPUT,
    SAME,
    STATED,
    Missed,
    Place,
    Row,
    Skipped,
    Suite,
    Try,
    check,
    need,
    need_root,
)
from kinds import RUNS

# What the second runner does, beside a first one that submits or resumes.
SECONDS = ["submit job.toml --out run", "resume run", "merge run --wait 0", "verify run"]


def two_runners(suite: Suite) -> Iterator[Try]:
    def act(place: Place) -> str:
        first = place.begin(threads=1)
        is_race = words.startswith("submit") and place.random.random() < 0.5
        if not is_race:
            place.wait_for_work(first)
            # It keeps the lock while the second one tries.
            first.send(signal.SIGSTOP)
        second = place.start(*words.split())
        if not is_race:
            tried = second.ended({DONE, BUSY})
            first.send(signal.SIGCONT)
        runs = {first: first.ended({DONE, BUSY}), second: second.ended({DONE, BUSY}) if is_race else tried}
        busy = [run for run, ended in runs.items() if ended.code == BUSY]
        if not busy:
            raise Missed("the first had ended before the second began")
        check(len(busy) == 1, "both were refused")
        worker = next(run for run in runs if run not in busy)
        said = runs[busy[0]].stderr
        check(f"in use by process {worker.process.pid} on " in said, f"the holder is not named: {said!r}")
        place.same_bytes()
        place.finish()
        return STATED

    for kind in suite.kinds("two-runners", RUNS):
        for number in range(suite.many(6, 50)):
            words = SECONDS[number % len(SECONDS)]
            yield Try(kind, f"{number} {words.split()[0]}", act)


def stale_locks(suite: Suite) -> Iterator[Try]:
    def act(place: Place) -> str:
        first = place.begin(threads=1)
        place.wait_for_work(first)
        place.wait(first, 0.5)
        first.send(signal.SIGKILL)
        if first.ended({DONE, -signal.SIGKILL}).code == DONE:
            raise Missed("it had ended before")
        return place.finish(SAME)

    for kind in suite.kinds("stale-lock", RUNS):
        for number in range(suite.many(4, 50)):
            yield Try(kind, f"{number}", act)


def moved_or_removed(suite: Suite) -> Iterator[Try]:
    for kind in suite.kinds("moved", RUNS):
        for number in range(suite.many(6, 50)):
            what = ("moved", "removed", "replaced")[number % 3]
            yield Try(kind, f"{number} {what}", lambda place: disturbed(place, what))


def disturbed(place: Place, what: str) -> str:
    """Moves, removes or replaces the directory of a run at work."""
    running = place.begin()
    place.wait_for_work(running)
    place.wait(running)
    moved = place.path / "moved"
    if what == "removed":
        # A file may be written meanwhile.
        while place.run.exists():
            shutil.rmtree(place.run, ignore_errors=True)
    else:
        place.run.rename(moved)
    if what == "replaced":
        place.write_job("other.toml", "eigenvalue", 9)
        place.stickslip("submit", "other.toml", "--out", "run")
        replaced = sorted((path, path.stat().st_mtime_ns) for path in place.run.rglob("*"))
    ended = running.ended({DONE, INPUT_OUTPUT})
    if ended.code == INPUT_OUTPUT:
        check(
            re.search("run was moved, removed or replaced|cannot write run|cannot read run", ended.stderr),
            f"it does not say what happened: {ended.stderr!r}",
        )
    if what == "replaced":
        now = sorted((path, path.stat().st_mtime_ns) for path in place.run.rglob("*"))
        check(now == replaced, "something was written in the run that took the place")
        shutil.rmtree(place.run)
    check(not place.run.exists(), "something was written under the old path")
    if what == "removed":
        if ended.code == DONE:
            raise Missed("it had ended before")
        return place.finish(STATED)
    moved.rename(place.run)
    if ended.code == DONE:
        place.same_bytes()
        raise Missed("it had ended before")
    return place.finish(STATED)


# A command that starts another one as the first process of its own, so that all have the same number on the same host.
ALONE = ["unshare", "--pid", "--fork", "--mount-proc"]


def equal_processes(suite: Suite) -> Iterator[Try]:
    need("unshare")
    need_root()
    tried = subprocess.run([*ALONE, "true"], capture_output=True)
    if tried.returncode != DONE:
        raise Skipped(f"unshare does not work here: {tried.stderr.decode(errors='replace').strip()}")

    def act(place: Place) -> str:
        words = [*place.words(threads=1), "--shard"]
        # A shard that runs twice, as after a lost node.
        twins = [place.start(*words, "1/2", before=ALONE) for _ in range(2)]
        for running in [*twins, place.start(*words, "2/2", before=ALONE)]:
            running.ended({DONE})
        place.stickslip("merge", "run")
        place.same_bytes()
        return place.finish(SAME)

    for kind in suite.kinds("equal-processes", RUNS):
        for number in range(suite.many(1, 10)):
            yield Try(kind, f"{number}", act)


ROWS = [
    Row("two-runners", "two runners at once", two_runners, is_timed=True),
    Row("equal-processes", "shards whose processes have one number and host", equal_processes),
    Row("stale-lock", "a killed runner leaves no lock", stale_locks, is_timed=True),
    Row("moved", "the directory is moved, removed, replaced", moved_or_removed, is_timed=True),
]
