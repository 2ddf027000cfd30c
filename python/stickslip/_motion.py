"""Motions: what `trajectory` and `replay` simulate."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

from ._axes import draw_motion
from ._job import PathLike, absolute
from ._pictures import Plot, written
from ._process import call
from ._tables import Table, TableKind, converted, read

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow
    from matplotlib.axes import Axes


class Motion:
    """One motion of pad and disc.

    Attributes
    ----------
    summary : dict
        What it settles to, with the keys of ``trajectory --json`` or ``replay --json``: ``verdict``, ``amplitude``,
        ``frequency_hz`` and others. A name that ends in a unit is in that unit, all others are scaled.
    """

    def __init__(self, summary: dict[str, Any], folder: tempfile.TemporaryDirectory[str]) -> None:
        self.summary = summary
        # The time series is in a file, which goes with this object.
        self._folder = folder

    @classmethod
    def _simulated(cls, arguments: Sequence[str], stdin: str | None = None) -> Motion:
        """Run `trajectory` or `replay`."""
        folder = tempfile.TemporaryDirectory(prefix="stickslip-")
        text = call([*arguments, "--json", f"--out={Path(folder.name) / 'motion.parquet'}"], stdin=stdin)
        summary = json.loads(text)
        summary.pop("file", None)
        return cls(summary, folder)

    @property
    def _file(self) -> Path:
        file = Path(self._folder.name) / "motion.parquet"
        if not file.is_file():
            raise FileNotFoundError("this sample has no motion: it was not simulated")
        return file

    def __repr__(self) -> str:
        return f"stickslip.Motion({', '.join(f'{key}={value!r}' for key, value in self._shown().items())})"

    def _shown(self) -> dict[str, Any]:
        keys = ("verdict", "amplitude_mm", "frequency_hz", "stick_fraction")
        return {key: self.summary[key] for key in keys if key in self.summary}

    @overload
    def table(self, kind: Literal["pandas"] = "pandas") -> pandas.DataFrame: ...
    @overload
    def table(self, kind: Literal["polars"]) -> polars.DataFrame: ...
    @overload
    def table(self, kind: Literal["arrow"]) -> pyarrow.Table: ...
    def table(self, kind: TableKind = "pandas") -> Table:
        """The time series, one row for each moment: ``time_s``, ``x_mm``, ``contact_force_n`` and others.

        Raises
        ------
        FileNotFoundError
            If the sample was not simulated, as of a job whose criterion is an eigenvalue.
        """
        return converted(read(self._file), kind)

    @overload
    def plot(
        self,
        *,
        start: float | None = None,
        end: float | None = None,
        title: str | None = None,
        columns: Literal[1, 2] | None = None,
        out: PathLike | None = None,
        ax: None = None,
    ) -> Plot: ...
    @overload
    def plot(
        self,
        *,
        start: float | None = None,
        end: float | None = None,
        title: str | None = None,
        ax: Axes,
    ) -> Any: ...
    def plot(
        self,
        *,
        start: float | None = None,
        end: float | None = None,
        title: str | None = None,
        columns: Literal[1, 2] | None = None,
        out: PathLike | None = None,
        ax: Axes | None = None,
    ) -> Any:
        """Draw displacements, friction and contact force over time, the phase portrait, and the spectrum.

        Parameters
        ----------
        start, end
            Draw the motion from and up to these times, in seconds; by default all of it.
        title
            What to write above the figure.
        columns
            Columns of a paper that the figure fills, 2 by default.
        out
            One file, SVG, PDF or PNG by its name. By default SVG and PNG are drawn into a temporary folder, which is deleted with
            this object.
        ax
            Axes of matplotlib, into which the tangential displacement is drawn over time, with it and not by the program. Takes
            ``start``, ``end`` and ``title`` besides; what matplotlib drew is returned.
        """
        if ax is not None:
            if columns is not None or out is not None:
                raise TypeError("with ax= only start, end and title are given")
            return draw_motion(ax, self.table("arrow"), start, end, title)
        given = {"from": start, "to": end, "title": title, "columns": columns}
        options = [f"--{name}={value}" for name, value in given.items() if value is not None]
        if out is not None:
            options.append(f"--out={absolute(out)}")
        plot = Plot._of(written(call(["plot", self._file, *options])))
        plot._source = self._folder
        return plot
