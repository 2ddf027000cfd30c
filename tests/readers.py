"""Reads a surface with the readers that the documents show.

    python readers.py runs/fig14a/surface.parquet
"""

import sys
from pathlib import Path

import duckdb
import pandas
import polars
import pyarrow.parquet

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
print("pandas, polars, DuckDB and pyarrow agree")
