"""What is raised when the program fails: a class for each of its exit codes."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._run import Run


class Error(Exception):
    """The program failed. The text is its message, whole.

    Attributes
    ----------
    exit_code : int or None
        The exit code of the program; ``None`` if it could not be started. A signal ends it with 128 and its number.
    """

    def __init__(self, message: str, exit_code: int | None = None) -> None:
        super().__init__(message)
        self.exit_code = exit_code

    def __reduce__(self) -> tuple[type[Error], tuple[str, int | None]]:
        """For other processes, as in ``multiprocessing``."""
        return type(self), (str(self), self.exit_code)


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


class Interrupted(KeyboardInterrupt):
    """Ctrl-C, after the program has kept what is finished.

    Attributes
    ----------
    run : Run or None
        The run that was interrupted: ``run.resume()`` goes on with it. ``None`` if there is nothing to go on with.
    """

    def __init__(self, message: str = "interrupted", run: Run | None = None) -> None:
        super().__init__(message)
        self.run = run

    def __reduce__(self) -> tuple[type[Interrupted], tuple[str, Run | None]]:
        """For other processes, as in ``multiprocessing``."""
        return type(self), (str(self), self.run)


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


def error_of(exit_code: int, message: str) -> Error:
    """The error for an exit code and the message of the program."""
    if exit_code == 70 and message.startswith("internal error"):
        return InternalError(message, exit_code)
    return _CLASSES.get(exit_code, Error)(message, exit_code)
