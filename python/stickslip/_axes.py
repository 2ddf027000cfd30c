"""Results drawn into axes of matplotlib that somebody brings, for figures of their own."""

from __future__ import annotations

from collections.abc import Mapping
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

from ._grid import COLUMNS, lengths
from ._tables import described

if TYPE_CHECKING:
    import pyarrow

#: The probabilities between which colours differ.
LEVELS = [0.0, 0.01, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0]


def draw_surface(
    ax: Any, table: pyarrow.Table, at: Mapping[str, float] | None, target: float | None, title: str | None
) -> Any:
    """Draws probabilities over the axes of a surface that have several values: a line with its interval over one, filled
    contours over two. Returns what was drawn, for a legend or a colour bar."""
    import numpy

    columns = {name: table[name].to_numpy() for name in table.column_names}
    about, axes = described(table), list(lengths(table))
    # Axes by the names that they have in a job; that of standard deviations goes by the first input in which they vary.
    names = {column: name for name, column in COLUMNS.items()}
    names.update({column: "relative_std" for column in axes if column.startswith("std_")})
    by_name = {names.get(column, column): column for column in axes}
    chosen = numpy.ones(table.num_rows, dtype=bool)
    for name, value in (at or {}).items():
        column = by_name.get(name, name)
        if column not in axes:
            raise ValueError(f"at: there is no axis {name!r} (there are {', '.join(by_name)})")
        near = numpy.isclose(columns[column], value, rtol=1e-9, atol=0.0)
        if not near.any():
            there = ", ".join(f"{one:g}" for one in numpy.unique(columns[column]))
            raise ValueError(f"at: {name} = {value!r} is no value of this axis; it has {there}")
        chosen &= near
    shown = [name for name in axes if len(numpy.unique(columns[name][chosen])) > 1]
    if not 1 <= len(shown) <= 2:
        several = [names.get(column, column) for column in shown]
        hint = f"{', '.join(several)} have; choose a value with at={{{several[0]!r}: ...}}" if several else "none has"
        raise ValueError(f"a surface is drawn over one or two axes with several values: {hint}")

    def label(name: str) -> str:
        unit = about[name].get("units", "1")
        words = about[name].get("long_name", name).split(":")[0]
        return words if unit == "1" else f"{words}, {unit}"

    ax.set(xlabel=label(shown[-1]), **({} if title is None else {"title": title}))
    # The values of an axis may be listed in any order.
    rows = numpy.flatnonzero(chosen)
    rows = rows[numpy.lexsort([columns[name][rows] for name in reversed(shown)])]
    across = columns[shown[-1]][rows]
    probability = columns["p_unstable"][rows]
    if len(shown) == 1:
        ax.fill_between(across, columns["p_low"][rows], columns["p_high"][rows], alpha=0.3, linewidth=0.0)
        [line] = ax.plot(across, probability, marker=".")
        ax.set(ylabel="probability of instability", ylim=(-0.02, 1.02))
        if target is not None:
            ax.axhline(target, color="0.3", linewidth=0.8, linestyle="--")
        return line
    up = columns[shown[0]][rows]
    shape = len(numpy.unique(up)), len(numpy.unique(across))
    grids = [values.reshape(shape) for values in (across, up, probability)]
    filled = ax.contourf(*grids, levels=LEVELS)
    if target is not None:
        # Between the values, as the program does: probabilities are interpolated by their normal deviates.
        deviate = numpy.vectorize(lambda p: NormalDist().inv_cdf(min(max(p, 1e-12), 1.0 - 1e-12)), otypes=[float])
        ax.contour(*grids[:2], deviate(grids[2]), levels=deviate([target]), colors="white", linestyles="solid")
    ax.set(ylabel=label(shown[0]))
    return filled


def draw_motion(ax: Any, table: pyarrow.Table, start: float | None, end: float | None, title: str | None) -> Any:
    """Draws the tangential displacement of a motion over time. Returns the line."""
    time, displacement = (table[name].to_numpy() for name in ("time_s", "x_mm"))
    shown = (time >= (time[0] if start is None else start)) & (time <= (time[-1] if end is None else end))
    [line] = ax.plot(1e3 * time[shown], displacement[shown])
    ax.set(xlabel="time, ms", ylabel="tangential displacement, mm", **({} if title is None else {"title": title}))
    return line
