"""Clock, locale, time zone and number of threads that change between a run and its resumption."""

import functools
import os
import signal
import subprocess
import time
from typing import Iterator

from common import DONE, SAME, Place, Row, Skipped, Suite, Try, need

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


def interrupted(place: Place, environment: dict, number: int) -> bool:
    """Begins or resumes a run, and ends it at a random moment; whether that came before its end."""
    running = place.go_on(threads=place.random.choice([1, 2, 3, 5, 8]), environment=environment)
    place.wait(running)
    running.send(number)
    return running.ended({DONE, 128 + number, -number}).code != DONE


def changed(suite: Suite) -> Iterator[Try]:
    def act(place: Place) -> str:
        for _ in range(3):
            environment = dict(os.environ)
            for choices in (LOCALES, ZONES, OTHERS):
                environment.update(place.random.choice(choices))
            if not interrupted(place, environment, place.random.choice([signal.SIGTERM, signal.SIGKILL])):
                break
        return place.finish(SAME)

    for kind in suite.kinds("locale"):
        for number in range(suite.many(4, 50)):
            yield Try(kind, f"{number}", act)


def threads(suite: Suite) -> Iterator[Try]:
    def act(place: Place) -> str:
        place.begin(threads=count).ended({DONE})
        place.same_bytes()
        return place.finish(SAME)

    for kind in suite.kinds("thread-count"):
        for count in (*range(1, 33), 64, 128, 256, 512, 1024) if suite.is_full else (1, 2, 3, 7, 64):
            yield Try(kind, f"{count} threads", act, small=True)


def clocks(suite: Suite) -> Iterator[Try]:
    need("faketime")

    def act(place: Place) -> str:
        first = with_clock(clock, DONT_FAKE_MONOTONIC="1")
        interrupted(place, first, signal.SIGTERM)
        # A clock that measures the time since the start wrongly, too.
        interrupted(place, with_clock(place.random.choice(CLOCKS)), signal.SIGTERM)
        if place.has_begun():
            place.stickslip("status", "run", environment=first)
            place.stickslip("resume", "run", environment=first)
        return place.finish(SAME)

    for kind in suite.kinds("clock"):
        for turn in range(suite.many(1, 10)):
            for clock in CLOCKS[:: suite.many(2, 1)]:
                yield Try(kind, f"{clock} {turn}", act)


def jumping_clocks(suite: Suite) -> Iterator[Try]:
    """The clock is set while the program runs."""
    need("faketime")

    def act(place: Place) -> str:
        stamp = place.path / "clock"
        stamp.write_text("+0d")
        settings = {"FAKETIME_TIMESTAMP_FILE": str(stamp), "FAKETIME_NO_CACHE": "1", "DONT_FAKE_MONOTONIC": "1"}
        environment = dict(os.environ, LD_PRELOAD=library(), **settings)
        running = place.begin(threads=2, environment=environment)
        while running.is_alive():
            stamp.write_text(place.random.choice(["+300d", "-300d", "+5s", "-5s", "-30y"]))
            time.sleep(0.01)
        running.ended({DONE})
        place.same_bytes()
        return place.finish(SAME)

    for kind in suite.kinds("clock-jumps"):
        for turn in range(suite.many(1, 20)):
            yield Try(kind, f"{turn}", act)


def with_clock(clock: str, **settings: str) -> dict:
    """The environment in which a program sees this clock."""
    return dict(os.environ, LD_PRELOAD=library(), FAKETIME=clock, **settings)


@functools.lru_cache(maxsize=None)
def library() -> str:
    """The library by which faketime sets the clock of a program. The command itself fails now and then, where one of the
    same number was killed before."""
    for _ in range(5):
        said = subprocess.run(["faketime", "-f", "+0d", "env"], capture_output=True, text=True).stdout
        for line in said.splitlines():
            if line.startswith("LD_PRELOAD="):
                return line.split("=", 1)[1]
    raise Skipped("faketime does not preload a library here")


ROWS = [
    Row("locale", "locale, time zone and environment change between resumptions", changed),
    Row("thread-count", "numbers of threads", threads),
    Row("clock", "clocks that are off, fast, slow", clocks),
    Row("clock-jumps", "the clock is set in mid-run", jumping_clocks),
]
