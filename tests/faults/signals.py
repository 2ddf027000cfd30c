"""Every signal, once and twice; stop and continue; signals that are ignored."""

import signal
import time
from typing import Iterator

from common import DONE, SAME, STATED, Missed, Place, Row, Running, Suite, Try, check

# Signals that end a process which does nothing about them. They keep what is finished and say how to go on.
ENDING = [
    number
    for name in (
        "HUP INT QUIT TRAP ABRT SYS USR1 USR2 ALRM TERM XCPU VTALRM PROF STKFLT IO PWR RTMIN RTMAX"
    ).split()
    if (number := getattr(signal, f"SIG{name}", None)) is not None
]

# Signals that change nothing: a run goes on. A stopped one is continued.
HARMLESS = [signal.SIGPIPE, signal.SIGXFSZ, signal.SIGCHLD, signal.SIGURG, signal.SIGWINCH, signal.SIGCONT]
STOPPING = [signal.SIGSTOP, signal.SIGTSTP, signal.SIGTTIN, signal.SIGTTOU]

# Faults of the processor, and what nothing can be done about: what is on disk is kept.
DEADLY = [signal.SIGKILL, signal.SIGSEGV, signal.SIGBUS, signal.SIGILL, signal.SIGFPE]

# A job whose samples take many seconds each.
VERY_SLOW = """name = "long"
[model.disc]
youngs_modulus = 1e13
thickness = 0.05
[axes]
rotating_speed = 15.0
preload = 0.1
static_friction = 0.39
[random]
inputs = ["disc.poissons_ratio"]
relative_std = 0.1
[criterion]
kind = "time-domain"
start = "rest"
disc_modes = 24
record = ["amplitude"]
[sampling]
samples = 3
"""


def name_of(number: int) -> str:
    return signal.Signals(number).name


def at_work(place: Place) -> Running:
    """A run that has begun, at a random moment."""
    running = place.begin()
    place.wait_for_work(running)
    place.wait(running, 0.5)
    return running


def once(place: Place, number: int) -> str:
    running = at_work(place)
    running.send(number)
    ended = running.ended({DONE, 128 + number})
    if ended.code == DONE:
        raise Missed("it had ended before")
    place.says_how_to_go_on(ended)
    place.tidy()
    return place.finish(STATED)


def twice(place: Place, first: int, second: int) -> str:
    """Two signals within a moment."""
    running = at_work(place)
    running.send(first)
    time.sleep(place.random.uniform(0, 0.05))
    running.send(second)
    ended = running.ended({DONE, 128 + first, 128 + second})
    if ended.code == DONE:
        raise Missed("it had ended before")
    place.says_how_to_go_on(ended)
    place.tidy()
    return place.finish(STATED)


def twice_while_slow(place: Place, number: int) -> str:
    """A second signal ends a run at once that would have taken two seconds to end."""
    (place.path / "slow.toml").write_text(VERY_SLOW)
    running = place.start("submit", "slow.toml", "--out", "slow", "--threads", 1)
    place.wait_for(lambda: running.work() > 1.5, running, "the work")
    running.send(number)
    first = time.monotonic()
    time.sleep(0.6)
    is_alive = running.is_alive()
    if time.monotonic() - first > 1.5:
        raise Missed("it may have ended by itself when it was looked at")
    check(is_alive, "it ended before the second signal, although its sample takes longer")
    running.send(number)
    ended = running.ended({128 + number})
    ended.says("continue with `stickslip resume slow`")
    # What it says where it does not wait for a second signal.
    if "given up" in ended.stderr:
        raise Missed("it ended by itself")
    place.tidy()
    return STATED


def harmless(place: Place, number: int) -> str:
    running = at_work(place)
    running.send(number)
    running.ended({DONE})
    place.same_bytes()
    return place.finish(SAME)


def stopped(place: Place, number: int) -> str:
    running = at_work(place)
    for _ in range(3):
        running.send(number)
        time.sleep(place.random.uniform(0, 0.2))
        running.send(signal.SIGCONT)
        time.sleep(place.random.uniform(0, 0.02))
    running.ended({DONE})
    place.same_bytes()
    return place.finish(SAME)


