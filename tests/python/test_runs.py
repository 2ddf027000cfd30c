"""Runs: jobs as dicts and as files, what happens to a run that exists, and what can be asked of one."""

from __future__ import annotations

import json
import math
import multiprocessing
import os
import pickle
import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest
import tomli_w

import stickslip

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


def surface_bytes(run: stickslip.Run) -> bytes:
    return (run.path / "surface.parquet").read_bytes()


def test_a_job_as_dict_is_the_same_as_a_file(small: dict[str, Any], place: Path) -> None:
    (place / "small.toml").write_text(tomli_w.dumps(small), encoding="utf-8")
    from_dict = stickslip.run(small, "from dict", progress=False)
    from_text = stickslip.run("small.toml", "from file", progress=False)
    from_path = stickslip.run(Path("small.toml"), Path("from path"), False, threads=1)
    assert from_dict.path == place / "from dict"
    assert surface_bytes(from_dict) == surface_bytes(from_text) == surface_bytes(from_path)


def test_numbers_and_arrays_of_numpy_are_those_of_python(small: dict[str, Any]) -> None:
    small["axes"]["pad.mass"] = 0.1
    plain = stickslip.run(small, "plain", False)
    small["axes"] = {
        "rotating_speed": pl.Series(np.array([10.0, 15.0, 20.0])),
        "preload": (np.float64(0.1), 0.2),
        "static_friction": pd.Series([0.3, 0.35, 0.4, 0.45]),
        "pad.mass": np.array(0.1),
    }
    small["sampling"] = {"samples": np.int64(1000), "seed": np.uint8(7)}
    assert surface_bytes(stickslip.run(small, "numpy", False)) == surface_bytes(plain)


def test_a_path_in_a_job_is_one(small: dict[str, Any], place: Path) -> None:
    (place / "curve.csv").write_text("speed,coefficient\n0,0.45\n1,0.26\n3,0.24\n", encoding="utf-8")
    small["model"] = {"friction": {"law": "table", "table": place / "curve.csv"}}
    small["axes"] = {"preload": 0.1}
    small["random"] = {"inputs": ["preload"], "relative_std": 0.1}
    table = tomllib.loads(stickslip.check(small)["job"])["model"]["friction"]["table"]
    assert table["coefficient"] == [0.45, 0.26, 0.24]


@pytest.mark.parametrize(
    ("section", "key", "value", "said"),
    [
        ("axes", "preload", None, "axes.preload: None (NoneType) has no place in a job; leave the key out"),
        ("axes", "preload", [0.1, {0.2}], "axes.preload[1]: {0.2} (set)"),
        ("random", 3, 1.0, "random: the key 3 is not a str"),
        ("axes", "preload", 1 + 2j, "axes.preload: (1+2j) (complex)"),
    ],
)
def test_what_no_job_can_hold_is_named_by_its_key(
    small: dict[str, Any], section: str, key: Any, value: Any, said: str
) -> None:
    small[section][key] = value
    with pytest.raises(TypeError) as caught:
        stickslip.run(small)
    assert said in str(caught.value)


def test_the_name_of_the_job_is_that_of_the_directory(small: dict[str, Any], place: Path) -> None:
    assert stickslip.run(small, progress=False).path == place / "runs" / "small"
    (place / "other.toml").write_text(tomli_w.dumps({**small, "name": "other"}), encoding="utf-8")
    assert stickslip.run("other.toml", progress=False).path == place / "runs" / "other"


def test_the_home_directory_is_expanded(
    small: dict[str, Any], place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "job.toml").write_text(tomli_w.dumps(small), encoding="utf-8")
    assert stickslip.run("~/job.toml", "~/run", False).path == tmp_path / "run"
    assert stickslip.Run("~/run").status()["state"] == "finished"


def test_a_file_whose_name_begins_with_a_dash_is_no_option(small: dict[str, Any], place: Path) -> None:
    (place / "-job.toml").write_text(tomli_w.dumps(small), encoding="utf-8")
    assert stickslip.run("-job.toml", "-run", False).path == place / "-run"


