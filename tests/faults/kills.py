"""Kills: at random moments, and before every call that changes a file."""

import signal
from typing import Iterator

from common import DONE, SAME, Missed, Place, Row, Suite, Try
from tracing import MOST_CALLS, need_tracing, with_fault

KILLED = -signal.SIGKILL

# Without --all, one of so many calls is hit.
STRIDES = {"write": 7, "fsync": 5, "rename": 5, "openat": 11, "mkdir": 1}


def at_random_moments(suite: Suite) -> Iterator[Try]:
    def act(place: Place) -> str:
        was_hit = False
        # Most are killed once, some again while they are resumed.
        for _ in range(place.random.choice([1, 1, 2, 3])):
            running = place.go_on()
            place.wait(running)
            running.send(signal.SIGKILL)
            if running.ended({DONE, KILLED}).code == DONE:
                break
            was_hit = True
        if not was_hit:
            raise Missed("it had ended before")
        return place.finish(SAME)

    for kind in suite.kinds("kill"):
        for number in range(suite.many(8, 200)):
            yield Try(kind, f"{number}", act)


def at_every_call(suite: Suite) -> Iterator[Try]:
    need_tracing()
    for kind in suite.kinds("kill-call"):
        for call, stride in STRIDES.items():
            stride = 1 if suite.is_full else stride
            first = suite.chance("stride", kind, call).randint(1, stride)
            survived: list = []
            for number in range(first, MOST_CALLS, stride):
                yield Try(kind, f"{call} {number}", lambda place: killed_at(place, call, number, survived), small=True)
                if survived:
                    break


def killed_at(place: Place, call: str, number: int, survived: list) -> str:
    """Kills a run before one of its calls. If it makes fewer, that is noted."""
    ended = place.go_on(before=with_fault(call, f"signal=SIGKILL:when={number}")).ended({DONE, KILLED})
    if ended.code == KILLED:
        return place.finish(SAME)
    survived.append(number)
    return place.same_bytes()


ROWS = [
    Row("kill", "kill -9 at a random moment", at_random_moments, is_timed=True),
    Row("kill-call", "kill -9 at every write, fsync, rename, openat, mkdir", at_every_call),
]
