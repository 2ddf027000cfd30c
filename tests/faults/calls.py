"""Calls that fail: reading, writing, syncing and renaming."""

import signal
from typing import Iterator

from common import CANNOT_CREATE, DONE, INPUT_OUTPUT, JOB, STATED, Missed, Place, Row, Suite, Try, check
from kinds import RUNS
from tracing import MOST_CALLS, need_tracing, with_fault

ERRORS = [
    ("fsync", "EIO"),
    ("fsync", "ENOSPC"),
    ("fsync", "EINTR"),
    ("write", "EIO"),
    ("write", "ENOSPC"),
    ("write", "EINTR"),
    ("rename", "EIO"),
    ("rename", "ENOSPC"),
    ("rename", "EINTR"),
    ("mkdir", "ENOSPC"),
    ("openat", "EMFILE"),
    ("read", "EIO"),
    ("read", "EINTR"),
]

# Without --all, one of so many calls fails.
STRIDES = {"fsync": 9, "write": 13, "rename": 7, "mkdir": 2, "openat": 23, "read": 13}

# What the loader of programs says, and the library of threads: the program has not begun.
BEFORE_THE_PROGRAM = "error while loading shared libraries"


def failing(suite: Suite) -> Iterator[Try]:
    need_tracing()
    for kind in suite.kinds("call-fails"):
        for call, error in ERRORS:
            for words in ("submit", "resume") if kind in RUNS else ("begin",):
                stride = 1 if suite.is_full else STRIDES[call]
                first = suite.chance("stride", kind, call, error, words).randint(1, stride)
                survived: list = []
                for number in range(first, MOST_CALLS, stride):
                    label = f"{words}, {call} {number} {error}"
                    yield Try(kind, label, lambda place: failed_at(place, words, call, error, number, survived), True)
                    if survived:
                        break


def failed_at(place: Place, words: str, call: str, error: str, number: int, survived: list) -> str:
    """Lets one call of a run fail. If it makes fewer, that is noted."""
    if words == "resume":
        place.copy_of(place.reference.half)
        line = ["resume", "run", "--threads", place.threads()]
    else:
        line = place.words()
    # strace says on its own standard error which calls it let fail.
    log = place.path / "strace.log"
    before = with_fault(call, f"error={error}:when={number}")
    before[before.index("/dev/null")] = str(log)
    ended = place.start(*line, before=before).ended()
    if "(INJECTED)" not in log.read_text(errors="replace"):
        survived.append(number)
        check(ended.code == DONE, f"no call failed, and it ends with {ended.code}: {ended.stderr!r}")
        raise Missed("it makes fewer calls")
    if BEFORE_THE_PROGRAM in ended.stderr or ended.code in (-signal.SIGSEGV, 127) and not ended.stderr:
        raise Missed("the loader failed")
    # A job that names a file which cannot be read is refused at its line.
    is_of_job = ended.code == JOB and any(f"{file}: cannot read" in ended.stderr for file in place.table.files)
    check(
        ended.code in (DONE, CANNOT_CREATE, INPUT_OUTPUT) or is_of_job,
        f"it ends with {ended.code}, not 0, 73 or 74: {ended.stderr.strip()!r}",
    )
    if ended.code == DONE:
        outcome = place.same_bytes()
        place.finish()
        return outcome
    ended.says("cannot ")
    where = ("run", "job.toml", "standard output", "signals", *place.table.files)
    check(any(word in ended.stderr for word in where), f"it does not say where: {ended.stderr!r}")
    return place.finish(STATED)


ROWS = [Row("call-fails", "fsync, write, rename, mkdir, openat, read fails", failing)]
