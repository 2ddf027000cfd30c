"""Running the program: its input, its messages as they come, its end, and Ctrl-C.

The program runs in a session of its own while the main thread waits for it, so that Ctrl-C reaches it once, from here,
in a terminal and in a notebook alike. In other threads Python is not told of Ctrl-C; there the program stays in the
process group of Python, where a terminal reaches it itself, and :func:`interrupt` does so elsewhere.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import types
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ._errors import Interrupted, JobWarning, error_of
from ._messages import Messages, before_failure
from ._program import program
from ._terminal import Channel

_INTERRUPTED = 130

#: The programs that run now, of all threads.
_running: set[_Program] = set()


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

    Python tells the main thread alone of Ctrl-C. Call this for runs in other threads, for example from the next cell of
    a notebook. Each of them raises :class:`Interrupted` in its thread.
    """
    for running in list(_running):
        running.interrupt()


def call(
    arguments: Sequence[str | os.PathLike[str]],
    *,
    stdin: str | None = None,
    progress: bool = False,
    unsaid: str | None = None,
) -> str:
    """Run the program, and return what it writes to standard output.

    Its messages go to ``sys.stderr`` with ``progress``, but for those that name ``unsaid``, a temporary folder. Its
    warnings become :class:`JobWarning`.

    Raises
    ------
    Error
        If it fails.
    Interrupted
        If Ctrl-C ended it.
    """
    command = [os.fspath(word) for word in (program(), *arguments)]
    running = _Program()
    messages = Messages(unsaid)
    with _ctrl_c(running) as is_forwarded, tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as given:
        if stdin is not None:
            given.write(stdin.encode())
            given.seek(0)
        with Channel(progress) as channel, _lifeline() as lifeline:
            process = subprocess.Popen(
                command,
                stdin=given if stdin is not None else subprocess.DEVNULL,
                stdout=output,
                stderr=channel.end_of_program,
                start_new_session=is_forwarded,
                pass_fds=lifeline,
            )
            running.process = process
            _running.add(running)
            try:
                _end_with_python(process.pid, lifeline)
                if running.is_due:
                    process.send_signal(signal.SIGINT)
                channel.close_end_of_program()
                _pass_on(channel, messages, process)
            except BaseException:
                process.terminate()
                process.wait()
                raise
            finally:
                _running.discard(running)
        output.seek(0)
        result = output.read().decode(errors="replace")
    code = process.returncode if process.returncode >= 0 else 128 - process.returncode
    failure: BaseException | None = None
    if code == _INTERRUPTED or running.interruptions:
        failure = Interrupted(messages.failure() or "interrupted")
    elif code != 0:
        failure = error_of(code, messages.failure() or f"the program ended with code {code} without a message")
    try:
        for warning in messages.warnings():
            warnings.warn(warning, JobWarning, stacklevel=_depth_of_caller())
    finally:
        # Where warnings are errors, what ended the program counts more.
        if failure is not None:
            raise failure
    return result


def call_json(
    arguments: Sequence[str | os.PathLike[str]],
    *,
    stdin: str | None = None,
    progress: bool = False,
    unsaid: str | None = None,
) -> Any:
    """Run a command with ``--json``, and return what it prints."""
    return json.loads(call([*arguments, "--json"], stdin=stdin, progress=progress, unsaid=unsaid))


def _pass_on(channel: Channel, messages: Messages, process: subprocess.Popen[bytes]) -> None:
    """Show what the program says, until it ends. The message of a failure is left to the exception."""
    held = ""
    while True:
        # The system may give a signal to another thread, which does not wake this one; so it looks by itself.
        text = channel.read(timeout=0.1 if held else 0.5)
        if text == "":
            break
        # What is not the last is no failure's message.
        channel.show(held)
        held = messages.take(text) if text else ""
    held += messages.rest()
    channel.show(held if process.wait() == 0 else before_failure(held))


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
    read, write = os.pipe()
    try:
        yield (read,)
    finally:
        os.close(read)
        os.close(write)


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