def stopped_and_ended(place: Place) -> str:
    """A stopped run obeys a signal when it goes on."""
    running = at_work(place)
    running.send(signal.SIGSTOP)
    running.send(signal.SIGTERM)
    time.sleep(0.1)
    running.send(signal.SIGCONT)
    ended = running.ended({DONE, 128 + signal.SIGTERM})
    if ended.code == DONE:
        raise Missed("it had ended before")
    place.says_how_to_go_on(ended)
    place.tidy()
    return place.finish(STATED)


def deadly(place: Place, number: int) -> str:
    running = at_work(place)
    # Rust takes the first SIGSEGV and SIGBUS, to see whether the stack is full; the next then ends the process.
    while running.is_alive():
        running.send(number)
        time.sleep(0.001)
    if running.ended({DONE, -number}).code == DONE:
        raise Missed("it had ended before")
    return place.finish(STATED)


def ignored(place: Place, numbers: list) -> str:
    """Signals that were ignored when the program began, as under nohup, stay so."""
    words = ["sh", "-c", f"trap '' {' '.join(name_of(number)[3:] for number in numbers)}; exec \"$0\" \"$@\""]
    running = place.begin(before=words)
    place.wait_for_work(running)
    for number in numbers:
        running.send(number)
    running.ended({DONE})
    place.same_bytes()
    return place.finish(SAME)


def signalled(suite: Suite) -> Iterator[Try]:
    kinds = suite.kinds("signal")
    for kind in kinds:
        for turn in range(suite.many(1, 10)):
            # Without --all, each kind of run gets a part of the signals.
            ending = ENDING if suite.is_full else ENDING[kinds.index(kind) :: len(kinds)]
            for number in [*ending, signal.SIGINT, signal.SIGTERM] if not suite.is_full else ending:
                yield Try(kind, f"{name_of(number)} {turn}", lambda place: once(place, number))


def signalled_twice(suite: Suite) -> Iterator[Try]:
    for kind in suite.kinds("signal-twice"):
        chance = suite.chance("twice", kind)
        pairs = [(first, second) for first in ENDING for second in ENDING]
        for first, second in pairs if suite.is_full else chance.sample(pairs, 4):
            yield Try(kind, f"{name_of(first)} {name_of(second)}", lambda place: twice(place, first, second))
    repeated = (signal.SIGXCPU, signal.SIGALRM, signal.SIGVTALRM, signal.SIGPROF)
    for number in [number for number in ENDING if number not in repeated][:: suite.many(4, 1)]:
        label = f"{name_of(number)} while slow"
        yield Try("time-domain", label, lambda place: twice_while_slow(place, number))


def passing(suite: Suite) -> Iterator[Try]:
    for kind in suite.kinds("signal-passing"):
        for turn in range(suite.many(1, 10)):
            for number in HARMLESS:
                yield Try(kind, f"{name_of(number)} {turn}", lambda place: harmless(place, number))
            for number in STOPPING:
                yield Try(kind, f"{name_of(number)} {turn}", lambda place: stopped(place, number))
            yield Try(kind, f"stopped and ended {turn}", stopped_and_ended)
            for numbers in ([signal.SIGHUP], [signal.SIGINT], [signal.SIGHUP, signal.SIGINT, signal.SIGQUIT]):
                label = f"ignored {' '.join(map(name_of, numbers))} {turn}"
                yield Try(kind, label, lambda place: ignored(place, numbers))


def killed(suite: Suite) -> Iterator[Try]:
    for kind in suite.kinds("signal-deadly"):
        for turn in range(suite.many(1, 10)):
            for number in DEADLY:
                yield Try(kind, f"{name_of(number)} {turn}", lambda place: deadly(place, number))


ROWS = [
    Row("signal", "every signal that ends a process", signalled, is_timed=True),
    Row("signal-twice", "two signals", signalled_twice, is_timed=True),
    Row("signal-passing", "stop and continue, harmless and ignored signals", passing, is_timed=True),
    Row("signal-deadly", "signals that cannot be obeyed", killed, is_timed=True),
]
