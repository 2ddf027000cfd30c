"""What a user sees at a terminal: a bar, each message once, and errors as exceptions."""

from __future__ import annotations

import os
import pty
import sys
import time
from pathlib import Path

from conftest import LONG


def at_terminal(script: str, folder: Path, *, interrupt_at: Path | None = None) -> tuple[str, int]:
    """Runs a script at a terminal, presses Ctrl-C when a file is there, and returns what is seen and the exit code."""
    child, terminal = pty.fork()
    if child == 0:
        os.chdir(folder)
        os.execv(sys.executable, [sys.executable, "-c", script])
    seen = b""
    while True:
        if interrupt_at is not None and interrupt_at.exists():
            interrupt_at = None
            time.sleep(0.7)
            os.write(terminal, b"\x03")
        try:
            data = os.read(terminal, 1 << 16)
        except OSError:
            data = b""
        if not data:
            break
        seen += data
    # Ctrl-C drops what the terminal has not passed on, which may end within a character.
    _, status = os.waitpid(child, 0)
    os.close(terminal)
    return seen.decode(errors="replace"), os.waitstatus_to_exitcode(status)


def test_ctrl_c_at_a_terminal(place: Path) -> None:
    script = f"""
import stickslip
try:
    stickslip.run({LONG!r}, 'long', threads=1)
except stickslip.Interrupted as interrupted:
    print('CAUGHT', interrupted)
    interrupted.run.resume()
"""
    seen, code = at_terminal(script, place, interrupt_at=place / "long" / "job.toml")
    assert code == 0, seen
    before, after = seen.split("CAUGHT")
    for bar in (before, after):
        assert "░" in bar and "samples/s" in bar
    assert seen.count("interrupted: saving what is finished") == 1
    # The message of the end is that of the exception, and is not shown besides.
    assert "samples are kept" not in before and "samples are kept; continue with" in after
    assert (place / "long" / "surface.parquet").is_file()


def test_an_error_at_a_terminal_is_said_once(place: Path) -> None:
    script = """
import stickslip
job = {"name": "x", "axes": {"preload": 7, "rotating_speed": 2000}, "criterion": {"kind": "eigenvalue"}}
try:
    stickslip.run(job)
except stickslip.JobError as error:
    print('CAUGHT', repr(str(error)))
job["axes"]["preload"] = 0.1
stickslip.run(job)
try:
    stickslip.run(job, threads=0)
except stickslip.UsageError as error:
    print('CAUGHT', repr(str(error)))
"""
    seen, code = at_terminal(script, place)
    assert code == 0, seen
    assert seen.count("7 is out of range") == 1
    assert "CAUGHT 'job:4:11: axes.preload: 7 is out of range" in seen
    assert seen.count("JobWarning: axes.rotating_speed = 2000 rad/s is not plausible") == 1
    assert "stickslip: warning" not in seen
    assert "CAUGHT \"invalid value '0' for '--threads <N>': 0 is not in 1..=1024\"" in seen
    assert "10,000 samples in" in seen
