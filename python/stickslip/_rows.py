"""Tables of other libraries, and plain Python ones, as CSV."""

from __future__ import annotations

import csv
import io
import math
import os
from collections.abc import Iterable, Mapping
from typing import Any

from ._frames import columns_of, is_frame


def csv_of(data: Any) -> str:
    """A table as CSV, its names in the first line.

    Raises
    ------
    TypeError
        If it is no table.
    ValueError
        If columns differ in length, or a value is missing; the message names its column and row.
    """
    columns = {str(name): list(values) for name, values in _columns(data).items()}
    lengths = {name: len(values) for name, values in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ValueError(f"the columns differ in length: {', '.join(f'{name} has {length}' for name, length in lengths.items())}")
    texts = [[_text(value, name, row) for row, value in enumerate(values)] for name, values in columns.items()]
    output = io.StringIO()
    writer = csv.writer(output, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*texts))
    return output.getvalue()


def _columns(data: Any) -> Mapping[Any, Iterable[Any]]:
    """The values of each column. Libraries are known by their methods, so that none has to be installed."""
    if isinstance(data, type):
        raise TypeError(f"tests are a table, not the class {data.__name__}")
    if isinstance(data, Mapping):
        return {name: _values(values, str(name)) for name, values in data.items()}
    if is_frame(data):
        return {name: _values(values, name) for name, values in columns_of(data).items()}
    if isinstance(data, Iterable) and not isinstance(data, (str, bytes, os.PathLike)):
        rows = list(data)
        if all(isinstance(row, Mapping) for row in rows):
            names = list(dict.fromkeys(name for row in rows for name in row))
            return {name: [row.get(name) for row in rows] for name in names}
    raise TypeError(
        "tests are the path of a CSV file, a DataFrame, a dict of columns or a list of dicts, "
        f"not {type(data).__name__}"
    )


def _values(values: Any, name: str) -> Iterable[Any]:
    """The values of a column as Python has them."""
    for method in ("tolist", "to_list"):
        if hasattr(values, method):
            values = getattr(values, method)()
            break
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise TypeError(f"column {name} has one value, {values!r}; give a list with one for each row")
    return values


def _text(value: Any, name: str, row: int) -> str:
    """A value as the program reads it: bools as 1 and 0, whole numbers without a point."""
    for method in ("item", "as_py"):
        if not isinstance(value, type) and hasattr(value, method):
            value = getattr(value, method)()
            break
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float) and math.isfinite(value):
        return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
    is_missing = value is None or isinstance(value, float) or str(value) in ("NaT", "<NA>")
    if is_missing:
        raise ValueError(f"column {name} has {value} in row {row} (the first is 0); give a number or leave the row out")
    return str(value)
