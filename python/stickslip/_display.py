"""Showing notes and progress to the user, at a terminal, in a notebook and in a file."""

from __future__ import annotations

import html
import shutil
import time
from typing import Any, TextIO

from ._messages import Message

#: Seconds between two lines of progress in a file. Another twentieth of the work is shown after the shortest time.
_INTERVAL, _SHORTEST = 30.0, 2.0

_BAR = 30


class Display:
    """Shows messages on a stream, nothing without one: a bar at a terminal and in a notebook, elsewhere a line every now
    and then.
    """

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream
        self._has_bar = stream is not None and getattr(stream, "isatty", lambda: False)()
        self._drawn = 0
        # What a notebook runs has a stream of its kernel for standard error.
        self._is_notebook = type(stream).__module__.split(".")[0] == "ipykernel"
        self._output: Any = None
        self._shown_at, self._shown = time.monotonic(), 0

    def note(self, text: str) -> None:
        """Show a note in a line of its own."""
        self._clear_line()
        self._write(f"stickslip: {text}\n")

    def progress(self, message: Message) -> None:
        """Show how far a computation is."""
        numbers = message.progress or {}
        done, total = numbers.get("done", 0), max(numbers.get("total", 0), 1)
        if self._has_bar:
            self._draw(message.text, done / total)
            return
        if self._is_notebook:
            self._show_output(message.text, done / total)
            return
        if done < self._shown:
            # Another computation.
            self._shown = 0
        since = time.monotonic() - self._shown_at
        if since >= _INTERVAL or (since >= _SHORTEST and (done - self._shown) * 20 >= total):
            self._shown_at, self._shown = time.monotonic(), done
            self.note(message.text)

    def clear(self) -> None:
        """Remove the bar."""
        self._clear_line()
        if self._output is not None:
            self._output.update({"text/plain": "", "text/html": ""}, raw=True)
            self._output = None

    def _show_output(self, text: str, share: float) -> None:
        """Show a bar as an output of the cell, in place of the one before."""
        bar = f'<progress max="1" value="{share:.4f}"></progress> {html.escape(text)}'
        bundle = {"text/plain": text, "text/html": bar}
        if self._output is None:
            import IPython.display

            show: Any = IPython.display.display
            self._output = show(bundle, raw=True, display_id=True)
        else:
            self._output.update(bundle, raw=True)

    def _clear_line(self) -> None:
        if self._drawn:
            self._write("\r" + " " * self._drawn + "\r")
            self._drawn = 0

    def _draw(self, text: str, share: float) -> None:
        width = shutil.get_terminal_size().columns - 1
        length = max(min(_BAR, width - len(text) - 1), 10)
        full, empty = "█░" if "utf" in str(getattr(self._stream, "encoding", None)).lower() else "#-"
        filled = int(share * length)
        line = f"{full * filled}{empty * (length - filled)} {text}"[:width]
        self._write("\r" + line.ljust(self._drawn))
        self._drawn = len(line)

    def _write(self, text: str) -> None:
        if self._stream is not None:
            self._stream.write(text)
            self._stream.flush()
