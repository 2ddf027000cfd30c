"""Jobs and parameters as Python has them, and as the program takes them."""

from __future__ import annotations

import datetime
import os
import tempfile
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, SupportsInt, Union

import tomli_w

from ._errors import job_error
from ._frames import columns_of, is_frame
from ._matrices import with_files
from ._texts import as_word, encoded

#: A path, with ``~`` for the home directory. A :class:`Run` is one, too: that of its directory.
PathLike = Union[str, "os.PathLike[str]"]
#: A job: the keys of a job spec, or the path of a TOML file.
Job = Union[Mapping[str, Any], PathLike]

#: Deepest nesting of a job. Those of the program have five levels.
_DEEPEST = 50


def expanded(path: PathLike) -> str:
    """A path as the program takes it."""
    text = os.path.expanduser(as_word(path))
    # Not an option, and not standard input.
    return os.path.join(".", text) if text.startswith("-") else text


@cache
def _passing() -> tempfile.TemporaryDirectory[str]:
    """A folder for matrices that no run keeps. It is removed when Python ends."""
    return tempfile.TemporaryDirectory(prefix="stickslip-")


def as_argument(job: Job, folder: Path | None = None) -> tuple[str, str | None]:
    """The argument for a job, and what goes to standard input. Its matrices go to files in the folder, if one is given."""
    if isinstance(job, Mapping):
        return "-", to_toml(with_files(job, folder or Path(_passing().name)))
    if isinstance(job, str) and "\n" in job:
        raise TypeError("a str is the path of a job; its text is read by tomllib.loads(text)")
    if isinstance(job, (str, os.PathLike)):
        return expanded(as_word(job, "the job")), None
    raise TypeError(f"a job is a dict or the path of a TOML file, not {type(job).__name__}")


def to_toml(job: Mapping[str, Any]) -> str:
    """A job as TOML.

    Numbers and arrays of NumPy and the like, frames of pandas and the like in place of tables with a list for each column,
    tuples, ranges and paths may stand in it.

    Raises
    ------
    TypeError
        If something else does; the message names its key.
    JobError
        If a table contains itself, or a text or a number cannot stand in TOML.
    """
    return tomli_w.dumps(_table(job, ""))


def _table(table: Mapping[Any, Any], place: str, depth: int = 0) -> dict[str, Any]:
    done = {}
    for key, value in table.items():
        if not isinstance(key, str):
            raise TypeError(f"{place or 'the job'}: the key {key!r} is not a str")
        encoded(key, f"a key of {place or 'the job'}")
        done[key] = _value(value, f"{place}.{key}" if place else key, depth + 1)
    return done


def _value(value: Any, place: str, depth: int = 0) -> Any:
    if depth > _DEEPEST:
        raise job_error(f"{place[:40]}...", f"it has more than {_DEEPEST} levels; does a part of it contain itself?")
    if isinstance(value, bool):
        return value
    if isinstance(value, int) and not -(1 << 63) <= value < 1 << 63:
        raise job_error(place, "the whole number is too large; TOML has those from -2^63 to 2^63 - 1")
    if isinstance(value, str):
        encoded(value, place)
    # Subclasses, such as numpy.float64, by their plain type.
    for plain in (int, float, str):
        if isinstance(value, plain):
            return plain(value)
    if isinstance(value, Mapping):
        return _table(value, place, depth)
    if isinstance(value, os.PathLike):
        return os.path.expanduser(as_word(value, place))
    if isinstance(value, (list, tuple, range)):
        return [_value(entry, f"{place}[{i}]", depth + 1) for i, entry in enumerate(value)]
    if is_frame(value):
        return _table(columns_of(value), place, depth)
    for method in ("tolist", "to_list"):
        if not isinstance(value, type) and hasattr(value, method):
            return _value(getattr(value, method)(), place, depth + 1)
    if isinstance(value, (datetime.date, datetime.time)):
        return value
    hint = "; leave the key out" if value is None else ""
    raise TypeError(f"{place}: {value!r} ({type(value).__name__}) has no place in a job{hint}")


def settings(parameters: Mapping[str, Any] | None, sections: Mapping[str, Any]) -> list[str]:
    """The options ``--set KEY=VALUE`` for parameters, given as nested dicts or by dotted names."""
    options = []
    for key, value in _flat({**(parameters or {}), **sections}, ""):
        options += ["--set", f"{key}={value}"]
    return options


def _flat(table: Mapping[str, Any], place: str) -> Iterator[tuple[str, str]]:
    for key, value in table.items():
        name = f"{place}.{key}" if place else key
        plain = _value(value, name)
        if isinstance(plain, dict):
            yield from _flat(plain, name)
        elif isinstance(plain, list):
            raise TypeError(f"{name}: {plain!r} is a list; one value is set here")
        else:
            yield name, str(plain).lower() if isinstance(plain, bool) else str(plain)


def whole(value: SupportsInt, name: str) -> int:
    """A whole number, which may be written as 1e5."""
    number = int(value)
    if number != value:
        raise ValueError(f"{name} = {value!r} is not a whole number")
    return number


def threads_option(threads: SupportsInt | None) -> list[str]:
    """The option for a number of threads, if one is given."""
    return [] if threads is None else [f"--threads={whole(threads, 'threads')}"]


def absolute(path: PathLike) -> Path:
    """A path that stays the same when the working directory changes."""
    return Path(os.path.abspath(os.path.expanduser(as_word(path))))
