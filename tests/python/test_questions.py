"""Questions that need no run."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import polars
import pyarrow
import pytest
import tomli_w

import stickslip


def printed(*arguments: str) -> Any:
    """What the program prints as JSON."""
    command = [stickslip.program(), *arguments, "--json"]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def test_analyse_is_the_programs(small: dict[str, Any], place: Path) -> None:
    # The critical speed of the preset, rounded in docs/how-to/simulate-in-time.md.
    assert stickslip.analyse()["critical_speed_rad_s"] == pytest.approx(15.5599, abs=5e-5)
    wanted = printed("analyse", "--set", "friction.static_coefficient=0.45", "--set", "pad.mass=0.12")
    assert stickslip.analyse(friction={"static_coefficient": 0.45}, pad={"mass": np.float64(0.12)}) == wanted
    assert stickslip.analyse({"friction.static_coefficient": 0.45, "pad.mass": 0.12}) == wanted
    assert stickslip.analyse({"friction": {"static_coefficient": 0.45}}, pad={"mass": 0.12}) == wanted
    (place / "small.toml").write_text(tomli_w.dumps(small), encoding="utf-8")
    wanted = printed("analyse", "--job", "small.toml", "--cell", "3")
    run = stickslip.run(small, progress=False)
    for job in (small, "small.toml", Path("small.toml"), run):
        assert stickslip.analyse(job=job, cell=3) == wanted
        assert stickslip.analyse(job, cell=3) == wanted
    with pytest.raises(TypeError, match="a job is given twice"):
        stickslip.analyse("small.toml", job=small)
    with pytest.raises(stickslip.UsageError, match="friction.statik"):
        stickslip.analyse(friction={"statik": 0.4})
    with pytest.raises(TypeError, match="pad.mass: .* is a list"):
        stickslip.analyse(pad={"mass": [0.1, 0.2]})
    with pytest.raises(TypeError, match="a job is a dict or the path of a TOML file, not int"):
        stickslip.analyse(job=3)  # type: ignore[arg-type]


BELT: dict[str, Any] = {
    "name": "belt",
    "model": {
        "kind": "belt-oscillator",
        "mass": 1.0,
        "stiffness": 1.0,
        "damping": 0.1,
        "normal_force": 1.0,
        "belt_speed": 1.3,
        "friction": {"static_coefficient": 0.6, "kinetic_coefficient": 0.3, "stribeck_velocity": 0.5},
    },
    "criterion": {"kind": "eigenvalue"},
}


def test_analyse_takes_values_of_the_model_of_a_job() -> None:
    # The friction falls by more than the damping below v_s ln((f_s - f_c) N / (v_s c)).
    critical = 0.5 * np.log(0.3 / 0.5 / 0.1)
    for speed, stable in [(critical - 0.01, False), (critical + 0.01, True)]:
        answer = stickslip.analyse(BELT, belt_speed=speed)
        assert answer["belt_speed"] == speed and answer["stable"] is stable
        assert answer["critical_speed"] == pytest.approx(critical, abs=1e-12)
    with pytest.raises(stickslip.UsageError, match="did you mean belt_speed"):
        stickslip.analyse(BELT, belt_sped=1.0)


def test_a_bifurcation_has_a_row_for_each_value() -> None:
    speeds = np.linspace(0.2, 1.6, 8)
    sweep = stickslip.bifurcation("belt_speed", speeds, job=BELT)
    assert sweep["belt_speed"].to_list() == list(speeds)
    answers = [stickslip.analyse(BELT, belt_speed=speed) for speed in speeds]
    assert sweep["stable"].to_list() == [answer["stable"] for answer in answers]
    # There is a cycle below the end of stick-slip, above the critical speed as well.
    end = answers[0]["end_of_cycles"]
    assert sweep["x_max"].notna().to_list() == [bool(speed < end) for speed in speeds]
    both = sweep[sweep["stable"] & sweep["x_max"].notna()]
    assert len(both) == 2 and (both["x_min"] < both["x"]).all() and (both["x"] < both["x_max"]).all()
    assert sweep.attrs["units"]["x_max"] == "m"
    pad = stickslip.bifurcation("rotating_speed", [10, 35], {"pad.mass": 0.12}, kind="arrow")
    assert pad.column_names == ["rotating_speed", "stable", "x", "x_min", "x_max", "period", "stick_fraction"]
    assert pad["x_max"].null_count == 1 and pad["stable"].to_pylist() == [False, True]
    assert stickslip.bifurcation("belt_speed", [], job=BELT, kind="polars").height == 0
    linear = {
        "name": "masses",
        "model": {"kind": "matrices", "mass": np.eye(1), "stiffness": np.eye(1), "parameters": {"friction": 0.7}},
        "criterion": {"kind": "complex-eigenvalue"},
    }
    with pytest.raises(TypeError, match="no limit cycle"):
        stickslip.bifurcation("friction", [0.5], job=linear)


def test_a_motion_has_a_summary_a_table_and_a_plot(place: Path) -> None:
    motion = stickslip.trajectory(operating_point={"rotating_speed": 10.0}, disc="rigid", start={"velocity": 0.1})
    assert motion.summary["verdict"] == "unstable" and motion.summary["disc"] == "rigid"
    assert "file" not in motion.summary
    table = motion.table()
    assert len(table) == motion.summary["moments"]
    assert table["x_speed_m_s"][0] == pytest.approx(0.1)
    # The settled motion is the last quarter.
    settled = table["x_mm"][-len(table) // 4 :]
    assert (settled.max() - settled.min()) / 2 == pytest.approx(motion.summary["amplitude_mm"], rel=1e-2)
    assert motion.table("arrow").num_rows == motion.table("polars").height == len(table)
    assert "verdict='unstable'" in repr(motion)
    part = motion.plot(start=1e-3, end=2e-3, title="A millisecond", out="part.svg")
    assert part.svg is not None and "A millisecond" in part.svg.read_text()
    plot = motion.plot()
    assert plot.svg is not None and plot.svg.is_file()
    del motion
    assert plot.svg.is_file()
    assert stickslip.trajectory(horizon=50, disc="rigid").plot(out="motion.svg").svg == place / "motion.svg"


def test_check_returns_cells_and_cost(small: dict[str, Any]) -> None:
    answer = stickslip.check(small, threads=1)
    assert answer["cells"] == 24 and answer["samples_at_most"] == 24_000
    assert answer["seconds_of_a_sample"] > 0
    assert answer["seconds_low"] < answer["seconds"] < answer["seconds_high"]
    assert 0 < answer["seconds_of_set_up"] < answer["seconds"] and answer["not_known_because"] is None
    with pytest.raises(stickslip.JobError):
        stickslip.check({"name": "nothing"})


def test_limits_are_where_the_probability_is_the_target(
    small: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    small["sampling"] = {"method": "exact"}
    small["axes"]["rotating_speed"] = 15.0
    table = stickslip.limit(small, "preload", [0.2, 0.4])
    assert len(table) == 8 and set(table["target"]) == {0.2, 0.4}
    row = table[table["state"] == "rises"].iloc[0]
    there = {**small, "name": "there", "axes": {"static_friction": row["static_friction"], "preload": row["limit"]}}
    there["axes"]["rotating_speed"] = 15.0
    p = stickslip.run(there, progress=False).surface()["p_unstable"][0]
    assert p == pytest.approx(row["target"], abs=1e-9)
    run = stickslip.run(small, progress=False)
    assert stickslip.limit(run, of="preload", probability=np.float64(0.4), kind="arrow").num_rows == 4
    # No word of the file in between.
    assert "parquet" not in capsys.readouterr().err


def test_compare_returns_the_differences(small: dict[str, Any]) -> None:
    first = stickslip.run(small, "first", progress=False)
    small["model"] = {"friction": {"stribeck_velocity": 0.6}}
    second = stickslip.run(small, "second", progress=False)
    comparison = stickslip.compare(first, "second", progress=False, confidence=0.9)
    table = comparison.table()
    assert comparison.summary[0]["confidence"] == 0.9 and len(table) == 24
    wanted = second.surface()["p_unstable"] - first.surface()["p_unstable"]
    assert np.allclose(table["difference"], wanted, atol=1e-12) and wanted.abs().max() > 0.1
    assert comparison.summary[0]["mean_difference"] == pytest.approx(wanted.mean(), abs=1e-12)


def test_fit_finds_the_friction_of_tests(small: dict[str, Any], place: Path) -> None:
    counts = [(13, 39, 1), (14, 35, 5), (15, 30, 10), (16, 19, 21), (17, 7, 33), (18, 2, 38)]
    rows = ["rotating_speed,preload,squealed,count"]
    for speed, squealed, silent in counts:
        rows += [f"{speed},0.1,1,{squealed}", f"{speed},0.1,0,{silent}"]
    (place / "tests.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    small["axes"] = {"rotating_speed": [12.0, 15.0, 18.0], "preload": 0.1, "static_friction": 0.39}
    small["random"]["relative_std"] = {"preload": 0.05, "static_friction": 0.1}
    small["sampling"] = {"method": "exact"}
    answer = stickslip.fit("tests.csv", small, out="fitted.toml")
    # The figures are those of docs/how-to/fit-to-tests.md.
    assert answer["tests"] == 240 and answer["squealed"] == 132
    assert answer["estimates"]["static_friction"]["value"] == pytest.approx(0.4011, abs=5e-5)
    assert answer["estimates"]["std.static_friction"]["low"] == pytest.approx(0.0754, abs=5e-5)
    assert stickslip.check("fitted.toml")["name"] == "small-fitted"
    one = stickslip.fit("tests.csv", small, estimate=["static_friction"], plot="fit.svg")
    assert list(one["estimates"]) == ["static_friction"]
    assert (place / "fit.svg").read_text(encoding="utf-8").startswith("<svg ")


def _tests() -> dict[str, list[Any]]:
    """The tests of docs/how-to/fit-to-tests.md, by column."""
    squealed, silent = [39, 35, 30, 19, 7, 2], [1, 5, 10, 21, 33, 38]
    return {
        "rotating_speed": [13, 14, 15, 16, 17, 18] * 2,
        "preload": [0.1] * 12,
        "squealed": [True] * 6 + [False] * 6,
        "count": squealed + silent,
    }


@pytest.fixture
def tested(small: dict[str, Any]) -> dict[str, Any]:
    small["axes"] = {"rotating_speed": [12.0, 15.0, 18.0], "preload": 0.1, "static_friction": 0.39}
    small["random"]["relative_std"] = {"preload": 0.05, "static_friction": 0.1}
    small["sampling"] = {"method": "exact"}
    return small


def test_fit_takes_tables_of_all_kinds(tested: dict[str, Any], place: Path) -> None:
    columns = _tests()
    floats = pandas.DataFrame(columns).astype({"count": float, "squealed": int})
    tables: list[Any] = [
        columns,
        {name: np.array(values) for name, values in columns.items()},
        [dict(zip(columns, row)) for row in zip(*columns.values())],
        pandas.DataFrame(columns),
        floats[floats["rotating_speed"] > 0].sort_values("count"),
        polars.DataFrame(columns),
        pyarrow.table(columns),
    ]
    for table in tables:
        answer = stickslip.fit(table, tested)
        assert answer["tests"] == 240 and answer["data"] is None, type(table)
        assert answer["estimates"]["static_friction"]["value"] == pytest.approx(0.4011, abs=5e-5), type(table)
    speeds, censored = [15.2, 16.3, 14.1, 17.1, 12.0], [False] * 4 + [True]
    onsets = pandas.DataFrame({"onset_speed": speeds, "preload": 0.1, "censored": censored})
    assert stickslip.fit(onsets, tested, out="fitted.toml")["kind"] == "onset"
    first = (place / "fitted.toml").read_text(encoding="utf-8").splitlines()[0]
    assert first.startswith("# Written by stickslip fit from the tests of a Python session and the job "), first


def test_fit_says_what_is_wrong_in_a_table(tested: dict[str, Any]) -> None:
    columns = _tests()
    with pytest.raises(ValueError, match=r"column preload has nan in row 1 \(the first is 0\)"):
        stickslip.fit(pandas.DataFrame({**columns, "preload": [0.1, None] + [0.1] * 10}), tested)
    with pytest.raises(ValueError, match="column count has None in row 2"):
        stickslip.fit([*({**row, "count": 1} for row in [{"preload": 0.1}] * 2), {"preload": 0.1}], tested)
    with pytest.raises(ValueError, match="preload has 11"):
        stickslip.fit({**columns, "preload": [0.1] * 11}, tested)
    with pytest.raises(ValueError, match="two columns have the same name"):
        stickslip.fit(pandas.DataFrame([[1, 2]], columns=["preload", "preload"]), tested)
    with pytest.raises(TypeError, match="column preload has one value, 0.1"):
        stickslip.fit({**columns, "preload": 0.1}, tested)
    with pytest.raises(TypeError, match="not int"):
        stickslip.fit(3, tested)  # type: ignore[arg-type]
    with pytest.raises(stickslip.JobError, match=r"^data:4: preload = 35000 is out of range") as raised:
        stickslip.fit(polars.DataFrame({**columns, "preload": [0.1, 0.1, 35000.0] + [0.1] * 9}), tested)
    assert raised.value.place == {"file": "data", "line": 4}
