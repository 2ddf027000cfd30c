"""Running the program: its input, its messages as they come, its end, and Ctrl-C.

The program runs in a session of its own while the main thread waits for it, so that Ctrl-C reaches it once, from here,
in a terminal and in a notebook alike. In other threads Python does not get Ctrl-C; there the program stays in the
process group of Python, where a terminal reaches it itself, and :func:`interrupt` does so elsewhere.
"""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import threading
import types
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ._display import Display
from ._errors import Error, Interrupted, JobWarning, error_of
from ._messages import NOTES, Message, parsed
from ._program import program
from ._texts import as_word, encoded

_INTERRUPTED = 130

#: The programs that run now, of all threads.
_running: set[_Program] = set()

#: The ends of lifelines that are open, and what keeps a fork from coming between an end and this note of it.
_ends: set[int] = set()
_noting = threading.RLock()


class _Program:
    """The program at work, and how often it was interrupted."""

    def __init__(self) -> None:
        self.process: subprocess.Popen[bytes] | None = None
        self.interruptions = 0
        #: It was interrupted before it began.
        self.is_due = False

    def interrupt(self) -> None:
        """Ask it to keep what is finished and to end; a second time to end at once."""
        self.interruptions += 1
        if self.process is None:
            self.is_due = True
            return
        if self.process.returncode is not None:
            return
        if self.interruptions > 2:
            self.process.kill()
        else:
            self.process.send_signal(signal.SIGINT)


def interrupt() -> None:
    """Interrupt every run that is at work in this Python process, as Ctrl-C does.

    Python passes Ctrl-C to the main thread alone. Call this for runs in other threads, for example from the next cell
    of a notebook. Each of them raises :class:`Interrupted` in its thread.
    """
    for running in list(_running):
        running.interrupt()


def call(
    arguments: Sequence[str | os.PathLike[str]],
    *,
    stdin: str | None = None,
    progress: bool = False,
    unsaid: str | None = None,
    heard: Callable[[Message], None] | None = None,
) -> str:
    """Run the program, and return what it writes to standard output.

    Its progress and notes go to ``sys.stderr`` with ``progress``, but for those with the code ``unsaid``. ``heard`` gets
    each note as it comes. Its warnings become :class:`JobWarning`.

    Raises
    ------
    Error
        If it fails.
    Interrupted
        If Ctrl-C ended it.
    """
    command = [as_word(word) for word in (program(), "--messages=json", *arguments)]
    running = _Program()
    display = Display(sys.stderr if progress else None)
    received: list[Message] = []
    with _ctrl_c(running) as is_forwarded, tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as given:
        if stdin is not None:
            given.write(encoded(stdin, "the job"))
            given.seek(0)
        with _lifeline() as lifeline:
            process = subprocess.Popen(
                command,
                stdin=given if stdin is not None else subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.PIPE,
                bufsize=0,
                start_new_session=is_forwarded,
                pass_fds=lifeline,
            )
            running.process = process
            _running.add(running)
            try:
                _end_with_python(process.pid, lifeline)
                if running.is_due:
                    process.send_signal(signal.SIGINT)
                for message in _messages(process):
                    if message.code == "progress":
                        display.progress(message)
                    elif message.code not in NOTES:
                        received.append(message)
                    else:
                        if heard is not None:
                            heard(message)
                        if message.code != unsaid:
                            display.note(message.text)
                process.wait()
            except BaseException:
                process.terminate()
                process.wait()
                raise
            finally:
                _running.discard(running)
                display.clear()
                process.stderr.close()  # type: ignore[union-attr]
        output.seek(0)
        result = output.read().decode(errors="replace")
    code = process.returncode if process.returncode >= 0 else 128 - process.returncode
    failure = _failure(code, running, [message for message in received if message.code != "warning"])
    try:
        for message in received:
            if message.code == "warning":
                warnings.warn(message.text, JobWarning, stacklevel=_depth_of_caller())
    finally:
        # Where warnings are errors, what ended the program counts more.
        if failure is not None:
            raise failure
    return result


