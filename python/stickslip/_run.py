"""Runs: computing them, and what can be asked of one that exists."""

from __future__ import annotations

import html
import tempfile
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

from ._axes import draw_surface
from ._errors import CannotCreateError, InputOutputError, Interrupted, JobError, JobWarning
from ._grid import dataset
from ._job import Job, PathLike, absolute, as_argument, expanded, threads_option, whole
from ._messages import Message
from ._motion import Motion
from ._name import name_of
from ._pictures import Plot, Report, written
from ._process import call, call_json
from ._tables import Table, TableKind, converted, read

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas
    import polars
    import pyarrow
    import xarray
    from matplotlib.axes import Axes

Drawn = Literal[
    "probability",
    "sobol",
    "verdicts",
    "modes",
    "squeal-frequencies",
    "inputs",
    "samples",
    "convergence",
    "distribution",
    "friction",
]
"""What :meth:`Run.plot` draws."""


class Run:
    """A run directory. It is a path for the functions of this package and others (``os.PathLike``).

    Parameters
    ----------
    path
        The directory of a run that exists. :func:`run` makes new ones.

    Attributes
    ----------
    path : pathlib.Path
        The directory, absolute.
    output : str
        What the program printed when :func:`run` or :meth:`resume` returned this object: a picture of the surface, the
        answer in words, and how many samples were outside physics, undecided or failed. Otherwise empty.

    Raises
    ------
    InputOutputError
        If there is no run.
    """

    def __init__(self, path: PathLike) -> None:
        self.path: Path = absolute(path)
        self.output: str = ""
        if isinstance(self.status(), list):
            raise InputOutputError(f"{self.path} is a folder of runs; name one of them", 74)

    @classmethod
    def _finished(cls, path: Path, output: str) -> Run:
        """A run that the program has just written."""
        run = cls.__new__(cls)
        run.path, run.output = path, output
        return run

    def __repr__(self) -> str:
        return f"stickslip.Run({str(self.path)!r})"

    def __fspath__(self) -> str:
        return str(self.path)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Run) and self.path == other.path

    def __hash__(self) -> int:
        return hash(self.path)

    def _repr_html_(self) -> str:
        """In a notebook: what the program printed, if there is any."""
        text = html.escape(self.output.rstrip() or repr(self))
        return f'<pre style="line-height: 1.15">{text}</pre>'

    def status(self) -> dict[str, Any]:
        """How far the run is: ``state``, ``samples_done``, ``share_done`` and the other keys of ``status --json``."""
        status: dict[str, Any] = call_json(["status", self.path])
        return status

    def resume(self, *, threads: int | None = None, progress: bool = True) -> Run:
        """Continue the run where it was interrupted. A finished one computes nothing.

        Raises
        ------
        InUseError
            If another process works in it.
        Interrupted
            With Ctrl-C. What was finished is kept.
        """
        try:
            output = call(["resume", *threads_option(threads), self.path], progress=progress)
        except Interrupted as interrupted:
            interrupted.run = self
            raise
        return Run._finished(self.path, output)

    @overload
    def surface(self, kind: Literal["pandas"] = "pandas") -> pandas.DataFrame: ...
    @overload
    def surface(self, kind: Literal["polars"]) -> polars.DataFrame: ...
    @overload
    def surface(self, kind: Literal["arrow"]) -> pyarrow.Table: ...
    @overload
    def surface(self, kind: Literal["xarray"]) -> xarray.Dataset: ...
    def surface(self, kind: str = "pandas") -> Any:
        """The result, one row for each cell.

        Parameters
        ----------
        kind
            ``"pandas"``, ``"polars"``, ``"arrow"``, or ``"xarray"`` for a dataset over the axes of the job: those with
            several values are its dimensions, slowest first. Units and meanings of the columns are attributes of its
            variables, ``attrs["units"]`` and ``attrs["long_names"]`` of a DataFrame of pandas, and metadata of the
            fields of a table of Arrow.

        Raises
        ------
        FileNotFoundError
            If the run is not finished.
        InputOutputError
            If the file is not as it was written.
        """
        table = self._table("surface.parquet")
        return dataset(table) if kind == "xarray" else converted(table, kind)

    @overload
    def limits(self, kind: Literal["pandas"] = "pandas") -> pandas.DataFrame: ...
    @overload
    def limits(self, kind: Literal["polars"]) -> polars.DataFrame: ...
    @overload
    def limits(self, kind: Literal["arrow"]) -> pyarrow.Table: ...
    def limits(self, kind: TableKind = "pandas") -> Table:
        """The limits that the job's ``[limit]`` asks for. :func:`limit` finds others.

        Raises
        ------
        FileNotFoundError
            If the job asks for none, or the run is not finished.
        """
        return converted(self._table("limits.parquet", "its job has no [limit], or it is not finished"), kind)

    @overload
    def samples(
        self, cell: int, kind: Literal["pandas"] = "pandas", *, threads: int | None = None, progress: bool = True
    ) -> pandas.DataFrame: ...
    @overload
    def samples(
        self, cell: int, kind: Literal["polars"], *, threads: int | None = None, progress: bool = True
    ) -> polars.DataFrame: ...
    @overload
    def samples(
        self, cell: int, kind: Literal["arrow"], *, threads: int | None = None, progress: bool = True
    ) -> pyarrow.Table: ...
    def samples(
        self, cell: int, kind: TableKind = "pandas", *, threads: int | None = None, progress: bool = True
    ) -> Table:
        """Every sample of one cell: its random inputs as drawn, and its verdict. They are computed once more.

        Parameters
        ----------
        cell
            The cell, as in the column ``cell``.
        """
        with tempfile.TemporaryDirectory(prefix="stickslip-") as folder:
            file = Path(folder) / "samples.parquet"
            arguments = [
                "samples",
                str(self.path),
                f"--cell={whole(cell, 'cell')}",
                f"--out={file}",
                *threads_option(threads),
            ]
            call(arguments, progress=progress, unsaid="file-written")
            return converted(read(file), kind)

    def replay(self, cell: int, sample: int, *, horizon: float | None = None) -> Motion:
        """Simulate one sample of the run again, bit for bit.

        Parameters
        ----------
        cell, sample
            The cell, and the number of the sample in it, both from 0.
        horizon
            Scaled time to simulate, 500 by default.
        """
        arguments = ["replay", str(self.path), f"--cell={whole(cell, 'cell')}", f"--sample={whole(sample, 'sample')}"]
        if horizon is not None:
            arguments.append(f"--horizon={float(horizon)!r}")
        return Motion._simulated(arguments)

    def verify(self) -> dict[str, Any]:
        """Check every file of the run, and write again what can be: ``state``, and a list of ``files``.

        Raises
        ------
        InputOutputError
            If something is lost. The message says how to get it back.
        JobError
            If files are gone that the job names, such as its matrices.
        """
        findings: dict[str, Any] = call_json(["verify", self.path])
        return findings

    def export(self, format: Literal["csv", "json", "mat", "npz"], out: PathLike | None = None) -> Path:
        """Write the surface for another program. Returns the path of the file.

        Parameters
        ----------
        out
            The file; by default ``surface.FORMAT`` in the run directory.
        """
        arguments = ["export", str(self.path), f"--format={format}"]
        if out is not None:
            arguments.append(f"--out={absolute(out)}")
        return written(call(arguments))[0]

    @overload
    def plot(
        self,
        *,
        of: Drawn | None = None,
        cell: int | None = None,
        result: str | None = None,
        x: str | None = None,
        y: str | None = None,
        samples: int | None = None,
        at: Mapping[str, float] | None = None,
        target: float | None = None,
        title: str | None = None,
        against: PathLike | None = None,
        columns: Literal[1, 2] | None = None,
        out: PathLike | None = None,
        threads: int | None = None,
        ax: None = None,
    ) -> Plot: ...
    @overload
    def plot(
        self,
        *,
        at: Mapping[str, float] | None = None,
        target: float | None = None,
        title: str | None = None,
        ax: Axes,
    ) -> Any: ...
    def plot(
        self,
        *,
        of: Drawn | None = None,
        cell: int | None = None,
        result: str | None = None,
        x: str | None = None,
        y: str | None = None,
        samples: int | None = None,
        at: Mapping[str, float] | None = None,
        target: float | None = None,
        title: str | None = None,
        against: PathLike | None = None,
        columns: Literal[1, 2] | None = None,
        out: PathLike | None = None,
        threads: int | None = None,
        ax: Axes | None = None,
    ) -> Any:
        """Draw the surface, or something else of the run.

        Parameters
        ----------
        of
            What to draw: ``"probability"`` by default.
        cell
            The cell of what is drawn of one cell.
        result
            With ``of="sobol"`` and ``"distribution"``, the recorded result, for example ``"critical_speed"``.
        x, y
            With ``of="samples"``, the random inputs or recorded results that run across and up.
        samples
            With ``of="samples"`` and ``"convergence"``, how many samples to draw.
        at
            Values of axes of which one is shown alone, for example ``{"rotating_speed": 15.0}``.
        target
            Draw the line of this probability.
        title
            What to write above the figure.
        against
            Another run: draw the probabilities of this one minus those of the other.
        columns
            Columns of a paper that the figure fills: 1 is 84 mm wide, 2 (the default) are 174 mm.
        out
            One file, SVG, PDF or PNG by its name; by default SVG and PNG in the run directory.
        ax
            Axes of matplotlib, into which the probability is drawn with it and not by the program: over one axis a line with
            its interval, over two filled contours. Takes ``at``, ``target`` and ``title`` besides.

        Returns
        -------
        Plot
            It shows itself in a notebook, and has the paths of the files. With ``ax``, what matplotlib drew: the line, or the
            contours, for a colour bar.
        """
        if ax is not None:
            others = (of, cell, result, x, y, samples, against, columns, out, threads)
            if any(other is not None for other in others):
                raise TypeError("with ax= the probability is drawn, and only at, target and title go with it")
            return draw_surface(ax, self._table("surface.parquet"), at, target, title)
        arguments = ["plot", str(self.path), *threads_option(threads)]
        if against is not None:
            arguments.append(f"--against={expanded(against)}")
        options: dict[str, object] = {"of": of, "cell": cell, "result": result, "x": x, "y": y, "samples": samples}
        options |= {"target": target, "title": title, "columns": columns}
        arguments += [f"--{name}={value}" for name, value in options.items() if value is not None]
        arguments += [f"--at={axis}={value}" for axis, value in (at or {}).items()]
        if out is not None:
            arguments.append(f"--out={absolute(out)}")
        return Plot._of(written(call(arguments)))

    def report(
        self,
        out: PathLike | None = None,
        *others: PathLike,
        target: float | None = None,
        at: Mapping[str, float] | None = None,
    ) -> Report:
        """Write a report: one HTML file with the answer, an interactive map and the job.

        Parameters
        ----------
        out
            The file; by default ``report.html`` in the run directory.
        others
            Further runs, each compared with this one. ``out`` must be given then.
        target
            Say first whether the probability is below this one, in place of the job's ``[target]``.
        at
            The operating point of which the report speaks first, for example ``{"rotating_speed": 15.0}``: a value of each
            axis of several values.

        Returns
        -------
        Report
            It has the path of the file, and is a link in a notebook.
        """
        runs = map(expanded, (self, *others))
        file = [] if out is None else [f"--out={absolute(out)}"]
        asked = [] if target is None else [f"--target={target}"]
        asked += [f"--at={axis}={value}" for axis, value in (at or {}).items()]
        return Report(written(call(["report", *runs, *file, *asked]))[0])

    def _table(self, name: str, why: str = "it is gone") -> pyarrow.Table:
        """A result of the run, if the program says that it is finished and as it was written."""
        state = self.status()["state"]
        if state == "surface damaged":
            raise InputOutputError(f"{self.path / name}: {state}; verify() writes it again", 74)
        if state != "finished":
            remedy = "wait for the process that computes it" if state == "running" else "resume() it"
            raise FileNotFoundError(f"{self.path} has no {name} yet: the run is not finished ({state}); {remedy}")
        path = self.path / name
        if not path.is_file():
            raise FileNotFoundError(f"{self.path} has no {name}: {why}")
        return read(path)


