"""Probability that a brake groans or squeals: the program stickslip from Python.

>>> import stickslip
>>> run = stickslip.run("jobs/fig14a.toml")
>>> run.surface("xarray")["p_unstable"].plot()

The package carries the program and calls it. A job is a dict with the keys of a job spec, or the path of a TOML file.
"""

from __future__ import annotations

from ._bifurcation import bifurcation
from ._errors import (
    AuditError,
    CannotCreateError,
    Error,
    InputOutputError,
    InternalError,
    Interrupted,
    InUseError,
    JobError,
    JobWarning,
    ProgramNotFoundError,
    UsageError,
)
from ._motion import Motion
from ._pictures import Plot, Report
from ._process import interrupt
from ._program import package_version as _package_version
from ._program import program
from ._questions import Comparison, analyse, check, compare, fit, limit, trajectory
from ._run import Run, run

#: The version of the package, ``"unknown"`` for a source tree that is not installed.
__version__ = _package_version() or "unknown"

__all__ = [
    "AuditError",
    "CannotCreateError",
    "Comparison",
    "Error",
    "InUseError",
    "InputOutputError",
    "InternalError",
    "Interrupted",
    "JobError",
    "JobWarning",
    "Motion",
    "Plot",
    "ProgramNotFoundError",
    "Report",
    "Run",
    "UsageError",
    "analyse",
    "bifurcation",
    "check",
    "compare",
    "fit",
    "interrupt",
    "limit",
    "program",
    "run",
    "trajectory",
]