def test_a_finished_run_is_returned(small: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    first = stickslip.run(small)
    sessions = (first.path / "run.json").read_bytes()
    again = stickslip.run(small)
    assert "is finished already; nothing to do" in capsys.readouterr().err
    assert again == first
    assert (again.path / "run.json").read_bytes() == sessions
    assert again.output == first.output != ""


def test_more_samples_extend_a_run(small: dict[str, Any]) -> None:
    stickslip.run(small, progress=False)
    run = stickslip.run(small, progress=False, samples=3000)
    assert set(run.surface()["n_samples"]) == {3000}
    # What asked for fewer runs again, as in "Restart & run all".
    with pytest.warns(stickslip.JobWarning, match="more than the 1000 of this one. Use samples=3000") as caught:
        again = stickslip.run(small, progress=False)
    assert caught[0].filename == __file__
    assert again == run and set(again.surface()["n_samples"]) == {3000}
    with pytest.warns(stickslip.JobWarning):
        assert stickslip.run(small, run, progress=False) == run


def test_another_seed_is_another_run(small: dict[str, Any]) -> None:
    run = stickslip.run(small, "run", progress=False)
    with pytest.raises(stickslip.JobError, match="it has `sampling.seed = 7`, the job has `sampling.seed = 8`"):
        stickslip.run(small, "run", progress=False, seed=8)
    other = stickslip.run(small, "other", progress=False, seed=8)
    assert not run.surface()["p_unstable"].equals(other.surface()["p_unstable"])


def test_the_key_that_differs_is_named_whole(small: dict[str, Any]) -> None:
    stickslip.run(small, "run", progress=False)
    small["random"]["relative_std"]["preload"] = 0.3
    with pytest.raises(stickslip.JobError) as caught:
        stickslip.run(small, "run", progress=False)
    assert "`random.relative_std = [{ preload = 0.2, static_friction = 0.1 }]`" in str(caught.value)
    assert "Choose another directory with out=, or replace that run with overwrite=True" in str(caught.value)
    assert "--" not in str(caught.value) and caught.value.remedy == "out="


def test_a_loop_under_one_name_keeps_every_run(
    small: dict[str, Any], place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def loop() -> list[stickslip.Run]:
        runs = []
        for scatter in (0.1, 0.2, 0.3):
            small["random"]["relative_std"] = scatter
            runs.append(stickslip.run(small))
        return runs

    first = loop()
    said = capsys.readouterr().err
    records = [(run.path / "run.json").read_bytes() for run in first]
    assert len(set(first)) == 3 and first[0].path == place / "runs" / "small"
    assert all(run.path.parent == place / "runs" and run.path.name.startswith("small-") for run in first[1:])
    assert f"holds a run of another job; this one goes to {first[1].path}" in said
    assert len({surface_bytes(run) for run in first}) == 3
    assert loop() == first
    assert [(run.path / "run.json").read_bytes() for run in first] == records
    # One with more samples goes on where it is.
    more = stickslip.run(small, samples=2000, progress=False)
    assert more == first[2] and set(more.surface()["n_samples"]) == {2000}


def test_jobs_of_one_name_run_at_the_same_time(small: dict[str, Any]) -> None:
    def work(seed: int) -> stickslip.Run:
        return stickslip.run(small, progress=False, threads=1, seed=seed)

    with ThreadPoolExecutor(4) as pool:
        runs = list(pool.map(work, range(8)))
    assert len(set(runs)) == 8
    assert len({surface_bytes(run) for run in runs}) == 8


def test_a_run_is_overwritten(small: dict[str, Any], place: Path) -> None:
    run = stickslip.run(small, progress=False, samples=3000)
    run.plot()
    run.report()
    (run.path / "notes.txt").write_text("mine", encoding="utf-8")
    small["axes"]["preload"] = [0.1, 0.15, 0.2]
    other = stickslip.run(small, progress=False, overwrite=True)
    assert other == run and len(other.surface()) == 36 and set(other.surface()["n_samples"]) == {1000}
    left = {file.name for file in run.path.iterdir()}
    assert "notes.txt" in left and not left & {"surface.svg", "surface.png", "report.html"}
    assert surface_bytes(stickslip.run(small, "new", progress=False)) == surface_bytes(other)
    with pytest.raises(stickslip.CannotCreateError, match="is not empty and not a run directory"):
        stickslip.run(small, place, progress=False, overwrite=True)


def test_numbers_with_an_exponent_are_whole(small: dict[str, Any]) -> None:
    small["sampling"]["samples"] = 1e4
    small["axes"]["static_friction"]["points"] = 4.0
    assert set(stickslip.run(small, progress=False).surface()["n_samples"]) == {10_000}
    small["sampling"]["samples"] = 1e4 + 0.5
    with pytest.raises(stickslip.JobError, match="sampling.samples is 10000.5; it must be a whole number"):
        stickslip.run(small, progress=False)


@pytest.mark.parametrize("frame", [pd.DataFrame, pl.DataFrame, pa.table, dict])
def test_a_friction_curve_is_a_frame(small: dict[str, Any], frame: Any) -> None:
    curve = {"speed": [0.0, 1.0, 3.0], "coefficient": [0.45, 0.26, 0.24]}
    small["model"] = {"friction": {"law": "table", "table": frame(curve)}}
    small["axes"] = {"preload": 0.1}
    small["random"] = {"inputs": ["preload"], "relative_std": 0.1}
    table = tomllib.loads(stickslip.check(small)["job"])["model"]["friction"]["table"]
    assert table == curve


def test_progress_and_output(small: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    run = stickslip.run(small)
    shown = capsys.readouterr()
    assert "stickslip: 24,000 samples in" in shown.err
    assert shown.out == ""
    assert "Probability of instability" in run.output
    assert "24 cells, 1,000 samples each, seed 7" in run.output
    assert "<pre" in run._repr_html_() and "24 cells" in run._repr_html_()
    stickslip.run(small, "quiet", progress=False)
    assert capsys.readouterr() == ("", "")


def test_what_can_be_asked_of_a_run(small: dict[str, Any], place: Path) -> None:
    small["limit"] = {"of": "preload", "probability": [0.5]}
    run = stickslip.run(small, progress=False)
    opened = stickslip.Run("runs/small")
    assert opened == run and opened.output == ""
    assert opened.status()["samples_done"] == 24_000
    assert opened.verify()["state"] == "sound"
    assert opened.resume(progress=False).output == run.output

    limits = opened.limits()
    assert list(limits["target"].unique()) == [0.5] and len(limits) == 12

    exported = opened.export("json")
    assert exported == run.path / "surface.json"
    columns = json.loads(exported.read_text(encoding="utf-8"))["columns"]
    assert columns["p_unstable"]["values"] == list(opened.surface()["p_unstable"])
    assert opened.export("csv", "new.csv") == place / "new.csv"

    samples = opened.samples(5, progress=False)
    row = opened.surface().set_index("cell").loc[5]
    assert len(samples) == 1000 and (samples["verdict"] == "unstable").sum() == row["n_unstable"]
    assert not list(run.path.glob("samples-*"))

    replayed = opened.replay(5, 3)
    assert replayed.summary["verdict_in_run"] == samples["verdict"][3]


def test_pictures_and_reports_show_themselves(small: dict[str, Any], place: Path) -> None:
    run = stickslip.run(small, progress=False)
    plot = run.plot()
    assert plot.svg == run.path / "surface.svg" and plot.png == run.path / "surface.png"
    bundle = plot._repr_mimebundle_()
    assert bundle["image/svg+xml"].startswith("<svg") or "<svg" in bundle["image/svg+xml"][:200]
    alone = run.plot(columns=1, out="one.png")
    assert (alone.svg, alone.png) == (None, place / "one.png")
    assert alone._repr_mimebundle_()["image/png"].startswith("iVBOR")

    scatter = run.plot(of="samples", x="static_friction", y="preload", samples=1e2, title="Brakes", out="scatter.pdf")
    assert scatter.pdf == place / "scatter.pdf" and scatter.pdf.read_bytes().startswith(b"%PDF")
    assert run.plot(of="inputs").svg == run.path / "inputs.svg"
    with pytest.raises(stickslip.JobError, match="nothing"):
        run.plot(of="distribution")

    other = stickslip.run(small, "other", progress=False, seed=8)
    assert other.plot(against=run).svg == other.path / "difference.svg"

    report = run.report()
    assert report.path == run.path / "report.html"
    assert 'href="runs/small/report.html"' in report._repr_html_()
    assert b"other" in Path(run.report("both.html", other)).read_bytes()


def test_warnings_of_the_program_are_warnings(small: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    small["axes"]["rotating_speed"] = 2000
    with pytest.warns(stickslip.JobWarning, match="did you mean 209.44") as caught:
        stickslip.run(small)
    assert caught[0].filename == __file__
    assert "warning" not in capsys.readouterr().err
    with pytest.warns(stickslip.JobWarning, match="did you mean 209.44"):
        stickslip.check(small)


def work(seed: int) -> tuple[stickslip.Run, float]:
    from conftest import SMALL

    run = stickslip.run(SMALL, f"worker {seed}", False, threads=1, seed=seed)
    return run, float(run.surface("arrow")["p_unstable"][0].as_py())


@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_runs_of_several_processes(method: str) -> None:
    with multiprocessing.get_context(method).Pool(2) as pool:
        results = pool.map(work, [1, 2, 3])
    for run, p in results:
        assert run.status()["state"] == "finished"
        assert run.surface()["p_unstable"][0] == p
    assert not math.isnan(results[0][1])


def test_runs_and_errors_go_through_pickle() -> None:
    error = pickle.loads(pickle.dumps(stickslip.JobError("wrong", 65)))
    assert (type(error), str(error), error.exit_code) == (stickslip.JobError, "wrong", 65)
    interrupted = pickle.loads(pickle.dumps(stickslip.Interrupted("stopped", None)))
    assert str(interrupted) == "stopped" and interrupted.run is None
    assert isinstance(interrupted, KeyboardInterrupt)


def test_a_surface_that_is_not_finished_or_damaged_is_not_read(small: dict[str, Any], place: Path) -> None:
    (place / "small.toml").write_text(tomli_w.dumps(small), encoding="utf-8")
    run = stickslip.run("small.toml", "run", False)
    assert set(run.surface()["n_samples"]) == {1000}
    part = [stickslip.program(), "submit", "small.toml", "--out=run", "--samples=9000", "--shard=1/2"]
    subprocess.run(part, check=True, capture_output=True)
    with pytest.raises(FileNotFoundError, match=r"the run is not finished \(unfinished\)"):
        run.surface()
    assert set(run.resume(progress=False).surface()["n_samples"]) == {9000}
    surface = run.path / "surface.parquet"
    damaged = bytearray(surface.read_bytes())
    damaged[len(damaged) // 2] ^= 1
    surface.write_bytes(bytes(damaged))
    with pytest.raises(stickslip.InputOutputError, match="damaged"):
        run.surface("arrow")


def test_warnings_that_are_errors_do_not_hide_what_ended_the_program(stub: Any) -> None:
    lines = '{"code": "warning", "text": "odd"}\n{"code": "job-spec", "text": "wrong"}\n'
    stub(f"import sys\nsys.stderr.write({lines!r})\nsys.exit(65)")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(stickslip.JobError, match="^wrong$"):
            stickslip.check({"name": "any"})


@pytest.mark.parametrize("name", ["red \x1b[31m \u202eturned", "it's\\n", os.fsdecode(b"no text \xff\n")])
def test_files_are_found_whatever_the_directory_is_called(small: dict[str, Any], name: str) -> None:
    run = stickslip.run(small, name, progress=False)
    plot = run.plot()
    assert plot.svg == run.path / "surface.svg" and plot.svg.is_file()
    assert run.report().path.is_file() and run.export("csv").is_file()
