"""Reads a surface, and the samples of one of its cells, with the readers that the documents show.

    python readers.py runs/fig14a/surface.parquet runs/fig14a/samples-400.parquet
"""

import sys
from pathlib import Path

import duckdb
import pandas
import polars
import pyarrow.parquet
import xarray

surface = Path(sys.argv[1]).resolve()

frame = pandas.read_parquet(surface)
assert len(frame) == 780, len(frame)
assert list(frame["cell"]) == list(range(780))
assert frame.dtypes["cell"] == "int64" and frame.dtypes["p_unstable"] == "float64", frame.dtypes
assert not frame.isna().any().any()
counts = frame[["n_stable", "n_unstable", "n_undecided", "n_failed"]].sum(axis=1)
assert (counts == frame["n_samples"]).all() and (frame["n_samples"] == 10_000).all()
assert (frame["p_unstable"] == frame["n_unstable"] / (frame["n_stable"] + frame["n_unstable"])).all()
assert ((frame["p_low"] <= frame["p_unstable"]) & (frame["p_unstable"] <= frame["p_high"])).all()
assert frame["preload"].min() == 0.01 and frame["preload"].max() == 0.30
assert frame["static_friction"].min() == 0.25 and frame["static_friction"].max() == 0.50

lazy = polars.read_parquet(surface)
assert lazy.shape == (780, 15), lazy.shape
assert lazy["n_unstable"].to_list() == frame["n_unstable"].tolist()

lazy = polars.scan_parquet(surface).filter(polars.col("preload") == 0.1).select("cell", "p_low").collect()
assert lazy["cell"].to_list() == list(range(9 * 26, 10 * 26))
assert lazy["p_low"].to_list() == frame["p_low"][frame["preload"] == 0.1].tolist()

grid = xarray.Dataset.from_dataframe(frame.set_index(["preload", "static_friction"]))
assert dict(grid.sizes) == {"preload": 30, "static_friction": 26}, grid.sizes
assert (grid["p_unstable"].values.ravel() == frame["p_unstable"]).all()
cell = frame.iloc[400]
assert float(grid["p_unstable"].sel(preload=cell["preload"], static_friction=cell["static_friction"])) == cell["p_unstable"]
assert (grid["p_unstable"].diff("preload").mean() > 0) and (grid["p_unstable"].diff("static_friction").mean() > 0)

[(total, unstable)] = duckdb.sql(f"select count(*), sum(n_unstable) from '{surface}'").fetchall()
assert total == 780 and unstable == frame["n_unstable"].sum()

schema = pyarrow.parquet.read_schema(surface)
for field in schema:
    assert field.metadata[b"unit"] and field.metadata[b"long_name"], field
assert schema.field("rotating_speed_rad_s").metadata[b"unit"] == b"rad/s"
footer = pyarrow.parquet.read_metadata(surface).metadata
assert b'name = "fig14a"' in footer[b"stickslip:job"]
assert footer[b"stickslip:seed"] == b"2018"
assert len(footer[b"stickslip:job_hash"]) == 64
assert footer[b"stickslip:engine_version"] and footer[b"stickslip:results_version"]

samples = Path(sys.argv[2]).resolve()
verdicts = pandas.read_parquet(samples)
assert verdicts["verdict"].value_counts().to_dict() == {"stable": cell["n_stable"], "unstable": cell["n_unstable"]}
assert polars.read_parquet(samples)["verdict"].to_list() == verdicts["verdict"].tolist()
assert abs(verdicts["preload"].mean() / cell["preload"] - 1) < 5 * 0.2 / 100, "expected value, 10 000 samples"
assert abs(verdicts["static_friction"].std() / (0.2 * cell["static_friction"]) - 1) < 5 / 141
for field in pyarrow.parquet.read_schema(samples):
    assert field.metadata[b"unit"] and field.metadata[b"long_name"], field
footer = pyarrow.parquet.read_metadata(samples).metadata
assert footer[b"stickslip:cell"] == b"400" and b'name = "fig14a"' in footer[b"stickslip:job"]
print("pandas, polars, DuckDB, pyarrow and xarray agree")
