"""Standard input, output and error that are closed, full or without a reader."""

from typing import Iterator

from common import DONE, INPUT_OUTPUT, SAME, STATED, Place, Row, Suite, Try, check

# Redirections of the shell, and the codes that the program may end with.
STREAMS = {
    "| head -1": "{command} | head -1",
    "| true": "{command} | true",
    "> /dev/full": "{command} > /dev/full",
    ">&-": "{command} >&-",
    "2> /dev/full": "{command} 2> /dev/full",
    "2>&-": "{command} 2>&-",
    "2>&1 >/dev/null | true": "{command} 2>&1 > /dev/null | true",
    "> /dev/full 2>&1": "{command} > /dev/full 2>&1",
    ">&- 2>&-": "{command} >&- 2>&-",
    "<&- >&- 2>&-": "{command} <&- >&- 2>&-",
}

# What is lost of the result is an error, what is lost of messages is not. A reader that has seen enough ends the program
# as it ends the tools of a shell.
UNREAD = 141
MUST_FAIL = {"> /dev/full", "> /dev/full 2>&1"}
MAY_FAIL = dict.fromkeys((">&-", ">&- 2>&-", "<&- >&- 2>&-"), INPUT_OUTPUT) | dict.fromkeys(("| head -1", "| true"), UNREAD)

# Commands on a finished run that write to standard output.
READING = ["status run", "status run --json", "verify run", "resume run", "check job.toml", "plot run --out plot.svg"]


def redirected(place: Place, stream: str, words: str) -> str:
    """Runs a command with a redirection; the code of the program is kept in a file."""
    command = f'sh -c \'"$S" {words}; echo $? > code\''
    place.shell(STREAMS[stream].format(command=command), expect=None)
    code = int((place.path / "code").read_text())
    check(code == INPUT_OUTPUT or stream not in MUST_FAIL, f"it ends with {code} although the result was lost")
    may = {DONE, INPUT_OUTPUT if stream in MUST_FAIL else MAY_FAIL.get(stream, DONE)}
    check(code in may, f"`{words}` {stream}: it ends with {code}, not {sorted(may)}")
    return SAME if code == DONE else STATED


def submitting(suite: Suite) -> Iterator[Try]:
    def act(place: Place) -> str:
        outcome = redirected(place, stream, " ".join(place.words()))
        # The surface is written before it is shown.
        place.same_bytes()
        place.finish()
        return outcome

    for kind in suite.kinds("streams"):
        for stream in STREAMS:
            yield Try(kind, stream, act, small=True)


def reading(suite: Suite) -> Iterator[Try]:
    def act(place: Place) -> str:
        place.copy_of(place.reference.whole)
        # What nothing is written to cannot fail.
        if words.startswith("plot") and stream in MUST_FAIL:
            place.shell(f'"$S" {words} > /dev/full', expect={DONE, INPUT_OUTPUT})
            outcome = SAME
        else:
            outcome = redirected(place, stream, words)
        place.finish()
        return outcome

    for words in READING:
        for stream in STREAMS:
            yield Try("eigenvalue", f"{words} {stream}", act, small=True)


ROWS = [
    Row("streams", "closed or full standard streams", submitting),
    Row("streams-reading", "the same, commands on a finished run", reading),
]
