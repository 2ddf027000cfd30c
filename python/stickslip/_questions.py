"""Questions that need no run: checks, one brake, limits, comparisons and estimates from tests."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Union, overload

from ._errors import Error
from ._job import Job, PathLike, absolute, as_argument, expanded, settings, threads_option, whole
from ._motion import Motion
from ._process import call, call_json
from ._rows import csv_of
from ._tables import Table, TableKind, converted, read
from ._texts import encoded

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow

#: Tests of brakes: the path of a CSV file, a DataFrame of pandas or polars, a table of pyarrow, a dict of columns, or a
#: dict for each row.
Tests = Union[
    PathLike, "pandas.DataFrame", "polars.DataFrame", "pyarrow.Table", Mapping[str, Any], Iterable[Mapping[str, Any]]
]
#: What `fit` can estimate.
Estimate = Literal["static_friction", "preload_factor", "std.preload", "std.static_friction", "correlation"]


def check(job: Job, *, threads: int | None = None) -> dict[str, Any]:
    """Validate a job, and predict what it will cost. The cost is measured, which takes some seconds, ten at most.

    Returns
    -------
    dict
        The keys of ``check --json``: ``cells``, ``samples_at_most``, ``seconds`` of the whole run (``None`` where
        ``not_known_because`` says why), ``job`` (the job as TOML with every default filled in) and others.

    Raises
    ------
    JobError
        If the job is not valid. The message has all errors.
    """
    argument, stdin = as_argument(job)
    answer: dict[str, Any] = call_json(["check", argument, *threads_option(threads)], stdin=stdin)
    return answer


def analyse(
    brake: Mapping[str, Any] | PathLike | None = None,
    /,
    *,
    job: Job | None = None,
    cell: int | None = None,
    **sections: Any,
) -> dict[str, Any]:
    """Analyse one brake at one operating point.

    >>> stickslip.analyse("belt.toml", belt_speed=1.2)["stable"]

    Parameters
    ----------
    brake
        A job or a run whose brake is taken in place of the preset, as ``job``; or values that differ, as ``sections``. A
        dict is a job if it has a criterion.
    sections
        Values that differ from those of the preset, or of the job: nested, ``friction={"static_coefficient": 0.45}``,
        or by dotted names, ``{"friction.static_coefficient": 0.45}``; of other models the names of their parameters.
    job
        The job, where ``brake`` has values that differ.
    cell
        The cell of the job whose expected values are taken; by default the one in the middle.

    Returns
    -------
    dict
        The keys of ``analyse --json``: ``stable``, ``critical_speed_rad_s``, ``eigenvalues``, ``limit_cycle``,
        ``parameters`` and others. A name that ends in a unit is in that unit, all others are scaled. What does not
        exist for this brake is ``None``.
    """
    options, stdin = _brake(brake, job, cell, sections)
    answer: dict[str, Any] = call_json(["analyse", *options], stdin=stdin)
    return answer


def trajectory(
    brake: Mapping[str, Any] | PathLike | None = None,
    /,
    *,
    job: Job | None = None,
    cell: int | None = None,
    disc: Literal["rigid", "flexible", "finite-difference"] | None = None,
    disc_modes: int | None = None,
    grid: str | None = None,
    allotment: Literal["nodal", "linear"] | None = None,
    start: str | Mapping[str, float] | None = None,
    displacement: float | None = None,
    horizon: float | None = None,
    **sections: Any,
) -> Motion:
    """Simulate one motion in time.

    Parameters
    ----------
    brake, sections, job, cell
        As for :func:`analyse`.
    disc
        ``"flexible"`` unless the job says otherwise.
    disc_modes
        How many modes of the flexible disc are kept.
    grid, allotment
        Of a finite-difference disc: radial intervals and elements under the pad, ``"8x8"``, and how the load moves.
    start
        ``"near-equilibrium"``, ``"rest"``, ``"limit-cycle"``, or numbers, ``{"velocity": 0.3}`` in m/s.
    displacement
        Of a start near the equilibrium, over the equilibrium's own.
    horizon
        Scaled time to simulate, 500 by default.
    """
    options, stdin = _brake(brake, job, cell, sections)
    if isinstance(start, Mapping):
        start = ",".join(f"{key}={_start_value(value)}" for key, value in start.items())
    for name, value in (
        ("disc", disc),
        ("disc-modes", disc_modes),
        ("grid", grid),
        ("allotment", allotment),
        ("start", start),
        ("displacement", displacement),
        ("horizon", horizon),
    ):
        if value is not None:
            options.append(f"--{name}={value}")
    return Motion._simulated(["trajectory", *options], stdin)


@overload
def limit(
    job: Job,
    of: str | None = None,
    probability: float | Sequence[float] | None = None,
    kind: Literal["pandas"] = "pandas",
    *,
    threads: int | None = None,
    progress: bool = True,
) -> pandas.DataFrame: ...
@overload
def limit(
    job: Job,
    of: str | None = None,
    probability: float | Sequence[float] | None = None,
    *,
    kind: Literal["polars"],
    threads: int | None = None,
    progress: bool = True,
) -> polars.DataFrame: ...
@overload
def limit(
    job: Job,
    of: str | None = None,
    probability: float | Sequence[float] | None = None,
    *,
    kind: Literal["arrow"],
    threads: int | None = None,
    progress: bool = True,
) -> pyarrow.Table: ...
def limit(
    job: Job,
    of: str | None = None,
    probability: float | Sequence[float] | None = None,
    kind: TableKind = "pandas",
    *,
    threads: int | None = None,
    progress: bool = True,
) -> Table:
    """Find the largest or smallest value of an axis at which the probability of instability is at most a target.

    Parameters
    ----------
    job
        A job or a run. It needs no run.
    of
        The axis, for example ``"preload"``; by default that of the job's ``[limit]``.
    probability
        The target, or several; by default those of the job's ``[limit]``.

    Returns
    -------
    table
        A row for each limit: the combination of the other axes, ``target``, ``state``, ``limit`` with ``limit_low`` and
        ``limit_high``, and the probabilities at both ends of the axis.
    """
    argument, stdin = as_argument(job)
    options = [*threads_option(threads), *([] if of is None else [f"--of={of}"])]
    targets = [probability] if not isinstance(probability, Iterable) else probability
    options += [f"--probability={float(target)!r}" for target in targets if target is not None]
    return _table(["limit", argument, *options], stdin, kind, progress)


class Comparison:
    """What :func:`compare` finds.

    Attributes
    ----------
    summary : list of dict
        For each further run the keys of ``compare --json``: ``mean_difference``, ``largest``,
        ``cells_significantly_higher`` and others.
    """

    def __init__(self, summary: list[dict[str, Any]], cells: pyarrow.Table) -> None:
        self.summary = summary
        self._cells = cells

    @overload
    def table(self, kind: Literal["pandas"] = "pandas") -> pandas.DataFrame: ...
    @overload
    def table(self, kind: Literal["polars"]) -> polars.DataFrame: ...
    @overload
    def table(self, kind: Literal["arrow"]) -> pyarrow.Table: ...
    def table(self, kind: TableKind = "pandas") -> Table:
        """A row for each pair of runs and cell: ``p_first``, ``p_second``, ``difference`` with its interval."""
        return converted(self._cells, kind)


def compare(
    first: PathLike,
    *others: PathLike,
    confidence: float | None = None,
    pointwise: bool = False,
    threads: int | None = None,
    progress: bool = True,
) -> Comparison:
    """Compare finished runs with the first one.

    Parameters
    ----------
    confidence
        Of the intervals of the differences, 0.95 by default, all of them together.
    pointwise
        Intervals that hold for each cell by itself.
    """
    options = [*threads_option(threads), *(["--pointwise"] if pointwise else [])]
    if confidence is not None:
        options.append(f"--confidence={float(confidence)!r}")
    runs = map(expanded, (first, *others))
    with tempfile.TemporaryDirectory(prefix="stickslip-") as folder:
        file = Path(folder) / "compare.parquet"
        summary = call_json(["compare", *runs, *options, f"--out={file}"], progress=progress, unsaid="file-written")
        return Comparison(summary, read(file))


def fit(
    data: Tests,
    job: Job,
    *,
    estimate: Sequence[Estimate] | None = None,
    out: PathLike | None = None,
    plot: PathLike | None = None,
) -> dict[str, Any]:
    """Estimate friction, its scatter and that of the preload from tests of brakes.

    Parameters
    ----------
    data
        A CSV file of tests, or the tests themselves: a DataFrame of pandas or polars, a table of pyarrow, a dict of
        columns, or a list with a dict for each row. The columns are those of the file, ``squealed`` and ``censored``
        may be bools. Messages call such tests ``data`` and count lines as in a file: line 2 is the first row.
    job
        The job whose brake was tested.
    estimate
        What is estimated; ``["static_friction", "std.static_friction"]`` by default.
    out
        A new file for the job with the estimates in place.
    plot
        A file, SVG, PDF or PNG, for a picture of the tests and the fit.

    Returns
    -------
    dict
        The keys of ``fit --json``: ``estimates`` by parameter, each with ``value``, ``low`` and ``high``, ``cells``
        with predicted probabilities, and others. ``data`` is ``None`` for tests that are not in a file.
    """
    argument, stdin = as_argument(job)
    options = [] if estimate is None else [f"--estimate={','.join(estimate)}"]
    if out is not None:
        options.append(f"--out={absolute(out)}")
    if plot is not None:
        options.append(f"--plot={absolute(plot)}")
    ask = partial(call_json, stdin=stdin)
    if isinstance(data, (str, os.PathLike)):
        answer: dict[str, Any] = ask(["fit", expanded(data), f"--job={argument}", *options])
        return answer
    text = encoded(csv_of(data), "data")
    with tempfile.TemporaryDirectory(prefix="stickslip-") as folder:
        file = Path(folder) / "data.csv"
        file.write_bytes(text)
        try:
            answer = ask(["fit", file, f"--job={argument}", *options])
        except Error as error:
            # The file is gone when the message is read.
            error.args = (str(error).replace(str(file), "data"),)
            if error.place is not None and error.place.get("file") == str(file):
                error.place = {**error.place, "file": "data"}
            raise
    answer["data"] = None
    if out is not None:
        # The job says where its estimates come from.
        written = absolute(out).read_text(encoding="utf-8")
        first, rest = written.split("\n", 1)
        absolute(out).write_text(first.replace(f'"{file}"', "of a Python session") + "\n" + rest, encoding="utf-8")
    return answer


def _brake(
    brake: Mapping[str, Any] | PathLike | None, job: Job | None, cell: int | None, sections: Mapping[str, Any]
) -> tuple[list[str], str | None]:
    """The options that say which brake."""
    options, stdin = [], None
    parameters = brake if isinstance(brake, Mapping) and "criterion" not in brake else None
    if brake is not None and parameters is None:
        if job is not None:
            raise TypeError("a job is given twice: as the first argument, and as job=")
        job = brake
    if job is not None:
        argument, stdin = as_argument(job)
        options.append(f"--job={argument}")
    if cell is not None:
        options.append(f"--cell={whole(cell, 'cell')}")
    return [*options, *settings(parameters, sections)], stdin


def _table(arguments: Sequence[str], stdin: str | None, kind: str, progress: bool) -> Table:
    """The table that a command writes."""
    with tempfile.TemporaryDirectory(prefix="stickslip-") as folder:
        file = Path(folder) / "table.parquet"
        call([*arguments, f"--out={file}"], stdin=stdin, progress=progress, unsaid="file-written")
        return converted(read(file), kind)


def _start_value(value: Any) -> str:
    return value if isinstance(value, str) else str(value).lower() if isinstance(value, bool) else repr(float(value))
