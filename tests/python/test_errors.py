"""Every way in which the program fails has an error of its own, with the whole message."""

from __future__ import annotations

import json
import pickle
import subprocess
import sys
import textwrap
import time
from pathlib import Path
from typing import Any

import pytest
from conftest import LONG

import stickslip


def test_usage(small: dict[str, Any]) -> None:
    with pytest.raises(stickslip.UsageError) as caught:
        stickslip.run(small, threads=0)
    assert caught.value.exit_code == 64
    assert str(caught.value) == "invalid value '0' for 'threads': a number of threads is a whole number from 1 to 1024, for example 4"
    assert caught.value.code == "usage"
    with pytest.raises(ValueError, match="samples = 1.5 is not a whole number"):
        stickslip.run(small, samples=1.5)  # type: ignore[arg-type]
    assert set(stickslip.run(small, samples=1e3, progress=False).surface()["n_samples"]) == {1000}  # type: ignore[arg-type]


def test_a_job_that_is_not_valid_reports_all_errors(small: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    small["axes"]["preload"] = float("nan")
    small["sampling"]["sampels"] = 100
    with pytest.raises(stickslip.JobError) as caught:
        stickslip.run(small)
    assert (caught.value.exit_code, caught.value.code) == (65, "job-spec")
    assert caught.value.place == {"file": "job", "line": 9, "column": 11, "key": "axes.preload"}
    message = str(caught.value)
    assert message.startswith("job:")
    assert "axes.preload: NaN is not a finite number" in message
    assert "sampels" in message and "samples" in message
    assert "standard input" not in message
    # It is said once, by the exception.
    assert capsys.readouterr().err == ""
    assert not Path("runs").exists()


def test_a_job_without_a_name_or_that_is_no_toml(small: dict[str, Any], place: Path) -> None:
    del small["name"]
    with pytest.raises(stickslip.JobError, match="name"):
        stickslip.run(small)
    (place / "broken.toml").write_text("name = \n", encoding="utf-8")
    with pytest.raises(stickslip.JobError, match="broken.toml:1"):
        stickslip.run("broken.toml")


#: Texts that no file and no program can be given.
ODD = ["half \ud800", "\udcff", "~\ud800"]


@pytest.mark.parametrize("odd", ODD)
def test_halves_of_characters_in_a_job_are_refused_with_their_place(small: dict[str, Any], odd: str) -> None:
    for place, job in (
        ("name", {**small, "name": odd}),
        ("description", {**small, "description": odd}),
        ("axes.preload", {**small, "axes": {**small["axes"], "preload": [0.1, odd]}}),
        ("a key of axes", {**small, "axes": {odd: 1.0}}),
    ):
        with pytest.raises(stickslip.JobError, match=f"^{place}.*lone surrogate") as caught:
            stickslip.run(job)
        assert (caught.value.code, caught.value.exit_code) == ("job-spec", 65)
    with pytest.raises(stickslip.JobError, match="lone surrogate"):
        stickslip.analyse({"friction": {"law": odd}})
    with pytest.raises(stickslip.JobError, match="^data: .*lone surrogate"):
        stickslip.fit({"preload": [odd]}, small)


@pytest.mark.parametrize("odd", ["half \ud800", "nul\0", "~\0", "~\ud800"])
def test_names_that_cannot_be_are_refused(small: dict[str, Any], odd: str) -> None:
    with pytest.raises(stickslip.JobError, match="^the job: .*what no name can"):
        stickslip.run(odd)
    with pytest.raises(stickslip.JobError, match="^model.x: .*what no name can"):
        stickslip.check({**small, "model": {"x": Path(odd)}})
    for ask in (
        lambda: stickslip.run(small, odd),
        lambda: stickslip.Run(odd),
        lambda: stickslip.analyse({odd: 1}),
        lambda: stickslip.limit(small, odd, 0.1),
        lambda: stickslip.compare(odd, odd),
        lambda: stickslip.fit(odd, small),
    ):
        with pytest.raises(stickslip.UsageError, match="holds what no name can") as caught:
            ask()
        assert caught.value.exit_code == 64


def test_the_name_of_a_job_is_refused_before_a_directory_is_named_by_it(small: dict[str, Any], place: Path) -> None:
    for name in ("nul\0", "../elsewhere", "/elsewhere", ""):
        small["name"] = name
        with pytest.raises(stickslip.JobError, match="name"):
            stickslip.run(small)
    assert not list(place.iterdir())


def test_jobs_that_contain_themselves_or_are_too_deep_are_refused(small: dict[str, Any]) -> None:
    table: dict[str, Any] = {}
    table["again"] = table
    rows: list[Any] = []
    rows.append(rows)
    deep: list[Any] = []
    for _ in range(100_000):
        deep = [deep]
    for job in ({**small, "axes": table}, {**small, "x": rows}, {**small, "x": deep}, {**small, "model": {"mass": rows}}):
        with pytest.raises(stickslip.JobError, match="more than 50 levels; does a part of it contain itself"):
            stickslip.check(job)
    with pytest.raises(stickslip.JobError, match="more than 50 levels"):
        stickslip.analyse(table)
    with pytest.raises(stickslip.JobError, match="^sampling.seed: the whole number is too large"):
        stickslip.check({**small, "sampling": {"seed": 10**5000}})


def test_a_file_of_a_job_that_is_too_deep_is_refused(place: Path) -> None:
    (place / "deep.toml").write_text(f"x = {'[' * 5000}{']' * 5000}\n", encoding="utf-8")
    with pytest.raises(stickslip.JobError, match="deep.toml:1"):
        stickslip.run("deep.toml")


def says(*messages: dict[str, Any], code: int) -> str:
    """A program that says this and ends with a code."""
    lines = "".join(json.dumps(message) + "\n" for message in messages)
    return f"import sys\nsys.stderr.write({lines!r})\nsys.exit({code})"


@pytest.mark.parametrize(
    ("code", "kind"), [("audit", stickslip.AuditError), ("internal-error", stickslip.InternalError)]
)
def test_audit_and_internal_error_differ_by_their_code(stub: Any, code: str, kind: type[stickslip.Error]) -> None:
    stub(says({"code": "note", "text": "before"}, {"code": code, "text": "other words"}, code=70))
    with pytest.raises(kind) as caught:
        stickslip.analyse()
    assert (str(caught.value), caught.value.exit_code, caught.value.code) == ("other words", 70, code)


def test_no_word_of_the_program_decides(stub: Any, small: dict[str, Any], place: Path) -> None:
    """Whether a run goes on depends on codes alone."""
    script = """
        import json, sys
        with open("calls", "a") as calls:
            calls.write(sys.argv[2] + "\\n")
        if sys.argv[2] == "submit" and open("calls").read().count("submit") == 1:
            print(json.dumps({"code": CODE, "text": "xyzzy", "remedy": "plugh"}), file=sys.stderr)
            sys.exit(73)
        print("done")
    """
    for code, calls in (("run-unfinished", "submit resume"), ("run-to-extend", "submit resume submit")):
        stub(textwrap.dedent(script).replace("CODE", repr(code)))
        (place / "calls").unlink(missing_ok=True)
        assert stickslip.run(small).output == "done\n"
        assert (place / "calls").read_text().split() == calls.split()
    stub(textwrap.dedent(script).replace("CODE", "'cannot-create'"))
    (place / "calls").unlink()
    with pytest.raises(stickslip.CannotCreateError) as caught:
        stickslip.run(small)
    assert (caught.value.code, caught.value.remedy, str(caught.value)) == ("cannot-create", "plugh", "xyzzy")


def test_errors_cross_processes_whole(small: dict[str, Any]) -> None:
    small["axes"]["preload"] = 7
    with pytest.raises(stickslip.JobError) as caught:
        stickslip.check(small)
    copied = pickle.loads(pickle.dumps(caught.value))
    assert type(copied) is stickslip.JobError and str(copied) == str(caught.value)
    assert vars(copied) == vars(caught.value) and copied.place["key"] == "axes.preload"
    interrupted = stickslip.Interrupted("now")
    interrupted.remedy = "again"
    assert pickle.loads(pickle.dumps(interrupted)).remedy == "again"


def test_what_cannot_be_created(small: dict[str, Any], place: Path) -> None:
    (place / "taken").write_text("a file", encoding="utf-8")
    with pytest.raises(stickslip.CannotCreateError, match="taken") as caught:
        stickslip.run(small, "taken")
    assert caught.value.exit_code == 73
    assert (place / "taken").read_text(encoding="utf-8") == "a file"


def test_files_that_are_not_there(small: dict[str, Any]) -> None:
    with pytest.raises(stickslip.InputOutputError, match="cannot read nothing.toml") as caught:
        stickslip.run("nothing.toml")
    assert caught.value.exit_code == 74
    with pytest.raises(stickslip.Error, match="nothing"):
        stickslip.Run("nothing")
    stickslip.run(small, progress=False)
    with pytest.raises(stickslip.InputOutputError, match="runs is a folder of runs; name one of them"):
        stickslip.Run("runs")
    with pytest.raises(TypeError, match=r"its text is read by tomllib\.loads"):
        stickslip.run('name = "text"\n[criterion]\nkind = "eigenvalue"\n')


def test_a_run_that_is_in_use(place: Path) -> None:
    script = f"import stickslip; stickslip.run({LONG!r}, 'busy', threads=1)"
    other = subprocess.Popen([sys.executable, "-c", script], cwd=place)
    try:
        while not (place / "busy" / "job.toml").exists():
            assert other.poll() is None
            time.sleep(0.02)
        with pytest.raises(stickslip.InUseError, match="busy") as caught:
            stickslip.run(LONG, "busy", progress=False)
        assert (caught.value.exit_code, caught.value.code) == (75, "run-in-use")
        assert stickslip.Run("busy").status()["in_use"]
        with pytest.raises(FileNotFoundError, match="not finished"):
            stickslip.Run("busy").surface()
    finally:
        other.kill()
        other.wait()


def test_a_program_that_is_killed(stub: Any) -> None:
    stub("import os\nos.kill(os.getpid(), 9)")
    with pytest.raises(stickslip.Error, match="ended with code 137 without a message") as caught:
        stickslip.analyse()
    assert caught.value.exit_code == 137


def test_every_error_is_an_error() -> None:
    kinds = [getattr(stickslip, name) for name in stickslip.__all__ if name.endswith("Error")]
    assert len(kinds) == 9
    assert all(issubclass(kind, stickslip.Error) for kind in kinds)
    assert not issubclass(stickslip.Interrupted, Exception)


def test_messages_of_many_lines_are_whole(stub: Any, capsys: pytest.CaptureFixture[str]) -> None:
    text = "first\n    |\nsecond\n\n  third"
    sent = [("note", "a note"), ("warning", "odd"), ("job-spec", text)]
    stub(says(*({"code": code, "text": text} for code, text in sent), code=65))
    with pytest.warns(stickslip.JobWarning, match="^odd$"), pytest.raises(stickslip.JobError) as caught:
        stickslip.limit("job.toml", "preload", 0.1)
    assert str(caught.value) == text
    assert capsys.readouterr().err == "stickslip: a note\n"


def test_lines_that_are_no_messages_are_the_error_of_a_program_that_does_not_start(stub: Any) -> None:
    stub("import sys\nsys.stderr.write('libc.so.6: version not found\\n{\\n')\nsys.exit(1)")
    with pytest.raises(stickslip.Error) as caught:
        stickslip.analyse()
    assert str(caught.value) == "libc.so.6: version not found\n{"
    assert (caught.value.exit_code, caught.value.code) == (1, None)
