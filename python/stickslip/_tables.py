"""Parquet files of the program as tables of pyarrow, pandas and polars."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal, Union, overload

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow

#: What a table may be.
TableKind = Literal["pandas", "polars", "arrow"]
Table = Union["pandas.DataFrame", "polars.DataFrame", "pyarrow.Table"]


def read(path: str | os.PathLike[str]) -> pyarrow.Table:
    """Read a Parquet file. The metadata of the table are those in the footer of the file."""
    import pyarrow.parquet

    with pyarrow.parquet.ParquetFile(os.fspath(path)) as file:
        footer = {key: value for key, value in (file.metadata.metadata or {}).items() if key != b"ARROW:schema"}
        return file.read().replace_schema_metadata(footer or None)


def described(table: pyarrow.Table) -> dict[str, dict[str, str]]:
    """The unit (``units``) and the meaning (``long_name``) of each column."""
    columns = {}
    for field in table.schema:
        metadata = field.metadata or {}
        attributes = {"units": metadata.get(b"unit"), "long_name": metadata.get(b"long_name")}
        columns[field.name] = {key: value.decode() for key, value in attributes.items() if value is not None}
    return columns


def footer(table: pyarrow.Table) -> dict[str, str]:
    """What the footer says, without the prefix of its keys."""
    metadata: dict[bytes, bytes] = table.schema.metadata or {}
    prefix = "stickslip:"
    texts = {key.decode(): value.decode() for key, value in metadata.items()}
    return {key[len(prefix) :]: value for key, value in texts.items() if key.startswith(prefix)}


@overload
def converted(table: pyarrow.Table, kind: Literal["pandas"]) -> pandas.DataFrame: ...
@overload
def converted(table: pyarrow.Table, kind: Literal["polars"]) -> polars.DataFrame: ...
@overload
def converted(table: pyarrow.Table, kind: Literal["arrow"]) -> pyarrow.Table: ...
@overload
def converted(table: pyarrow.Table, kind: str) -> Table: ...
def converted(table: pyarrow.Table, kind: str) -> Any:
    """A table of pyarrow as one of another library.

    A DataFrame of pandas has ``attrs["units"]`` and ``attrs["long_names"]``, by column.
    """
    if kind == "arrow":
        return table
    if kind == "pandas":
        require("pandas")
        frame = table.to_pandas()
        columns = described(table)
        frame.attrs["units"] = {name: column.get("units", "1") for name, column in columns.items()}
        frame.attrs["long_names"] = {name: column.get("long_name", name) for name, column in columns.items()}
        return frame
    if kind == "polars":
        return require("polars").from_arrow(table)
    raise ValueError(f"kind = {kind!r} is not known; it is 'pandas', 'polars' or 'arrow', or 'xarray' for a surface")


def require(name: str) -> Any:
    """Import a library that not everybody needs."""
    import importlib

    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        message = f"there is no {name} here; pip install 'stickslip[{name}]', or choose another kind"
        raise ModuleNotFoundError(message, name=name) from None
