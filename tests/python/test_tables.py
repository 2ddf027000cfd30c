"""Surfaces as tables and datasets."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import xarray as xr

import stickslip


def test_every_kind_has_the_same_numbers(small: dict[str, Any]) -> None:
    run = stickslip.run(small, progress=False)
    table = run.surface("arrow")
    assert isinstance(table, pa.Table)
    assert table.schema.metadata[b"stickslip:seed"] == b"7"
    assert table.equals(pq.read_table(run.path / "surface.parquet"))
    frame = run.surface()
    assert list(frame.columns) == table.column_names
    assert frame["p_unstable"].to_list() == table["p_unstable"].to_pylist()
    assert frame.attrs["units"]["rotating_speed_rad_s"] == "rad/s"
    assert frame.attrs["long_names"]["n_samples"] == "samples"
    other = run.surface("polars")
    assert isinstance(other, pl.DataFrame)
    assert other["p_unstable"].to_list() == table["p_unstable"].to_pylist()
    with pytest.raises(ValueError, match="kind = 'excel' is not known"):
        run.surface("excel")  # type: ignore[call-overload]


def test_a_dataset_has_the_axes_of_the_job_in_their_order(small: dict[str, Any]) -> None:
    small["axes"]["pad.mass"] = [0.1, 0.12]
    small["axes"]["rotating_speed"] = [20.0, 10.0, 15.0]
    small["random"]["relative_std"] = [
        {"preload": 0.2, "static_friction": 0.1},
        {"preload": 0.2, "static_friction": 0.05},
    ]
    run = stickslip.run(small, progress=False)
    data = run.surface("xarray")
    assert isinstance(data, xr.Dataset)
    wanted = {"pad.mass": 2, "rotating_speed_rad_s": 3, "std_static_friction": 2, "preload": 2, "static_friction": 4}
    assert dict(data["p_unstable"].sizes) == wanted
    assert list(data["p_unstable"].dims) == list(wanted)
    assert data["rotating_speed_rad_s"].values.tolist() == [20.0, 10.0, 15.0]
    assert data["std_static_friction"].values.tolist() == [0.1, 0.05]
    assert data["std_preload"].dims == () and float(data["std_preload"]) == 0.2

    # Every cell is where its coordinates say.
    for _, row in run.surface().iterrows():
        place = {name: row[name] for name in wanted}
        cell = data.sel(place)
        assert int(cell["cell"]) == row["cell"]
        assert float(cell["p_unstable"]) == row["p_unstable"]


def test_a_dataset_has_units_and_meanings(small: dict[str, Any]) -> None:
    small["axes"]["preload"] = 0.1
    data = stickslip.run(small, progress=False).surface("xarray")
    assert data["p_unstable"].dims == ("rotating_speed_rad_s", "static_friction")
    assert data["rotating_speed_rad_s"].attrs == {"units": "rad/s", "long_name": "rotating speed of the disc"}
    assert data["p_unstable"].attrs["long_name"].startswith("probability of instability")
    assert float(data["preload"]) == 0.1 and data["preload"].dims == ()
    assert data.attrs["seed"] == "7" and len(data.attrs["job_hash"]) == 64
    assert data["n_samples"].dtype == np.int64


def test_standard_deviations_that_vary_twice_are_one_axis(small: dict[str, Any]) -> None:
    entries = [(0.1, 0.1), (0.2, 0.1), (0.1, 0.2)]
    small["random"]["relative_std"] = [{"preload": a, "static_friction": b} for a, b in entries]
    data = stickslip.run(small, progress=False).surface("xarray")
    assert data.sizes["std_preload"] == 3
    assert data["std_preload"].values.tolist() == [0.1, 0.2, 0.1]
    assert data["std_static_friction"].dims == ("std_preload",)
    assert data["std_static_friction"].values.tolist() == [0.1, 0.1, 0.2]


def test_a_dataset_of_another_model(small: dict[str, Any]) -> None:
    small["model"] = {"kind": "belt-oscillator", "mass": 1.0, "stiffness": 1.0, "damping": 0.05}
    small["model"]["friction"] = {"kinetic_coefficient": 0.5, "stribeck_velocity": 1.0}
    small["axes"] = {"normal_force": [1.0, 2.0], "belt_speed": [2.0, 1.0, 1.5], "static_coefficient": [0.8, 1.0]}
    small["random"] = {"inputs": ["normal_force", "belt_speed"]}
    small["random"]["relative_std"] = [{"normal_force": 0.1, "belt_speed": 0.1}, {"normal_force": 0.1, "belt_speed": 0.2}]
    run = stickslip.run(small, progress=False)
    data = run.surface("xarray")
    wanted = {"normal_force": 2, "belt_speed": 3, "static_coefficient": 2, "std_belt_speed": 2}
    assert dict(data["p_unstable"].sizes) == wanted
    for _, row in run.surface().iterrows():
        cell = data.sel({name: row[name] for name in wanted})
        assert int(cell["cell"]) == row["cell"]


def test_a_force_in_place_of_the_preload(small: dict[str, Any]) -> None:
    del small["axes"]["preload"]
    small["axes"]["preload_force"] = [20_000.0, 35_000.0]
    data = stickslip.run(small, progress=False).surface("xarray")
    assert dict(data.sizes) == {"rotating_speed_rad_s": 3, "preload": 2, "static_friction": 4}
    assert np.allclose(data["preload"], np.array([20_000.0, 35_000.0]) / 35_097.5 * 0.1, rtol=1e-5)


def test_starts_are_axes_too(small: dict[str, Any]) -> None:
    small["axes"] = {"start.velocity": [0.0, 0.5, 1.0], "start.tangential": [0.0, 1e-4], "rotating_speed": 12.0}
    small["random"] = {"inputs": ["static_friction"], "relative_std": 0.05}
    small["criterion"] = {"kind": "time-domain", "disc": "rigid"}
    small["sampling"]["samples"] = 10
    run = stickslip.run(small, progress=False)
    data = run.surface("xarray")
    assert sorted(data.sizes.values()) == [2, 3]
    for _, row in run.surface().iterrows():
        cell = data.sel({name: row[name] for name in data.sizes})
        assert int(cell["cell"]) == row["cell"]


def test_a_single_cell_and_missing_values(small: dict[str, Any]) -> None:
    small["axes"] = {"preload": 0.1}
    data = stickslip.run(small, progress=False).surface("xarray")
    assert data["p_unstable"].dims == ()
    # So little is sampled that nothing unstable is found: the probability is null.
    small["name"] = "rare"
    small["axes"] = {"rotating_speed": 80.0}
    small["random"] = {"inputs": ["preload", "static_friction"], "relative_std": 0.01}
    small["sampling"] = {"method": "importance", "samples": 1024}
    run = stickslip.run(small, progress=False)
    assert int(run.surface("xarray")["distrust"]) == 1
    assert np.isnan(run.surface("xarray")["p_unstable"])
    assert run.surface("polars")["p_unstable"].to_list() == [None]


def test_a_library_that_is_missing_is_named(small: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    run = stickslip.run(small, progress=False)
    for name in ("pandas", "polars", "xarray"):
        monkeypatch.setitem(sys.modules, name, None)
        with pytest.raises(ModuleNotFoundError, match=rf"pip install 'stickslip\[{name}\]'"):
            run.surface(name)  # type: ignore[call-overload]
    assert run.surface("arrow").num_rows == 24
