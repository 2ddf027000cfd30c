"""What the program says on standard error, taken apart: progress, notes, warnings and the message of a failure."""

from __future__ import annotations

import re

_NOTE = "stickslip: "
_WARNING = "stickslip: warning: "
_CODES = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
#: How the messages of the program, and those of its command line, begin.
_BEGINNING = re.compile(r"^(?:stickslip: |error: )", re.MULTILINE)
#: The same with the codes of a terminal, which may wipe a bar out first.
_BEGINNING_AT_TERMINAL = re.compile(
    r"(?:^|\r)((?:\x1b\[[0-9;?]*[A-Za-z])*)(?:stickslip: |error(?:\x1b|:))", re.MULTILINE
)
#: A job that Python hands over has no file. Its errors would name standard input, which nobody has seen.
_ON_INPUT = re.compile(r"^standard input(?=:)", re.MULTILINE)

#: There is no such option here.
_ADVICE = "\n\nFor more information, try '--help'."


class Messages:
    """Collects what the program says, and takes its warnings out of what is shown.

    Parameters
    ----------
    unsaid
        Notes that contain this are not shown.
    """

    def __init__(self, unsaid: str | None = None) -> None:
        self._unsaid = unsaid
        self._held = ""
        self._said: list[str] = []
        self._warnings: list[str] = []

    def take(self, text: str) -> str:
        """Take what was just said, and return what of it is to be shown now."""
        self._held += text
        shown = ""
        while self._held:
            end = re.search(r"[\r\n]", self._held)
            beginning = _CODES.sub("", self._held)[: len(_NOTE)]
            if end is None and _NOTE.startswith(beginning):
                # Not the whole of a note. A bar is drawn as it comes.
                break
            line = self._held[: end.end()] if end else self._held
            self._held = self._held[len(line) :]
            plain = _CODES.sub("", line)
            if plain.startswith(_WARNING):
                self._warnings.append(plain.strip()[len(_WARNING) :])
            else:
                self._said.append(line)
                shown += line if not (self._unsaid and self._unsaid in plain) else ""
        return shown

    def rest(self) -> str:
        """What was held back, at the end."""
        rest, self._held = self._held, ""
        self._said.append(rest)
        return rest

    def warnings(self) -> list[str]:
        """The warnings, each without its prefix."""
        return [_ON_INPUT.sub("job", warning) for warning in self._warnings]

    def failure(self) -> str:
        """The last message, from its beginning to the end, without its prefix."""
        lines = _CODES.sub("", "".join(self._said)).replace("\r\n", "\n").split("\n")
        # Of what was drawn over a line, the last is seen.
        text = "\n".join(line.rsplit("\r", 1)[-1] for line in lines).rstrip()
        beginnings = list(_BEGINNING.finditer(text))
        if beginnings:
            text = text[beginnings[-1].end() :]
        return _ON_INPUT.sub("job", text.replace(_ADVICE, ""))


def before_failure(text: str) -> str:
    """What stands before the last message."""
    beginnings = list(_BEGINNING_AT_TERMINAL.finditer(text))
    return text[: beginnings[-1].end(1)] if beginnings else text
