"""How progress is shown: a bar at a terminal, and a line every now and then in a file."""

from __future__ import annotations

import io
import time

import pytest

from stickslip._display import Display
from stickslip._messages import Message


class Terminal(io.StringIO):
    encoding = "utf-8"

    def isatty(self) -> bool:
        return True


def progress(done: int) -> Message:
    return Message("progress", f"{done} %: {done} of 100 samples", progress={"done": done, "total": 100})


def seen(text: str) -> list[str]:
    """The lines that stand at a terminal after a text."""
    lines = []
    for line in text.split("\n"):
        shown: list[str] = []
        for part in line.split("\r"):
            shown[: len(part)] = part
        lines.append("".join(shown).rstrip())
    return lines


def test_a_bar_is_drawn_over_itself_and_goes_for_notes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    stream = Terminal()
    display = Display(stream)
    display.progress(progress(50))
    assert seen(stream.getvalue()) == ["█" * 15 + "░" * 15 + " 50 %: 50 of 100 samples"]
    display.progress(progress(5))
    assert seen(stream.getvalue()) == ["█" + "░" * 29 + " 5 %: 5 of 100 samples"]
    display.note("a note")
    display.progress(progress(100))
    display.clear()
    assert seen(stream.getvalue()) == ["stickslip: a note", ""]
    # It never takes more than a line, and where the characters are missing it has others.
    monkeypatch.setenv("COLUMNS", "24")
    stream = Terminal()
    stream.encoding = "ascii"  # type: ignore[misc]
    Display(stream).progress(progress(50))
    assert stream.getvalue() == "\r#####----- 50 %: 50 of "


def test_a_file_has_a_line_for_each_twentieth_and_each_half_minute(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    stream = io.StringIO()
    display = Display(stream)
    for now, done in ((1, 10), (3, 11), (4, 40), (6, 42), (7, 46), (33, 47), (40, 47), (63, 48), (70, 5), (80, 11)):
        display.progress(progress(done))
    shown = [line.split()[1] for line in stream.getvalue().splitlines()]
    assert shown == ["11", "42", "47", "48", "5", "11"]


def test_nothing_is_shown_without_a_stream() -> None:
    display = Display(None)
    display.progress(progress(3))
    display.note("a note")
    display.clear()
