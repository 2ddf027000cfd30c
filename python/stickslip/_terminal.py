"""The way of the program's messages to ``sys.stderr``: through a terminal of their own where that is one, so that the
program draws its bar, and through a pipe elsewhere, as in a notebook."""

from __future__ import annotations

import codecs
import os
import select
import sys
from types import TracebackType

try:
    import fcntl
    import termios
    import tty
except ImportError:  # pragma: no cover - there are no terminals of this kind
    _HAS_TERMINALS = False
else:
    _HAS_TERMINALS = True


class Channel:
    """Reads what the program writes to its standard error, and shows it.

    Parameters
    ----------
    is_shown : bool
        Whether it goes on to ``sys.stderr``.
    """

    def __init__(self, is_shown: bool) -> None:
        self._stream = sys.stderr if is_shown else None
        terminal = self._terminal()
        if terminal is None:
            self._own, self.end_of_program = os.pipe()
        else:
            self._own, self.end_of_program = os.openpty()
            tty.setraw(self.end_of_program)
            fcntl.ioctl(self.end_of_program, termios.TIOCSWINSZ, fcntl.ioctl(terminal, termios.TIOCGWINSZ, b"\0" * 8))
        os.set_inheritable(self._own, False)
        self._is_open = True
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")

    def __enter__(self) -> Channel:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close_end_of_program()
        os.close(self._own)

    def _terminal(self) -> int | None:
        """The terminal that ``sys.stderr`` is, if it is one."""
        try:
            if not _HAS_TERMINALS or self._stream is None:
                return None
            number = self._stream.fileno()
            return number if os.isatty(number) else None
        except (AttributeError, OSError, ValueError):
            return None

    def close_end_of_program(self) -> None:
        """Close the end that the program has inherited, so that its end is noticed."""
        if self._is_open:
            self._is_open = False
            os.close(self.end_of_program)

    def read(self, timeout: float | None = None) -> str | None:
        """The next text; empty when the program has ended, ``None`` if nothing came in so many seconds."""
        while True:
            if timeout is not None and not select.select([self._own], [], [], timeout)[0]:
                return None
            try:
                data = os.read(self._own, 1 << 16)
            except OSError:
                # So does Linux say that nobody has the other end of a terminal any more.
                data = b""
            text = self._decoder.decode(data, final=not data)
            if text or not data:
                return text

    def show(self, text: str) -> None:
        """Show a text."""
        if text and self._stream is not None:
            self._stream.write(text)
            self._stream.flush()
