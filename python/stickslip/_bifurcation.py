"""The bifurcation diagram of one brake: steady sliding and the limit cycle over a parameter."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, overload

from ._job import Job
from ._questions import analyse
from ._tables import Table, TableKind, converted

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow

#: What is taken of each point: column, where it is in the answer of `analyse`, and what it means.
_TAKEN = [
    ("x", ("equilibrium", "x"), "tangential displacement in steady sliding"),
    ("x_min", ("limit_cycle", "x_min"), "smallest tangential displacement on the limit cycle"),
    ("x_max", ("limit_cycle", "x_max"), "largest tangential displacement on the limit cycle"),
    ("period", ("limit_cycle", "period"), "period of the limit cycle"),
    ("stick_fraction", ("limit_cycle", "stick_fraction"), "share of the period in stick"),
]

#: Units and meanings of the parameters that are mostly followed; others are in SI units.
_FOLLOWED = {
    "rotating_speed": ("rad/s", "rotating speed of the disc"),
    "belt_speed": ("m/s", "speed of the belt"),
    "normal_force": ("N", "normal force"),
    "preload": ("1", "displacement of the calliper over disc thickness"),
    "static_friction": ("1", "static friction coefficient"),
    "static_coefficient": ("1", "static friction coefficient"),
}


@overload
def bifurcation(
    along: str,
    values: Iterable[float],
    parameters: Mapping[str, Any] | None = None,
    kind: Literal["pandas"] = "pandas",
    *,
    job: Job | None = None,
    cell: int | None = None,
) -> pandas.DataFrame: ...
@overload
def bifurcation(
    along: str,
    values: Iterable[float],
    parameters: Mapping[str, Any] | None = None,
    *,
    kind: Literal["polars"],
    job: Job | None = None,
    cell: int | None = None,
) -> polars.DataFrame: ...
@overload
def bifurcation(
    along: str,
    values: Iterable[float],
    parameters: Mapping[str, Any] | None = None,
    *,
    kind: Literal["arrow"],
    job: Job | None = None,
    cell: int | None = None,
) -> pyarrow.Table: ...
def bifurcation(
    along: str,
    values: Iterable[float],
    parameters: Mapping[str, Any] | None = None,
    kind: TableKind = "pandas",
    *,
    job: Job | None = None,
    cell: int | None = None,
) -> Table:
    """Follow steady sliding and the limit cycle over a parameter, of a pad on a rigid disc or an oscillator on a belt.

    Where ``stable`` is true and there is a cycle, both last: which of them a motion goes to depends on where it starts. So
    a sweep up stays on the cycle until that ends, and a sweep down in steady sliding until that is unstable.

    Parameters
    ----------
    along
        The parameter, for example ``"rotating_speed"``, or ``"belt_speed"`` of a job with an oscillator on a belt.
    values
        Its values.
    parameters, job, cell
        As for :func:`analyse`.

    Returns
    -------
    table
        A row for each value: ``stable``, ``x`` in steady sliding, ``x_min``, ``x_max``, ``period`` and ``stick_fraction`` of
        the limit cycle, which have no value where there is none. They are scaled, or for a belt in m and s.
    """
    values = [float(value) for value in values]
    answers = [analyse({**(parameters or {}), along: value}, job=job, cell=cell) for value in values]
    if any("limit_cycle" not in answer for answer in answers):
        raise TypeError("a model given by matrices is linear: it has no limit cycle to follow")
    import pyarrow

    def field(name: str, unit: str, meaning: str, type_of: pyarrow.DataType) -> pyarrow.Field:
        return pyarrow.field(name, type_of, metadata={"unit": unit, "long_name": meaning})

    length, time = ("m", "s") if answers and "belt_speed" in answers[0] else ("1", "1")
    units = {"x": length, "x_min": length, "x_max": length, "period": time, "stick_fraction": "1"}
    taken = [[(answer[part] or {}).get(key) for answer in answers] for _, (part, key), _ in _TAKEN]
    fields = [field(name, units[name], meaning, pyarrow.float64()) for name, _, meaning in _TAKEN]
    unit, meaning = _FOLLOWED.get(along, ("SI", along))
    table = pyarrow.Table.from_arrays(
        [
            pyarrow.array(values, pyarrow.float64()),
            pyarrow.array([answer["stable"] for answer in answers], pyarrow.bool_()),
            *(pyarrow.array(column, pyarrow.float64()) for column in taken),
        ],
        schema=pyarrow.schema(
            [
                field(along, unit, meaning, pyarrow.float64()),
                field("stable", "1", "whether steady sliding is stable", pyarrow.bool_()),
                *fields,
            ]
        ),
    )
    return converted(table, kind)