def _failure(code: int, running: _Program, received: list[Message]) -> Error | Interrupted | None:
    """What is raised at the end of the program."""
    last = received[-1] if received else Message(None, "")
    if last.code is None:
        # Lines of somebody else, such as the system that cannot start the program.
        last = Message(None, "\n".join(message.text for message in received if message.code is None))
    failure: Error | Interrupted
    if code == _INTERRUPTED or running.interruptions:
        failure = Interrupted(last.text or "interrupted")
    elif code != 0:
        failure = error_of(code, last.text or f"the program ended with code {code} without a message", last.code)
    else:
        return None
    failure.code, failure.place, failure.remedy = last.code, last.place, last.remedy
    return failure


def call_json(
    arguments: Sequence[str | os.PathLike[str]],
    *,
    stdin: str | None = None,
    progress: bool = False,
    unsaid: str | None = None,
) -> Any:
    """Run a command with ``--json``, and return what it prints."""
    return json.loads(call([*arguments, "--json"], stdin=stdin, progress=progress, unsaid=unsaid))


def _messages(process: subprocess.Popen[bytes]) -> Iterator[Message]:
    """What the program says, as it comes, until it ends."""
    said = process.stderr
    assert said is not None
    held = b""
    while True:
        # The system may give a signal to another thread, which does not wake this one; so it looks by itself.
        if not select.select([said], [], [], 0.5)[0]:
            continue
        data = said.read(1 << 16)
        *lines, held = (held + data).split(b"\n")
        yield from map(parsed, lines)
        if not data:
            if held:
                yield parsed(held)
            return


@contextmanager
def _ctrl_c(running: _Program) -> Iterator[bool]:
    """Forward Ctrl-C to the program. Whether that is possible: in the main thread, unless SIGINT is ignored."""
    if threading.current_thread() is not threading.main_thread():
        yield False
        return
    before = signal.getsignal(signal.SIGINT)
    if before in (None, signal.SIG_IGN):
        yield False
        return

    def forward(_number: int, _frame: types.FrameType | None) -> None:
        running.interrupt()

    signal.signal(signal.SIGINT, forward)
    try:
        yield True
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _lifeline() -> Iterator[tuple[int, ...]]:
    """A pipe whose end that Python holds closes when Python ends, however it ends. The end for the program."""
    if not sys.platform.startswith("linux"):
        yield ()
        return
    with _noting:
        read, write = os.pipe()
        _ends.update((read, write))
    try:
        yield (read,)
    finally:
        for end in (read, write):
            _close(end)


def _close(end: int) -> None:
    """Close an end of a lifeline, unless a fork has done so in this process."""
    with _noting:
        if end in _ends:
            _ends.remove(end)
            os.close(end)


def _forget() -> None:
    """Leave the programs to the process that was forked, so that they end with that one."""
    for end in list(_ends):
        _close(end)
    _running.clear()
    _noting.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_noting.acquire, after_in_parent=_noting.release, after_in_child=_forget)


def _end_with_python(pid: int, lifeline: tuple[int, ...]) -> None:
    """Let Linux send SIGTERM to the program when the other end of its lifeline is closed."""
    if not sys.platform.startswith("linux"):
        return
    import fcntl

    for end in lifeline:
        fcntl.fcntl(end, fcntl.F_SETOWN, pid)
        fcntl.fcntl(end, fcntl.F_SETSIG, signal.SIGTERM)
        fcntl.fcntl(end, fcntl.F_SETFL, fcntl.fcntl(end, fcntl.F_GETFL) | os.O_ASYNC)


def _depth_of_caller() -> int:
    """How many frames lie between a warning and the user's code."""
    here = os.path.dirname(__file__)
    frame: types.FrameType | None = sys._getframe(1)
    depth = 1
    while frame is not None and os.path.dirname(frame.f_code.co_filename) == here:
        frame, depth = frame.f_back, depth + 1
    return depth
