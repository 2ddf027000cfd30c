"""Clock, locale, time zone and number of threads that change between a run and its resumption."""

import os
import signal
import subprocess
import time
from typing import Iterator

from common import DONE, KINDS, SAME, Place, Row, Skipped, Suite, Try, need

LOCALES = [
    {"LC_ALL": "C"},
    {"LC_ALL": "POSIX", "LANG": ""},
    {"LC_ALL": "de_DE.UTF-8", "LANGUAGE": "de"},
    {"LC_ALL": "tr_TR.UTF-8"},
    {"LC_NUMERIC": "fr_FR.UTF-8", "LANG": "ja_JP.eucJP"},
    {"LC_ALL": "no such locale"},
]
ZONES = [{"TZ": zone} for zone in ("UTC", "Pacific/Kiritimati", "America/St_Johns", ":no/such/zone", "XYZ-99:99")]
OTHERS = [
    {"RAYON_NUM_THREADS": "3"},
    {"RAYON_NUM_THREADS": "many"},
    {"COLUMNS": "1", "TERM": "dumb"},
    {"NO_COLOR": "1", "RUST_BACKTRACE": "full", "RUST_LOG": "trace"},
    {"TMPDIR": "/nonexistent", "HOME": "/nonexistent", "PWD": "/nonexistent"},
]

# Clocks for faketime: far off, fast and slow.
CLOCKS = ["@1970-01-01 00:00:01", "@2106-02-07 06:28:20", "-40y", "+30y", "-1d", "+0 x40", "+0 x0.1"]


def interrupted(place: Place, environment: dict, before: list, number: int) -> bool:
    """Begins or resumes a run, and ends it at a random moment; whether that came before its end."""
    words = ["resume", "run"] if (place.run / "job.toml").exists() else ["submit", "job.toml", "--out", "run"]
    threads = place.random.choice([1, 2, 3, 5, 8])
    running = place.start(*words, "--threads", threads, before=before, environment=environment)
    place.wait()
    running.send(number)
    # What starts the program may end by the signal itself.
    return running.ended({DONE, 128 + number, -number}).code != DONE


def changed(suite: Suite) -> Iterator[Try]:
    def act(place: Place) -> str:
        for _ in range(3):
            environment = dict(os.environ)
            for choices in (LOCALES, ZONES, OTHERS):
                environment.update(place.random.choice(choices))
            if not interrupted(place, environment, [], place.random.choice([signal.SIGTERM, signal.SIGKILL])):
                break
        return place.finish(SAME)

    for kind in KINDS:
        for number in range(suite.many(4, 50)):
            yield Try(kind, f"{number}", act)


def threads(suite: Suite) -> Iterator[Try]:
    def act(place: Place) -> str:
        place.stickslip("submit", "job.toml", "--out", "run", "--threads", count)
        place.same_bytes()
        return place.finish(SAME)

    for kind in KINDS:
        for count in (*range(1, 33), 64, 128, 256, 512, 1024) if suite.is_full else (1, 2, 3, 7, 64):
            yield Try(kind, f"{count} threads", act, small=True)


def clocks(suite: Suite) -> Iterator[Try]:
    need("faketime")

    def act(place: Place) -> str:
        environment = dict(os.environ)
        before = ["faketime", "--exclude-monotonic", "-f", clock]
        interrupted(place, environment, before, signal.SIGTERM)
        other = place.random.choice(CLOCKS)
        interrupted(place, environment, ["faketime", "-f", other], signal.SIGTERM)
        if (place.run / "job.toml").exists():
            place.stickslip("status", "run", before=before)
            place.stickslip("resume", "run", before=before)
        return place.finish(SAME)

    for kind in KINDS:
        for turn in range(suite.many(1, 10)):
            for clock in CLOCKS[:: suite.many(2, 1)]:
                yield Try(kind, f"{clock} {turn}", act)


def jumping_clocks(suite: Suite) -> Iterator[Try]:
    """The clock is set while the program runs."""
    need("faketime")

    def act(place: Place) -> str:
        stamp = place.path / "clock"
        stamp.write_text("+0d")
        environment = dict(os.environ, FAKETIME_TIMESTAMP_FILE=str(stamp), FAKETIME_NO_CACHE="1")
        environment.update(DONT_FAKE_MONOTONIC="1", LD_PRELOAD=library())
        running = place.start("submit", "job.toml", "--out", "run", "--threads", 2, environment=environment)
        while running.is_alive():
            stamp.write_text(place.random.choice(["+300d", "-300d", "+5s", "-5s", "-30y"]))
            time.sleep(0.01)
        running.ended({DONE})
        place.same_bytes()
        return place.finish(SAME)

    for kind in KINDS:
        for turn in range(suite.many(1, 20)):
            yield Try(kind, f"{turn}", act)


def library() -> str:
    """The library by which faketime sets the clock of a program."""
    said = subprocess.run(["faketime", "-f", "+0d", "env"], capture_output=True, text=True).stdout
    found = [line.split("=", 1)[1] for line in said.splitlines() if line.startswith("LD_PRELOAD=")]
    if not found:
        raise Skipped("faketime does not preload a library here")
    return found[0]


ROWS = [
    Row("locale", "locale, time zone and environment change between resumptions", changed),
    Row("thread-count", "numbers of threads", threads),
    Row("clock", "clocks that are off, fast, slow", clocks),
    Row("clock-jumps", "the clock is set in mid-run", jumping_clocks),
]
