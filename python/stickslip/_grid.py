"""A surface over the axes of its job, as a dataset of xarray."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING, Any

from ._tables import described, footer, require

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

if TYPE_CHECKING:
    import pyarrow
    import xarray

#: The columns of axes whose name in a job is another.
COLUMNS = {"rotating_speed": "rotating_speed_rad_s"}


def dataset(table: pyarrow.Table) -> xarray.Dataset:
    """A surface over its grid.

    The axes with several values are dimensions, slowest first, as the program numbers its cells. Those with one value,
    and standard deviations that are the same in every cell, are coordinates without a dimension. Units and meanings are
    attributes of the variables; job, hash, seed and versions are attributes of the dataset.
    """
    require("xarray")
    import xarray

    columns = {name: table[name].to_numpy() for name in table.column_names}
    attributes = described(table)
    about = footer(table)
    deviations = [name for name in columns if name.startswith("std_")]
    axes = lengths(table)
    dimensions = [name for name, length in axes.items() if length > 1]
    shape = [axes[name] for name in dimensions]
    if table.num_rows != math.prod(shape):
        raise ValueError(f"the surface has {table.num_rows} rows, but its axes {axes} make {math.prod(shape)} cells")

    coordinates: dict[str, Any] = {}
    variables: dict[str, Any] = {}
    for name, values in columns.items():
        grid = values.reshape(shape)
        # What does not vary along a dimension does without it.
        if name in axes or name in deviations:
            own = [dimension for dimension in dimensions if _varies(grid, dimensions.index(dimension))]
            at = tuple(slice(None) if dimension in own else 0 for dimension in dimensions)
            coordinates[name] = (own, grid[at], attributes[name])
        else:
            variables[name] = (dimensions, grid, attributes[name])
    return xarray.Dataset(variables, coords=coordinates, attrs=about)


def lengths(table: pyarrow.Table) -> dict[str, int]:
    """How many values each axis of a surface has, by its column, slowest first."""
    job = tomllib.loads(footer(table)["job"])
    found = {COLUMNS.get(name, name): len(values) for name, values in job["axes"].items()}
    strides = {name: _stride(table[name].to_numpy()) for name in found}
    # The axis of standard deviations goes by the first input in which they vary, as in an export.
    deviations = {name: _stride(table[name].to_numpy()) for name in table.column_names if name.startswith("std_")}
    varied = {name: stride for name, stride in deviations.items() if stride < table.num_rows}
    if varied:
        first = next(iter(varied))
        found[first] = len(job["random"]["relative_std"])
        strides[first] = min(varied.values())
    return dict(sorted(found.items(), key=lambda axis: -strides[axis[0]]))


def _stride(values: Any) -> int:
    """How many cells follow each other before a value changes; all of them if it never does."""
    changed = (values != values[0]).nonzero()[0]
    return int(changed[0]) if len(changed) else len(values)


def _varies(grid: Any, dimension: int) -> bool:
    """Whether an array varies along a dimension."""
    return bool((grid != grid.take([0], axis=dimension)).any())
