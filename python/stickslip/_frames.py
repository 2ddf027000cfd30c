"""Tables of other libraries, known by their methods, so that none has to be installed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def is_frame(data: Any) -> bool:
    """Whether something is a table of pyarrow, pandas, polars or the like, no class of one."""
    is_table = hasattr(data, "to_pydict") or (hasattr(data, "columns") and hasattr(data, "__getitem__"))
    return is_table and not isinstance(data, (type, Mapping))


def columns_of(frame: Any) -> dict[str, Any]:
    """The columns of a table by their names.

    Raises
    ------
    ValueError
        If two columns have the same name.
    """
    if hasattr(frame, "to_pydict"):
        return {str(name): values for name, values in frame.to_pydict().items()}
    names = list(frame.columns)
    if len(set(names)) < len(names):
        raise ValueError(f"two columns have the same name: {', '.join(map(str, names))}")
    return {str(name): frame[name] for name in names}
