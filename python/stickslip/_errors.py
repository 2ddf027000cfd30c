"""What is raised when the program fails: a class for each of its exit codes."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol


class Unfinished(Protocol):
    """What an interrupted run can do: a :class:`Run`."""

    path: Path

    def status(self) -> dict[str, Any]:
        """How far it is."""

    def resume(self, *, threads: int | None = None, progress: bool = True) -> Any:
        """Continue it."""


class _Details:
    """What the program says of a failure beside its text.

    Attributes
    ----------
    code : str or None
        What it is about, a word such as ``"job-spec"`` or ``"run-in-use"``. Decide by it. The program documents them
        under "Messages for programs"; ``None`` if the program did not say.
    place : dict or None
        Where it is, as far as it is known: ``file``, ``line``, ``column`` and ``key``.
    remedy : str or None
        The command, option or action that helps, if one is named.
    """

    code: str | None = None
    place: dict[str, Any] | None = None
    remedy: str | None = None


class Error(_Details, Exception):
    """The program failed. The text is its message, whole.

    Attributes
    ----------
    exit_code : int or None
        The exit code of the program; ``None`` if it could not be started. A signal ends it with 128 and its number.
    code, place, remedy
        What the message is about, where, and what helps.
    """

    def __init__(self, message: str, exit_code: int | None = None) -> None:
        super().__init__(message)
        self.exit_code = exit_code


class UsageError(Error):
    """An argument asks for something that does not exist (64)."""


class JobError(Error):
    """The job is not valid, differs from the run's, or the run is not complete (65)."""


class AuditError(Error):
    """The result is written, but the audit found its verdict map wrong somewhere (70)."""


class InternalError(Error):
    """The program itself failed (70). Please report it."""


class CannotCreateError(Error):
    """The output cannot be created, or its directory holds an unfinished run (73)."""


class InputOutputError(Error):
    """Reading or writing failed, or the system refused memory, a thread or an open file (74)."""


class InUseError(Error):
    """Another process works in the run directory (75)."""


class ProgramNotFoundError(Error):
    """There is no program that belongs to this package."""


class Interrupted(_Details, KeyboardInterrupt):
    """Ctrl-C, after the program has kept what is finished.

    Attributes
    ----------
    run : Run or None
        The run that was interrupted: ``run.resume()`` goes on with it. ``None`` if there is nothing to go on with.
    code, place, remedy
        As of an :class:`Error`.
    """

    def __init__(self, message: str = "interrupted", run: Unfinished | None = None) -> None:
        super().__init__(message)
        self.run = run


class JobWarning(UserWarning):
    """A warning of the program, such as of a value that no brake has."""


_CLASSES: dict[int, type[Error]] = {
    64: UsageError,
    65: JobError,
    70: AuditError,
    73: CannotCreateError,
    74: InputOutputError,
    75: InUseError,
}


def error_of(exit_code: int, message: str, code: str | None) -> Error:
    """The error for an exit code and the message of the program."""
    kind = InternalError if exit_code == 70 and code == "internal-error" else _CLASSES.get(exit_code, Error)
    return kind(message, exit_code)


def job_error(place: str, text: str) -> JobError:
    """The error of a job that is wrong in a place, which no program need read to find it."""
    error = JobError(f"{place}: {text}", 65)
    error.code, error.place = "job-spec", {"file": "job", "key": place}
    return error