def run(
    job: Job,
    out: PathLike | None = None,
    progress: bool = True,
    *,
    threads: int | None = None,
    samples: int | None = None,
    seed: int | None = None,
    resume: bool = True,
    overwrite: bool = False,
) -> Run:
    """Run a job.

    A run of the same job in the same directory counts: a finished one is returned as it is, one with fewer samples gets
    those that are missing, and one that was interrupted is continued. The result is the same, bit for bit. One with more
    samples is returned with all of them, and with a :class:`JobWarning`.

    Parameters
    ----------
    job
        The keys of a job spec as a dict, or the path of a TOML file.
    out
        The run directory. By default it is ``runs/NAME`` in the working directory, with the name of the job; where that
        has a run of another job, ``runs/NAME-DIGEST``, with a digest of this one. So a loop over jobs of one name keeps
        the runs of all.
    progress
        Whether progress and notes are shown on ``sys.stderr``.
    threads
        All processors by default. The result does not depend on them.
    samples, seed
        In place of those of the job.
    resume
        ``False``: an unfinished run is not continued, but refused with :class:`CannotCreateError`.
    overwrite
        ``True``: the run that the directory has, of whatever job, is removed with its figures and reports, and the job
        is computed anew. Then the default directory is always ``runs/NAME``.

    Raises
    ------
    JobError
        If the job is not valid, or the directory ``out`` has a run of another one.
    CannotCreateError, InputOutputError, InUseError
        If the directory cannot be made, written to, or is in use.
    AuditError
        If the result is written, but its audit failed.
    Interrupted
        With Ctrl-C, a ``KeyboardInterrupt``. What was finished is kept: ``interrupted.run.resume()``.
    """
    directory = absolute(out if out is not None else Path("runs") / name_of(job))
    argument, stdin = as_argument(job, directory.parent / ".matrices")
    options = [*threads_option(threads), f"--out={directory}"]
    if overwrite:
        options.append("--overwrite")
    elif out is None:
        options.append("--apart")
    for name, value in (("samples", samples), ("seed", seed)):
        if value is not None:
            options.append(f"--{name}={whole(value, name)}")

    def heard(message: Message) -> None:
        nonlocal directory
        if message.code == "run-apart" and message.place is not None:
            # A path that cannot be shown is in quotes; the name of a job holds none.
            directory = directory.with_name(Path(message.place["file"]).name.rstrip("'"))

    def submit() -> str:
        return call(["submit", argument, *options], stdin=stdin, progress=progress, heard=heard)

    def go_on() -> str:
        return Run._finished(directory, "").resume(threads=threads, progress=progress).output

    try:
        try:
            output = submit()
        except CannotCreateError as error:
            if not resume or error.code not in ("run-unfinished", "run-to-extend"):
                raise
            output = go_on()
            if error.code == "run-to-extend":
                output = submit()
        except JobError as error:
            if error.code != "run-has-more":
                raise
            if not resume and Run._finished(directory, "").status()["state"] != "finished":
                raise
            warnings.warn(f"{error}. The run is returned with all its samples", JobWarning, stacklevel=2)
            output = go_on()
    except Interrupted as interrupted:
        interrupted.run = Run._finished(directory, "") if (directory / "job.toml").is_file() else None
        raise
    return Run._finished(directory, output)
