"""What the program says on standard error: one JSON object a line, as docs/reference/command-line.md describes them, in
the terms of this package.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from ._words import in_python, remedy_in_python

#: The codes of messages that are no failure, beside ``progress`` and ``warning``.
NOTES = frozenset({"note", "file-written", "run-finished", "run-apart", "interrupting"})


@dataclass(frozen=True)
class Message:
    """One message. What it does not hold is ``None``."""

    code: str | None
    text: str
    place: dict[str, Any] | None = None
    remedy: str | None = None
    progress: dict[str, Any] | None = None


def parsed(line: bytes) -> Message:
    """The message in a line. What is none, as of a system that cannot start the program, has no code."""
    text = line.decode(errors="replace")
    try:
        sent = json.loads(text)
        remedy = sent.get("remedy")
        return Message(
            sent["code"],
            in_python(sent["text"]),
            sent.get("place"),
            remedy_in_python(remedy) if remedy else None,
            sent.get("progress"),
        )
    except (ValueError, KeyError, TypeError, AttributeError):
        return Message(None, text)
