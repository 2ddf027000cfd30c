"""Texts of Python that no file and no program can be given: halves of characters, and in names NUL."""

from __future__ import annotations

import os

from ._errors import UsageError, job_error


def encoded(text: str, what: str) -> bytes:
    """A text in UTF-8.

    Raises
    ------
    JobError
        If it holds half of a character; the message says what the text is.
    """
    try:
        return text.encode()
    except UnicodeEncodeError as error:
        half = f"{text[error.start]!r} at character {error.start + 1}"
        raise job_error(what, f"{half} is a lone surrogate, which UTF-8 cannot hold; give whole characters") from None


def as_word(word: str | os.PathLike[str], of_job: str = "") -> str:
    """A word of a command line, such as a path.

    Raises
    ------
    JobError
        If no program can be given it, and it is this place of a job.
    UsageError
        The same for other words.
    """
    text = os.fspath(word)
    try:
        os.fsencode(text)
        odd = "the character NUL; leave it out" if "\0" in text else None
    except UnicodeEncodeError:
        odd = "a lone surrogate; give whole characters"
    if odd is None:
        return text
    why = f"{text!r} holds what no name can, {odd}"
    raise job_error(of_job, why) if of_job else UsageError(why, 64)
