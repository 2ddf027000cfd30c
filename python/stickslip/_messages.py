"""What the program says on standard error: one JSON object a line, as docs/reference/command-line.md describes them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

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
        return Message(sent["code"], sent["text"], sent.get("place"), sent.get("remedy"), sent.get("progress"))
    except (ValueError, KeyError, TypeError):
        return Message(None, text)
