"""The name of a job, which is that of its run directory."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

from ._errors import JobError
from ._job import Job, as_argument
from ._process import call

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


def name_of(job: Job) -> str:
    """The name of a job.

    Raises
    ------
    Error
        What the program says of a job without one.
    """
    name = _table(job).get("name")
    # The program refuses what is no plain name.
    if isinstance(name, str) and name and all(c.isascii() and (c.isalnum() or c in "-_.") for c in name):
        return name
    argument, stdin = as_argument(job)
    call(["check", argument], stdin=stdin)
    raise JobError("this Python cannot read the name of the job; name the run directory with out=", 65)


def _table(job: Job) -> Mapping[str, Any]:
    if isinstance(job, Mapping):
        return job
    try:
        with open(as_argument(job)[0], "rb") as file:
            table: Mapping[str, Any] = tomllib.load(file)
            return table
    except (OSError, ValueError, RecursionError):
        # The program says what is wrong.
        return {}
