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

from ._matrices import with_files

#: A path, with ``~`` for the home directory. A :class:`Run` is one, too: that of its directory.
PathLike = Union[str, "os.PathLike[str]"]
#: A job: the keys of a job spec, or the path of a TOML file.
Job = Union[Mapping[str, Any], PathLike]


def expanded(path: PathLike) -> str:
    """A path as the program takes it."""
    text = os.path.expanduser(os.fspath(path))
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
        return expanded(job), None
    raise TypeError(f"a job is a dict or the path of a TOML file, not {type(job).__name__}")


def to_toml(job: Mapping[str, Any]) -> str:
    """A job as TOML.

    Numbers and arrays of NumPy and the like, tuples, ranges and paths may stand in it.

    Raises
    ------
    TypeError
        If something else does; the message names its key.
    """
    return tomli_w.dumps(_table(job, ""))


def _table(table: Mapping[Any, Any], place: str) -> dict[str, Any]:
    done = {}
    for key, value in table.items():
        if not isinstance(key, str):
            raise TypeError(f"{place or 'the job'}: the key {key!r} is not a str")
        done[key] = _value(value, f"{place}.{key}" if place else key)
    return done


def _value(value: Any, place: str) -> Any:
    if isinstance(value, bool):
        return value
    # Subclasses, such as numpy.float64, by their plain type.
    for plain in (int, float, str):
        if isinstance(value, plain):
            return plain(value)
    if isinstance(value, Mapping):
        return _table(value, place)
    if isinstance(value, os.PathLike):
        return os.path.expanduser(os.fspath(value))
    if isinstance(value, (list, tuple, range)):
        return [_value(entry, f"{place}[{i}]") for i, entry in enumerate(value)]
    for method in ("tolist", "to_list"):
        if not isinstance(value, type) and hasattr(value, method):
            return _value(getattr(value, method)(), place)
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
    return Path(os.path.abspath(os.path.expanduser(os.fspath(path))))
